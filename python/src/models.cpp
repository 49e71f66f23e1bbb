#include <cmath>
#include <map>
#include <memory>
#include <optional>
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
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/model.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"

namespace samara::python {

namespace {

py::object finite_or_none(double value) {
  return std::isfinite(value) ? py::object(py::float_(value)) : py::object(py::none());
}

/// What `samara models --json` says.
py::dict describe_model(const py::object& which) {
  const auto model = model_of(which, std::make_shared<Failure>());
  const models::ModelInfo& info = model->info();
  py::list states, parameters, terms;
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
  for (const models::ForceTermInfo& term : info.force_terms)
    terms.append(py::dict(py::arg("name") = term.name, py::arg("description") = term.description));
  return py::dict(py::arg("name") = info.name, py::arg("title") = info.title,
                  py::arg("equations") = info.equations, py::arg("frames") = info.frames,
                  py::arg("source") = info.source, py::arg("validity") = info.validity,
                  py::arg("symmetries") = info.symmetries, py::arg("time_unit") = models::time_unit(info),
                  py::arg("states") = states, py::arg("parameters") = parameters,
                  py::arg("affine_in") = info.affine_in, py::arg("force_terms") = terms);
}

/// Trajectories by the reference integrator.
/// @param free names of coordinates that change from point to point, or by which sensitivities are wanted
/// @param points (points, free)
/// @returns states (points, times, states), sensitivities (points, times, states, free) or None, and for each point
///   what is wrong with it, or an empty text
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
  py::array_t<double> states({count, t, n});
  py::array_t<double> slopes(sensitivities ? Shape{count, t, n, parameters} : Shape{0});
  std::vector<std::string> problems(static_cast<std::size_t>(count));
  const double* const from = points.data();
  double* const to = states.mutable_data();
  double* const derivatives = slopes.mutable_data();
  const auto one = [&](py::ssize_t i) {
    const std::span<const double> q(from + i * parameters, static_cast<std::size_t>(parameters));
    const models::Trajectory trajectory = models::integrate(model, q, times, options, sensitivities);
    if (!trajectory.is_usable())
      problems[static_cast<std::size_t>(i)] =
          fmt::format("{}; values after t = {:.6g} are NaN", trajectory.message, trajectory.reached);
    Columns(to + i * t * n, n, t) = trajectory.states.transpose();
    for (py::ssize_t k = 0; sensitivities && k < parameters; ++k) {
      const Eigen::MatrixXd& by = trajectory.sensitivities[static_cast<std::size_t>(k)];
      for (py::ssize_t row = 0; row < t; ++row) {
        for (py::ssize_t state = 0; state < n; ++state)
          derivatives[((i * t + row) * n + state) * parameters + k] = by(row, state);
      }
    }
  };
  unlocked(*failure, [&] {
    parallel_for(count, one);
    return true;
  });
  return py::make_tuple(states, sensitivities ? py::object(std::move(slopes)) : py::object(py::none()),
                        problems);
}

}  // namespace

void add_models(py::module_& module) {
  module.def("model_names", &models::model_names);
  module.def("describe_model", &describe_model, py::arg("model"));
  module.def("simulate", &simulate, py::arg("model"), py::arg("fixed"), py::arg("free"), py::arg("points"),
             py::arg("times"), py::arg("sensitivities"), py::arg("relative_tolerance"), py::arg("stiff"));
}

}  // namespace samara::python
