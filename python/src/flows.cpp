#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "calls.h"
#include "python_model.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/codebooks/model/wind_file.h"
#include "samara/codebooks/source/realisation_checkpoint.h"
#include "samara/flow/files/flow_view.h"
#include "samara/io/text_file.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/gust_layout.h"
#include "samara/models/stochastic/realisations.h"
#include "samara/models/wind/body_outline.h"
#include "samara/models/wind/wind_series.h"

namespace samara::python {

namespace {

using models::wind::Wind;

Eigen::Vector3d place_of(const std::vector<double>& given) {
  if (given.size() != 3) throw ArgumentError("a place or a velocity has no three numbers x, y, z");
  return {given[0], given[1], given[2]};
}

/// One realisation of a wind where and when it is asked: (points, 3) [m/s]
/// @param times (points) [s]  @param points (points, 3) [m]
py::array_t<double> wind_velocities(const std::filesystem::path& file, double body_length, std::uint64_t seed,
                                    std::uint64_t realisation, const Array& times, const Array& points) {
  const py::ssize_t count = times.size();
  py::array_t<double> velocities({count, py::ssize_t{3}});
  const double* const t = times.data();
  const ConstColumns at(points.data(), 3, count);
  Columns to(velocities.mutable_data(), 3, count);
  Failure failure;
  unlocked(failure, [&] {
    const codebooks::WindFile wind = codebooks::read_wind(file);
    if (wind.seen)
      throw InputError(file.string(),
                       "has turbulence of the kind \"seen\", which is along paths and no field");
    const auto flow = models::wind::wind_flow(wind.wind, body_length, seed, realisation);
    parallel_for(count, [&](py::ssize_t n) { to.col(n) = flow->sample(t[n], at.col(n)).velocity; });
    return true;
  });
  return velocities;
}

/// Series at points: times (samples), velocities (samples, points, 3), along, across and up.
py::tuple wind_series(const std::filesystem::path& file, const Array& points, double step, long samples,
                      std::uint64_t seed, std::uint64_t realisation) {
  Failure failure;
  const models::wind::WindSeries series = unlocked(failure, [&] {
    const codebooks::WindFile wind = codebooks::read_wind(file);
    if (!wind.series) throw InputError(file.string(), "has no [series], which was expected");
    return models::wind::wind_series(wind.wind.profile,
                                     {.spectrum = wind.series->spectrum,
                                      .sigma = wind.series->sigma,
                                      .step = step,
                                      .samples = samples,
                                      .points = ConstColumns(points.data(), 3, points.size() / 3)},
                                     seed, realisation);
  });
  const Eigen::Index rows = series.times.size(), columns = points.size() / 3;
  py::array_t<double> velocities({rows, columns, Eigen::Index{3}});
  double* to = velocities.mutable_data();
  for (Eigen::Index k = 0; k < rows; ++k) {
    for (Eigen::Index p = 0; p < columns; ++p) {
      for (const Eigen::MatrixXd& component : series.velocity) *to++ = component(k, p);
    }
  }
  return py::make_tuple(copied(series.times), velocities);
}

/// (heights) -> mean speeds [m/s]
py::array_t<double> wind_profile(const std::filesystem::path& file, const Array& heights) {
  const codebooks::WindFile wind = codebooks::read_wind(file);
  py::array_t<double> speeds(heights.size());
  std::transform(heights.data(), heights.data() + heights.size(), speeds.mutable_data(),
                 [&](double z) { return wind.wind.profile.speed(z); });
  return speeds;
}

using Flow = flow::StoredFlow;

/// Cells of a field as an array, its directions in the order x, y, z; NaN inside the body, but for `open`.
py::array_t<double> cells_of(const Flow& stored, const flow::Field& values, bool hides_body) {
  const flow::MacGrid& grid = stored.grid;
  Shape shape(grid.cells.begin(), grid.cells.begin() + grid.dimensions);
  py::array_t<double> cells(shape);
  double* to = cells.mutable_data();
  for (int i = 0; i < grid.cells[0]; ++i) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int k = 0; k < grid.cells[2]; ++k) {
        const auto at = static_cast<std::size_t>(grid.at(i, j, k));
        const bool is_hidden = hides_body && !(stored.open[at] > 0.0);
        *to++ = is_hidden ? std::numeric_limits<double>::quiet_NaN() : values[at];
      }
    }
  }
  return cells;
}

