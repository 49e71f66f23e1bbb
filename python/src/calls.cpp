#include "calls.h"

#include <utility>

namespace samara::python {

void Failure::keep() {
  const std::scoped_lock lock(mutex_);
  if (!first_) first_ = std::current_exception();
}

bool Failure::is_there() const {
  const std::scoped_lock lock(mutex_);
  return first_ != nullptr;
}

void Failure::rethrow_if_any() {
  std::exception_ptr thrown;
  {
    const std::scoped_lock lock(mutex_);
    thrown = std::exchange(first_, nullptr);
  }
  if (thrown) std::rethrow_exception(thrown);
}

ProgressCallback progress_to(const py::object& report, Failure& failure) {
  return [&report, &failure](const Progress& progress) {
    if (failure.is_there()) return false;
    const py::gil_scoped_acquire lock;
    try {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (report.is_none()) return true;
      // False of Python's, or NumPy's: other answers, such as None, say nothing.
      py::detail::make_caster<bool> goes_on;
      return !goes_on.load(report(progress.stage, progress.fraction), false) || static_cast<bool>(goes_on);
    } catch (...) {
      failure.keep();
      return false;
    }
  };
}

std::function<void(const std::string&)> warning_to(const py::object& warn, Failure& failure) {
  return [&warn, &failure](const std::string& sentence) {
    const py::gil_scoped_acquire lock;
    try {
      warn(sentence);
    } catch (...) {
      failure.keep();
    }
  };
}

}  // namespace samara::python
