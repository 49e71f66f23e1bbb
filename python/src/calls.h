#pragma once

#include <exception>
#include <functional>
#include <mutex>
#include <string>

#include <pybind11/pybind11.h>

#include "samara/base/progress.h"

/// Calls from the library back into Python.
namespace samara::python {

namespace py = pybind11;

/// The first exception of a Python function that long work called, from any thread: the work then ends with a status or
/// an error of its own, and its caller gets this one, with its traceback.
class Failure {
 public:
  /// Of the exception that is being handled.
  void keep();
  bool is_there() const;
  /// Once: afterwards there is none.
  void rethrow_if_any();

 private:
  mutable std::mutex mutex_;
  std::exception_ptr first_;
};

/// Tells `report` (stage, fraction), None for nobody, of progress, and looks for Ctrl-C. The work is to end where the
/// report returns False or raises, at Ctrl-C, and after another failure.
/// @param report must outlive the callback
ProgressCallback progress_to(const py::object& report, Failure& failure);

/// Tells `warn` each sentence when it comes. Python names its caller by the stack: the work is to call this on the
/// thread that began it. Where `warn` raises, as with warnings that are errors, the work is to end as after a report
/// that raises.
/// @param warn must outlive the callback
std::function<void(const std::string&)> warning_to(const py::object& warn, Failure& failure);

/// Does the work without the interpreter's lock, and raises what Python functions raised on the way in place of what
/// became of it.
template <class Work>
auto unlocked(Failure& failure, const Work& work) -> decltype(work()) {
  try {
    auto result = [&] {
      const py::gil_scoped_release release;
      return work();
    }();
    failure.rethrow_if_any();
    return result;
  } catch (...) {
    failure.rethrow_if_any();
    throw;
  }
}

}  // namespace samara::python