/// None for a number that is not known.
std::optional<double> known(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

py::dict describe_flow(const Flow& stored) {
  const flow::FlowSummary& s = stored.summary;
  py::dict fields;
  for (const flow::CentreField& field : stored.fields) fields[py::str(field.name)] = field.unit;
  return py::dict(py::arg("status") = s.status, py::arg("message") = s.message, py::arg("title") = s.title,
                  py::arg("plan") = s.plan, py::arg("reynolds") = s.reynolds,
                  py::arg("angle_of_attack") = s.angle_of_attack, py::arg("drag") = s.drag,
                  py::arg("drag_half_width") = s.drag_half_width, py::arg("lift") = s.lift,
                  py::arg("moment") = s.moment, py::arg("drag_rms") = known(s.drag_rms),
                  py::arg("lift_rms") = known(s.lift_rms), py::arg("strouhal") = known(s.strouhal),
                  py::arg("bubble_end") = s.bubble_end, py::arg("time") = s.time,
                  py::arg("averaged_time") = s.averaged_time, py::arg("fields") = fields);
}

/// Places of the centres of cells along a direction, in body lengths.
py::array_t<double> centres_of(const Flow& stored, int direction) {
  const flow::MacGrid& grid = stored.grid;
  if (direction < 0 || direction >= grid.dimensions) throw ArgumentError("the flow has no such direction");
  Eigen::VectorXd places(grid.cells[static_cast<std::size_t>(direction)]);
  for (Eigen::Index n = 0; n < places.size(); ++n)
    places[n] = grid.origin[direction] + (static_cast<double>(n) + 0.5) * grid.spacing;
  return copied(places);
}

/// What stands in the file of a wind; empty for other air. It is read once, as a pipe has it once: the wind is made of
/// it, and its checkpoint knows it again.
std::string wind_text_of(const py::dict& air, Failure& failure) {
  if (air["kind"].cast<std::string>() != "wind") return {};
  const auto file = air["file"].cast<std::filesystem::path>();
  return unlocked(failure, [&] { return io::read_text_file(file, {.expected = "a wind"}); });
}

/// The air of a cloud: a wind's file; or a flow's with speed, length, place and whether the stream goes on beyond it;
/// or an energy that is the same everywhere.
/// @param wind_text of wind_text_of()
std::shared_ptr<const models::AirSource> air_of(const py::dict& given, const std::string& wind_text,
                                                const models::ParametricModel& model, std::uint64_t seed,
                                                const models::SeenOptions& seen) {
  const auto kind = given["kind"].cast<std::string>();
  if (kind == "wind") {
    const auto file = given["file"].cast<std::filesystem::path>();
    const codebooks::WindFile wind = codebooks::parse_wind(wind_text, file.string());
    if (wind.seen)
      return models::fluid_seen_in(
          models::wind::surface_layer(wind.wind.profile, wind.wind.towards, *wind.seen), seed, seen);
    const auto body = models::wind::outline_of(model, given["radius"].cast<std::optional<double>>());
    return models::wind::wind_air(wind.wind, body.length, body.semi_axes, seed);
  }
  if (kind == "flow") {
    const auto stored = given["flow"].cast<std::shared_ptr<Flow>>();
    if (std::ranges::none_of(stored->fields, [](const auto& field) { return field.name == "epsilon"; }))
      throw ArgumentError(
          "the flow is laminar, so that all realisations would be one; one by k-epsilon was expected");
    const flow::FlowPlacement placement = {.speed = given["speed"].cast<double>(),
                                           .length = given["length"].cast<double>(),
                                           .body = place_of(given["place"].cast<std::vector<double>>()),
                                           .stream_beyond = given["stream_beyond"].cast<bool>()};
    const auto view = std::make_shared<const flow::FlowView>(stored, placement);
    flow::check_release(*view, model);
    return models::fluid_seen_in(view, seed, seen);
  }
  const auto k = given["k"].cast<double>(), epsilon = given["epsilon"].cast<double>();
  const Eigen::Vector3d stream = place_of(given["stream"].cast<std::vector<double>>());
  return models::fluid_seen_in(given["decays"].cast<bool>() ? models::decaying_turbulence(k, epsilon, stream)
                                                            : models::uniform_turbulence(k, epsilon, stream),
                               seed, seen);
}

/// (times, states, states)
py::array_t<double> stacked(const std::vector<Eigen::MatrixXd>& matrices, Eigen::Index rows,
                            Eigen::Index columns) {
  py::array_t<double> all({static_cast<py::ssize_t>(matrices.size()), rows, columns});
  for (std::size_t n = 0; n < matrices.size(); ++n)
    Columns(all.mutable_data() + static_cast<Eigen::Index>(n) * rows * columns, columns, rows) =
        matrices[n].transpose();
  return all;
}

const char* word_of(models::RealisationStatus status) {
  switch (status) {
    case models::RealisationStatus::flying:
      return "flying";
    case models::RealisationStatus::landed:
      return "landed";
    case models::RealisationStatus::left_flow:
      return "left_flow";
    case models::RealisationStatus::not_finite:
      return "not_finite";
  }
  return "";
}

py::dict realise(const py::object& which, const std::map<std::string, double>& values,
                 const std::vector<double>& times, const py::dict& air, const py::dict& given,
                 const py::object& progress, const py::object& warn) {
  const auto failure = std::make_shared<Failure>();
  const models::ParametricModel model(model_of(which, failure), values, {});
  model.check({});
  const models::ModelInfo& info = model.model().info();
  const std::vector<double> parameters = model.parameters({});
  models::SeenOptions seen = {.C_0 = given["C_0"].cast<double>(), .rotation = given["rotation"].cast<bool>()};
  const auto radius = given["body_radius"].cast<std::optional<double>>();
  seen.radius = radius.value_or(models::outline_radius(info, parameters));
  const auto nu = std::ranges::find(info.parameters, "nu", &models::ParameterInfo::name);
  if (nu != info.parameters.end())
    seen.viscosity = parameters[static_cast<std::size_t>(nu - info.parameters.begin())];
  const std::string wind_text = wind_text_of(air, *failure);
  const auto source = air_of(air, wind_text, model, given["seed"].cast<std::uint64_t>(), seen);
  const auto step = given["step"].cast<std::optional<double>>();
  const models::RealiseOptions options = {.realisations = given["realisations"].cast<long>(),
                                          .first = given["first"].cast<long>(),
                                          .step = step.value_or(models::step_of_body(model, {})),
                                          .threads = given["threads"].cast<int>(),
                                          .states = given["states"].cast<std::vector<std::string>>(),
                                          .ground = given["ground"].cast<std::optional<double>>(),
                                          .keep = given["keep"].cast<long>(),
                                          .antithetic = given["antithetic"].cast<bool>(),
                                          .relative_error = given["relative_error"].cast<double>(),
                                          .progress = progress_to(progress, *failure)};
  const codebooks::RealisationCheckpoint checkpoint = {
      .file = given["checkpoint"].cast<std::filesystem::path>(),
      .air = given["identity"].cast<std::string>() + "\n" + wind_text,
      .warning = warning_to(warn, *failure)};
  const models::Ensemble cloud = unlocked(*failure, [&] {
    models::Ensemble flown = codebooks::realise(model, {}, *source, times, options, checkpoint);
    if (const std::string doubt = models::doubt_of_steps(flown, "step="); !doubt.empty())
      checkpoint.warning(doubt);
    if (const long lost = flown.count(models::RealisationStatus::not_finite); lost > 0)
      checkpoint.warning(fmt::format("{} of {} flights diverged, and are no numbers from there on", lost,
                                     flown.realisations()));
    return flown;
  });
  py::list status;
  for (const models::RealisationStatus one : cloud.status) status.append(word_of(one));
  Eigen::MatrixXd landings(static_cast<Eigen::Index>(cloud.landings.size()), 5);
  for (std::size_t n = 0; n < cloud.landings.size(); ++n)
    landings.row(static_cast<Eigen::Index>(n)) << static_cast<double>(cloud.landings[n].realisation),
        cloud.landings[n].t, cloud.landings[n].position.transpose();
  std::vector<std::string> names;
  for (const models::StateInfo& state : info.states) names.push_back(state.name);
  const Eigen::Index states = std::ssize(cloud.states);
  return py::dict(py::arg("times") = copied(cloud.times), py::arg("states") = cloud.states,
                  py::arg("units") = cloud.units,
                  py::arg("flying") = copied(Eigen::VectorXd(cloud.flying.cast<double>())),
                  py::arg("mean") = copied(cloud.mean), py::arg("mean_error") = copied(cloud.mean_error),
                  py::arg("covariance") = stacked(cloud.covariance, states, states),
                  py::arg("covariance_error") = stacked(cloud.covariance_error, states, states),
                  py::arg("landings") = copied(landings), py::arg("status") = status,
                  py::arg("half_turns") = cloud.half_turns, py::arg("all_states") = names,
                  py::arg("kept") = stacked(cloud.kept, cloud.times.size(), std::ssize(names)),
                  py::arg("first") = cloud.first, py::arg("step") = cloud.step,
                  py::arg("steps_beyond_tenth") = cloud.steps.beyond_tenth,
                  py::arg("cancelled") = cloud.cancelled, py::arg("relative_error") = cloud.relative_error);
}

}  // namespace

