#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "book.h"
#include "calls.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::python {

namespace {

/// The codebook of a function: `call` takes points (points, inputs and times) and gives (points, numbers), all outputs
/// at the first time, then at the second, ..
/// @param plan text of a plan with a command that describes the function
/// @returns the codebook, whether it is met, and how the build ended
py::tuple separate(const py::object& call, const std::string& plan, const py::object& progress,
                   const py::object& warn, const std::filesystem::path& checkpoint, bool resume,
                   const std::optional<int>& certificate_points) {
  Failure failure;
  const pgd::PointsFunction function = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    if (failure.is_there()) throw NoResultError("the function has raised an exception before");
    const py::gil_scoped_acquire lock;
    try {
      // Copied: the function may keep its points, and the library does not.
      const py::array_t<double> given({points.cols(), points.rows()}, points.data());
      const Array answer = Array::ensure(call(given));
      if (!answer) throw py::error_already_set();
      if (shape_of(answer) != Shape{values.cols(), values.rows()}) {
        throw ArgumentError(fmt::format("the function gave the shape {} for {} points, expected {}",
                                        shape_text(shape_of(answer)), points.cols(),
                                        shape_text({values.cols(), values.rows()})));
      }
      std::copy_n(answer.data(), answer.size(), values.data());
      return;
    } catch (...) {
      failure.keep();
    }
    throw NoResultError("the function raised an exception");
  };
  const codebooks::BuildOptions options{.certificate_points = certificate_points,
                                        .checkpoint = checkpoint,
                                        .resume = resume,
                                        .progress = progress_to(progress, failure),
                                        .warning = warning_to(warn, failure)};
  codebooks::BuildResult result = unlocked(
      failure, [&] { return codebooks::build(codebooks::parse_plan(plan, "the plan"), function, options); });
  return py::make_tuple(std::make_shared<Book>(std::move(result.book)), result.met, result.message);
}

}  // namespace

void add_sampling(py::module_& module) {
  module.def("separate", &separate, py::arg("call"), py::arg("plan"), py::arg("progress"), py::arg("warn"),
             py::arg("checkpoint"), py::arg("resume"), py::arg("certificate_points"));
}

}  // namespace samara::python
