#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "book.h"
#include "calls.h"
#include "captures.h"
#include "python_model.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/report/fit_page.h"
#include "samara/identification/report/fit_report.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/identification/series/series_report.h"

namespace samara::python {

namespace id = samara::identification;

namespace {

using Paths = std::vector<std::filesystem::path>;

/// A fit that was made, and what it minimised. The functions of a Python model may be called by it again.
struct Fit {
  id::FitReport report;
  std::shared_ptr<Failure> failure;
  mutable std::mutex asking = {};  ///< so that each caller gets what its own call raised

  const id::FitObjective& objective() const {
    if (report.objective) return *report.objective;
    throw ArgumentError(
        "the fit has no residuals to go on with: nothing was fitted, no start succeeded, or it is one "
        "of a series");
  }
};

/// Asks the objective, without the interpreter's lock.
template <class Work>
auto asked(const Fit& fit, const Work& work) {
  const py::gil_scoped_release release;
  const std::scoped_lock lock(fit.asking);
  try {
    return work();
  } catch (...) {
    fit.failure->rethrow_if_any();
    throw;
  }
}

template <class T>
T entry(const py::dict& request, const char* key) {
  return request[key].cast<T>();
}

id::FitRequest request_of(const py::dict& given) {
  id::FitRequest request{.source = entry<std::string>(given, "source"),
                         .captures = entry<Paths>(given, "captures"),
                         .left_out = entry<Paths>(given, "left_out"),
                         .sidecar = entry<std::filesystem::path>(given, "sidecar"),
                         .config = entry<std::filesystem::path>(given, "config"),
                         .coefficients = entry<std::filesystem::path>(given, "coefficients"),
                         .span = entry<std::optional<double>>(given, "span"),
                         .left_out_span = entry<std::optional<double>>(given, "left_out_span"),
                         .ahead = entry<std::optional<double>>(given, "ahead"),
                         .reference = entry<bool>(given, "reference"),
                         .profiles = entry<bool>(given, "profiles")};
  request.config_text = entry<std::string>(given, "config_text");
  for (const py::handle capture : given["measured"])
    request.measured.push_back(capture_of(capture.cast<py::dict>()));
  request.with_objective = true;
  return request;
}

/// @param book, model one of the two, or none of them where the request names a source
std::shared_ptr<Fit> fit(const py::dict& given, const std::shared_ptr<Book>& book, const py::object& model,
                         const py::object& progress) {
  auto result = std::make_shared<Fit>();
  result->failure = std::make_shared<Failure>();
  id::FitRequest request = request_of(given);
  if (book) request.book = book->shared();
  if (!model.is_none()) request.model = model_of(model, result->failure);
  request.progress = progress_to(progress, *result->failure);
  result->report = unlocked(*result->failure, [&] { return id::fit_files(request); });
  return result;
}

py::list unknowns(const Fit& fit) {
  py::list list;
  for (const id::FitUnknown& u : fit.objective().unknowns()) {
    list.append(py::dict(py::arg("name") = u.name, py::arg("unit") = u.unit, py::arg("lower") = u.lower,
                         py::arg("upper") = u.upper));
  }
  return list;
}

std::span<const double> numbers_of(const Array& q) {
  return {q.data(), static_cast<std::size_t>(q.size())};
}

/// NaN where there is no trajectory, or an output is not finite.
py::array_t<double> residuals(const Fit& fit, const Array& q) {
  const id::FitObjective& objective = fit.objective();
  py::array_t<double> values(objective.residual_count());
  Eigen::Map<Eigen::VectorXd> to(values.mutable_data(), values.size());
  asked(fit, [&] {
    const bool has_values = objective.residuals(numbers_of(q), to);
    if (!has_values) to.setConstant(std::numeric_limits<double>::quiet_NaN());
    return has_values;
  });
  return values;
}

py::array_t<double> jacobian(const Fit& fit, const Array& q) {
  const id::FitObjective& objective = fit.objective();
  Eigen::VectorXd values(objective.residual_count());
  Eigen::MatrixXd slopes;
  const bool has_values = asked(fit, [&] { return objective.residuals(numbers_of(q), values, &slopes); });
  if (!has_values) slopes.setConstant(values.size(), q.size(), std::numeric_limits<double>::quiet_NaN());
  return copied(slopes);
}

py::object log_posterior(const Fit& fit, const Array& q, bool gradient) {
  const id::FitObjective& objective = fit.objective();
  Eigen::VectorXd slope;
  const double value =
      asked(fit, [&] { return objective.log_posterior(numbers_of(q), gradient ? &slope : nullptr); });
  if (!gradient) return py::float_(value);
  return py::make_tuple(value, copied(slope));
}

std::shared_ptr<Book> series_book(const Fit& fit) {
  if (!fit.report.series)
    throw ArgumentError("the fit is none of a series; a config with [series] was expected");
  return std::make_shared<Book>(id::series_codebook(*fit.report.series));
}

}  // namespace

id::Capture capture_of(const py::dict& given) {
  id::Capture capture;
  capture.id = given["id"].cast<std::string>();
  capture.labels = given["labels"].cast<std::map<std::string, std::string>>();
  const auto column = [](const py::handle& values) {
    const auto array = values.cast<Array>();
    return Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(array.data(), array.size()));
  };
  capture.times = column(given["times"]);
  for (const py::handle channel : given["channels"]) {
    capture.channels.push_back({.quantity = channel["name"].cast<std::string>(),
                                .unit = channel["unit"].cast<std::string>(),
                                .values = column(channel["values"])});
  }
  return capture;
}

void add_identification(py::module_& module) {
  py::class_<Fit, std::shared_ptr<Fit>>(module, "Fit")
      .def_property_readonly("is_usable", [](const Fit& fit) { return fit.report.is_usable; })
      .def_property_readonly("message", [](const Fit& fit) { return fit.report.message; })
      .def_property_readonly("has_objective", [](const Fit& fit) { return fit.report.objective != nullptr; })
      .def_property_readonly("widened_errors",
                             [](const Fit& fit) {
                               std::vector<std::optional<double>> errors;
                               for (const id::Coefficient& c : fit.report.fit.coefficients)
                                 errors.push_back(id::widened_error(fit.report.fit, c));
                               return errors;
                             })
      .def("json", [](const Fit& fit) { return id::fit_json(fit.report.fit); })
      .def("series_json",
           [](const Fit& fit) {
             return fit.report.series ? std::optional(id::series_json(*fit.report.series)) : std::nullopt;
           })
      .def("text",
           [](const Fit& fit) {
             return fit.report.series ? id::series_text(*fit.report.series) : id::fit_text(fit.report.fit);
           })
      .def("html", [](const Fit& fit) { return id::fit_html(fit.report.fit); })
      .def("series_book", &series_book)
      .def("unknowns", &unknowns)
      .def("answer", [](const Fit& fit) { return copied(fit.objective().answer()); })
      .def("residuals", &residuals, py::arg("q"))
      .def("jacobian", &jacobian, py::arg("q"))
      .def("log_posterior", &log_posterior, py::arg("q"), py::arg("gradient"));
  module.def("fit", &fit, py::arg("request"), py::arg("book"), py::arg("model"), py::arg("progress"));
}

}  // namespace samara::python