void add_flows(py::module_& module) {
  py::class_<Flow, std::shared_ptr<Flow>>(module, "Flow")
      .def_static(
          "open",
          [](const std::filesystem::path& path) { return std::make_shared<Flow>(flow::load_flow(path)); },
          py::arg("path"))
      .def("describe", &describe_flow)
      .def("centres", &centres_of, py::arg("direction"))
      .def(
          "field",
          [](const Flow& stored, const std::string& name) {
            return cells_of(stored, stored.field(name).values, true);
          },
          py::arg("name"))
      .def("opened", [](const Flow& stored) { return cells_of(stored, stored.open, false); })
      .def_property_readonly("dimensions", [](const Flow& stored) { return stored.grid.dimensions; });
  module.def("wind_velocities", &wind_velocities, py::arg("file"), py::arg("body_length"), py::arg("seed"),
             py::arg("realisation"), py::arg("times"), py::arg("points"));
  module.def("wind_series", &wind_series, py::arg("file"), py::arg("points"), py::arg("step"),
             py::arg("samples"), py::arg("seed"), py::arg("realisation"));
  module.def("wind_profile", &wind_profile, py::arg("file"), py::arg("heights"));
  module.def("realise", &realise, py::arg("model"), py::arg("values"), py::arg("times"), py::arg("air"),
             py::arg("options"), py::arg("progress"), py::arg("warn"));
}

}  // namespace samara::python
