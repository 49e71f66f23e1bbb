#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "arrays.h"
#include "calls.h"
#include "python_model.h"
#include "rooms.h"
#include "samara/base/parallel.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/model.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/derived_outputs.h"

namespace samara::python {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

py::object finite_or_none(double value) {
  return std::isfinite(value) ? py::object(py::float_(value)) : py::object(py::none());
}

py::dict description_of(const models::ModelInfo& info) {
  py::list states, parameters, outputs, terms;
  for (const models::StateInfo& s : info.states) {
    states.append(py::dict(py::arg("name") = s.name, py::arg("unit") = s.unit,
                           py::arg("default_initial") = s.default_initial,
                           py::arg("description") = s.description));
  }
  for (const models::ParameterInfo& p : info.parameters) {
    parameters.append(py::dict(
        py::arg("name") = p.name, py::arg("unit") = p.unit, py::arg("description") = p.description,
        py::arg("default") = p.default_value,
        py::arg("derived") = p.derived.empty() ? py::object(py::none()) : py::object(py::str(p.derived)),
        py::arg("lower") = finite_or_none(p.lower), py::arg("upper") = finite_or_none(p.upper)));
  }
  for (const models::OutputInfo& o : info.outputs) {
    outputs.append(
        py::dict(py::arg("name") = o.name, py::arg("unit") = o.unit, py::arg("description") = o.description));
  }
  for (const models::ForceTermInfo& term : info.force_terms)
    terms.append(py::dict(py::arg("name") = term.name, py::arg("description") = term.description));
  return py::dict(
      py::arg("name") = info.name, py::arg("title") = info.title, py::arg("equations") = info.equations,
      py::arg("frames") = info.frames, py::arg("source") = info.source, py::arg("validity") = info.validity,
      py::arg("symmetries") = info.symmetries, py::arg("time_unit") = models::time_unit(info),
      py::arg("states") = states, py::arg("parameters") = parameters, py::arg("outputs") = outputs,
      py::arg("affine_in") = info.affine_in, py::arg("force_terms") = terms);
}

/// What `samara models --json` says, of fields of space, too.
py::dict describe_model(const py::object& which) {
  if (py::isinstance<py::str>(which)) {
    if (const models::FieldModel* field = models::find_field_model(which.cast<std::string>()))
      return description_of(field->info);
  }
  return description_of(model_of(which, std::make_shared<Failure>())->info());
}

/// Those of fields of space, too, sorted.
std::vector<std::string> model_names() {
  std::vector<std::string> names = models::model_names();
  for (std::string& field : models::field_model_names()) names.push_back(std::move(field));
  std::ranges::sort(names);
  return names;
}

/// Trajectories by the reference integrator.
/// @param free names of coordinates that change from point to point, or by which sensitivities are wanted
/// @param points (points, free)
/// @returns the states, and what the model derives from them, (points, times, outputs), sensitivities (points, times,
///   outputs, free) or None, and for each point what is wrong with it, or an empty text
py::tuple simulate(const py::object& which, const std::map<std::string, double>& fixed,
                   const std::vector<std::string>& free, const Array& points,
                   const std::vector<double>& times, bool sensitivities, double relative_tolerance,
                   bool stiff) {
  const auto failure = std::make_shared<Failure>();
  const models::ParametricModel model(model_of(which, failure), fixed, free);
  const models::IntegrateOptions options{.relative_tolerance = relative_tolerance, .stiff = stiff};
  const auto parameters = static_cast<py::ssize_t>(free.size());
  const Shape leading = leading_shape(points, parameters, "parameters");
  const py::ssize_t count = leading.front(), t = std::ssize(times), n = model.state_count();
  const py::ssize_t outputs = n + std::ssize(model.model().info().outputs);
  py::array_t<double> values({count, t, outputs});
  py::array_t<double> slopes(sensitivities ? Shape{count, t, outputs, parameters} : Shape{0});
  std::vector<std::string> problems(static_cast<std::size_t>(count));
  const double* const from = points.data();
  double* const to = values.mutable_data();
  double* const derivatives = slopes.mutable_data();
  std::vector<int> coordinates(free.size());
  std::iota(coordinates.begin(), coordinates.end(), 0);
  const auto one = [&](py::ssize_t i) {
    const std::span<const double> q(from + i * parameters, static_cast<std::size_t>(parameters));
    const models::Trajectory trajectory = models::integrate(model, q, times, options, sensitivities);
    if (!trajectory.is_usable())
      problems[static_cast<std::size_t>(i)] =
          fmt::format("{}; values after t = {:.6g} are NaN", trajectory.message, trajectory.reached);
    models::DerivedOutputs derived(model);
    derived.set(q);
    std::vector<double> all(static_cast<std::size_t>(outputs));
    const std::span<double> x(all.data(), static_cast<std::size_t>(n)),
        y(all.data() + n, all.size() - x.size());
    Eigen::MatrixXd x_slopes(n, parameters), y_slopes(derived.count(), parameters);
    for (py::ssize_t row = 0; row < t; ++row) {
      const double time = times[static_cast<std::size_t>(row)];
      Eigen::Map<Eigen::RowVectorXd>(x.data(), n) = trajectory.states.row(row);
      for (py::ssize_t k = 0; sensitivities && k < parameters; ++k)
        x_slopes.col(k) = trajectory.sensitivities[static_cast<std::size_t>(k)].row(row).transpose();
      // After the end of a trajectory its states are NaN, and so is what follows from them.
      const bool is_there = std::ranges::all_of(x, [](double value) { return std::isfinite(value); });
      if (!is_there) {
        std::ranges::fill(y, kNaN);
        y_slopes.setConstant(kNaN);
      } else if (sensitivities) {
        derived.evaluate(time, x, x_slopes, coordinates, y, y_slopes);
      } else {
        derived.evaluate(time, x, y);
      }
      std::ranges::copy(all, to + (i * t + row) * outputs);
      if (!sensitivities) continue;
      Columns by(derivatives + (i * t + row) * outputs * parameters, parameters, outputs);
      by.leftCols(n) = x_slopes.transpose();
      by.rightCols(outputs - n) = y_slopes.transpose();
    }
  };
  unlocked(*failure, [&] {
    parallel_for(count, one);
    return true;
  });
  return py::make_tuple(values, sensitivities ? py::object(std::move(slopes)) : py::object(py::none()),
                        problems);
}

}  // namespace

void add_models(py::module_& module) {
  module.def("model_names", &model_names);
  module.def("describe_model", &describe_model, py::arg("model"));
  module.def("simulate", &simulate, py::arg("model"), py::arg("fixed"), py::arg("free"), py::arg("points"),
             py::arg("times"), py::arg("sensitivities"), py::arg("relative_tolerance"), py::arg("stiff"));
}

}  // namespace samara::python
