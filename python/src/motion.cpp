#include "motion.h"

#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "arrays.h"
#include "calls.h"
#include "captures.h"
#include "python_model.h"
#include "rooms.h"
#include "samara/base/errors.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/motion/pages/pattern_page.h"
#include "samara/motion/patterns/disc_phase_diagram.h"
#include "samara/motion/patterns/transitions.h"
#include "samara/motion/sweeps/landing.h"
#include "samara/motion/sweeps/pattern_map.h"
#include "samara/motion/sweeps/phase_diagram.h"
#include "samara/motion/sweeps/refining.h"
#include "samara/motion/sweeps/sweep_file.h"

namespace samara::python {

namespace {

using motion::Sweep;
using Thresholds = std::map<std::string, double>;

Thresholds by_name(const motion::PatternThresholds& thresholds) {
  Thresholds values;
  for (const motion::NamedThreshold& one : motion::named_thresholds())
    values[one.name] = thresholds.*one.value;
  return values;
}

Eigen::VectorXd column(const py::handle& values) {
  const auto array = values.cast<Array>();
  return Eigen::Map<const Eigen::VectorXd>(array.data(), array.size());
}

/// (rows, 3)
Eigen::MatrixX3d triples(const py::handle& values) {
  const auto array = values.cast<Array>();
  return ConstColumns(array.data(), 3, array.size() / 3).transpose();
}

py::dict record_dict(const std::string& name, const motion::MotionRecord& record) {
  const py::object none = py::none();
  return py::dict(py::arg("name") = name, py::arg("times") = copied(record.times),
                  py::arg("positions") = copied(Eigen::MatrixXd(record.positions)),
                  py::arg("normals") =
                      record.normals.rows() > 0 ? py::object(copied(Eigen::MatrixXd(record.normals))) : none,
                  py::arg("angles") = record.angles.size() > 0 ? py::object(copied(record.angles)) : none,
                  py::arg("length") = record.length, py::arg("left_out") = record.left_out);
}

/// Shapes are checked by Python.
motion::MotionRecord record_of(const py::dict& given) {
  motion::MotionRecord record;
  record.times = column(given["times"]);
  record.positions = triples(given["positions"]);
  if (!given["normals"].is_none()) record.normals = triples(given["normals"]);
  if (!given["angles"].is_none()) record.angles = column(given["angles"]);
  record.length = given["length"].cast<double>();
  record.left_out = given["left_out"].cast<Eigen::Index>();
  record.position_noise = given["position_noise"].cast<std::optional<double>>();
  record.angle_noise = given["angle_noise"].cast<std::optional<double>>();
  return record;
}

py::list motion_records(const std::vector<std::filesystem::path>& files, const py::list& tables,
                        const std::filesystem::path& sidecar, double length) {
  py::list list;
  for (const identification::Capture& capture : captures_from(files, tables, sidecar))
    list.append(record_dict(capture.id, motion::record_of(capture, length)));
  return list;
}

py::array_t<double> feature_numbers(const motion::Features& features) {
  return copied(Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(
      features.values.data(), static_cast<Eigen::Index>(features.values.size()))));
}

/// @returns the features, and pattern, margin and reason
py::tuple record_features(const py::dict& given, double settle_share, const Thresholds& thresholds) {
  const motion::Features all = motion::features(record_of(given), {.settle_share = settle_share});
  const motion::PatternLabel label = motion::label(all, thresholds_of(thresholds));
  return py::make_tuple(feature_numbers(all), to_string(label.pattern), label.margin, label.why);
}

/// Tuples (from, to, pattern, margin, why, windows merged).
py::list record_windows(const py::dict& given, double swings, double overlap, const Thresholds& thresholds) {
  py::list list;
  for (const motion::LabelledWindow& w : motion::label_windows(
           record_of(given), {.swings = swings, .overlap = overlap}, thresholds_of(thresholds)))
    list.append(
        py::make_tuple(w.from, w.to, to_string(w.label.pattern), w.label.margin, w.label.why, w.windows));
  return list;
}

/// counts, probability, lower, upper: (patterns, patterns) each, rows from, columns to
py::tuple pattern_transitions(const std::vector<std::vector<std::string>>& sequences) {
  std::vector<std::vector<motion::Pattern>> all;
  for (const auto& sequence : sequences) {
    all.emplace_back();
    for (const std::string& name : sequence) all.back().push_back(motion::pattern_of(name));
  }
  const motion::Transitions t = motion::transitions(all);
  return py::make_tuple(copied(Eigen::MatrixXd(t.counts.cast<double>())), copied(t.probability),
                        copied(t.lower), copied(t.upper));
}

py::dict regime(const py::object& which, const std::map<std::string, double>& values) {
  const auto failure = std::make_shared<Failure>();
  const models::ParametricModel body(model_of(which, failure), values, {});
  body.check({});
  const motion::FallNumbers n = motion::fall_numbers(body.model(), body.parameters({}));
  const motion::RegimeAnswer answer = motion::regime(n.Re, n.I_disc);
  return py::dict(py::arg("length") = n.length, py::arg("thickness") = n.thickness,
                  py::arg("speed") = n.speed, py::arg("Re") = n.Re, py::arg("I_disc") = n.I_disc,
                  py::arg("I_plate") = n.I_plate, py::arg("I_ellipse") = n.I_ellipse,
                  py::arg("regime") = to_string(answer.regime), py::arg("beyond") = to_string(answer.beyond),
                  py::arg("distance") = answer.distance, py::arg("measured") = answer.measured);
}

/// @param path of the plan, or its text
/// @returns the sweep, whether it is complete, and how it ended
py::tuple run_sweep(const std::optional<std::filesystem::path>& path, const std::string& text,
                    const py::object& progress, const py::object& warn,
                    const std::filesystem::path& checkpoint, int threads) {
  Failure failure;
  const motion::SweepOptions options = {.threads = threads,
                                        .progress = progress_to(progress, failure),
                                        .checkpoint = checkpoint,
                                        .warning = warning_to(warn, failure)};
  motion::SweepResult result = unlocked(failure, [&] {
    const motion::SweepPlan plan =
        path ? motion::read_sweep_plan(*path) : motion::parse_sweep_plan(text, "the plan");
    motion::SweepOptions falls = options;
    falls.keep_checkpoint = plan.refine > 0;  // until that of the refining stands in its place
    motion::SweepResult swept = motion::run_sweep(plan, falls);
    if (!swept.complete || plan.refine == 0) return swept;
    const motion::RefiningResult refined = motion::refine_by_plan(plan, options, swept.sweep);
    swept.complete = refined.complete;
    swept.message += ", refined: " + refined.message;
    return swept;
  });
  return py::make_tuple(std::make_shared<Sweep>(std::move(result.sweep)), result.complete, result.message);
}

py::dict describe_sweep(const Sweep& sweep) {
  py::list releases;
  for (const motion::Release& release : sweep.releases)
    releases.append(py::make_tuple(release.tilt, release.axis));
  py::list rounds;
  for (const motion::RefiningRound& round : sweep.rounds)
    rounds.append(py::make_tuple(round.points, round.run, round.agreement));
  return py::dict(py::arg("model") = sweep.model, py::arg("plan") = sweep.plan_text,
                  py::arg("names") = sweep.names, py::arg("units") = sweep.units,
                  py::arg("axes") = sweep.axes, py::arg("releases") = releases,
                  py::arg("release_count") = sweep.release_count(), py::arg("falls") = sweep.fall_count(),
                  py::arg("thresholds") = by_name(sweep.thresholds), py::arg("states") = sweep.state_names,
                  py::arg("rounds") = rounds, py::arg("round_of_point") = sweep.round_of_point);
}

py::array_t<double> features_of(const Sweep& sweep) {
  py::array_t<double> all({sweep.fall_count(), static_cast<py::ssize_t>(motion::kFeatures)});
  double* to = all.mutable_data();
  for (const motion::Features& one : sweep.features) to = std::copy(one.values.begin(), one.values.end(), to);
  return all;
}

/// Per fall: pattern, margin, reason, status.
py::tuple labels_of(const Sweep& sweep) {
  std::vector<std::string> patterns, reasons, status;
  Eigen::VectorXd margins(sweep.fall_count());
  for (Eigen::Index n = 0; n < margins.size(); ++n) {
    const auto k = static_cast<std::size_t>(n);
    patterns.push_back(to_string(sweep.labels[k].pattern));
    reasons.push_back(sweep.labels[k].why);
    status.push_back(to_string(sweep.status[k]));
    margins[n] = sweep.labels[k].margin;
  }
  return py::make_tuple(patterns, copied(margins), reasons, status);
}

/// Per point: pattern, probability, distance to the border.
py::tuple map_at(const Sweep& sweep, const Array& points, Eigen::Index release) {
  const auto count = leading_shape(points, sweep.lower.size(), "points").front();
  const motion::PatternMap map(sweep, release);
  const ConstColumns columns(points.data(), sweep.lower.size(), count);
  std::vector<std::string> patterns;
  Eigen::VectorXd probability(count), distance(count);
  for (Eigen::Index n = 0; n < count; ++n) {
    const motion::MapAnswer answer = map.at(columns.col(n));
    patterns.push_back(to_string(answer.pattern));
    probability[n] = answer.probability;
    distance[n] = answer.distance_to_border;
  }
  return py::make_tuple(patterns, copied(probability), copied(distance));
}

/// (count, coordinates), each point from a stream of its own
py::array_t<double> drawn(const Sweep& sweep, const std::string& pattern, Eigen::Index count,
                          std::uint64_t seed, Eigen::Index release) {
  const motion::PatternMap map(sweep, release);
  const motion::Pattern wanted = motion::pattern_of(pattern);
  py::array_t<double> points({count, static_cast<Eigen::Index>(sweep.names.size())});
  Columns columns(points.mutable_data(), sweep.lower.size(), count);
  for (Eigen::Index n = 0; n < count; ++n) {
    Stream stream(seed, static_cast<std::uint64_t>(n));
    columns.col(n) = map.draw(wanted, stream);
  }
  return points;
}

py::array_t<double> clamped(const Sweep& sweep, const std::string& pattern, const Array& points,
                            Eigen::Index release) {
  const auto count = leading_shape(points, sweep.lower.size(), "points").front();
  const motion::PatternMap map(sweep, release);
  const motion::Pattern wanted = motion::pattern_of(pattern);
  const ConstColumns given(points.data(), sweep.lower.size(), count);
  py::array_t<double> moved({count, static_cast<py::ssize_t>(sweep.lower.size())});
  Columns columns(moved.mutable_data(), sweep.lower.size(), count);
  for (Eigen::Index n = 0; n < count; ++n) columns.col(n) = map.clamp(wanted, given.col(n));
  return moved;
}

/// Per pattern that fell: its name, share with its interval, falls that landed, mean x and y, their standard errors,
/// covariances xx, xy, yy, mean distance, its standard error, mean time.
py::list landings_of(const Sweep& sweep, Eigen::Index release) {
  if (release < 0 || release >= sweep.release_count())
    throw ArgumentError("there is no release " + std::to_string(release) + ", expected 0 to " +
                        std::to_string(sweep.release_count() - 1));
  py::list list;
  for (const motion::LandingStatistics& s : motion::landing_statistics(sweep, release))
    list.append(py::make_tuple(to_string(s.pattern), s.share.value, s.share.lower, s.share.upper, s.falls,
                               s.mean.x(), s.mean.y(), s.mean_error.x(), s.mean_error.y(), s.covariance(0, 0),
                               s.covariance(0, 1), s.covariance(1, 1), s.distance, s.distance_error, s.time));
  return list;
}

/// times (frames), and states (falls, frames, states); None where none were kept
py::object trajectories_of(const Sweep& sweep) {
  if (sweep.trajectories.empty()) return py::none();
  const Eigen::Index frames = sweep.times.size(), states = sweep.trajectories.front().cols();
  py::array_t<double> all({sweep.fall_count(), frames, states});
  for (std::size_t n = 0; n < sweep.trajectories.size(); ++n)
    Columns(all.mutable_data() + static_cast<Eigen::Index>(n) * frames * states, states, frames) =
        sweep.trajectories[n].transpose();
  return py::make_tuple(copied(sweep.times), all);
}

/// @param body numbers of the one that falls, by name, as regime() gives them
std::string captures_html(const py::list& records, double swings, double overlap,
                          const Thresholds& thresholds,
                          const std::optional<std::map<std::string, double>>& body) {
  std::vector<motion::LabelledMotion> motions;
  const motion::PatternThresholds rule = thresholds_of(thresholds);
  for (const py::handle given : records) {
    const auto one = given.cast<py::dict>();
    const motion::MotionRecord record = record_of(one);
    motions.push_back({one["name"].cast<std::string>(), record,
                       motion::label_windows(record, {.swings = swings, .overlap = overlap}, rule)});
  }
  if (!body) return motion::pattern_html(motions, rule);
  const motion::FallNumbers numbers = {.Re = body->at("Re"),
                                       .I_disc = body->at("I_disc"),
                                       .I_plate = body->at("I_plate"),
                                       .I_ellipse = body->at("I_ellipse")};
  return motion::pattern_html(motions, rule, numbers);
}

}  // namespace

motion::PatternThresholds thresholds_of(const std::map<std::string, double>& values) {
  motion::PatternThresholds thresholds;
  for (const auto& [name, value] : values) set_threshold(thresholds, name, value);
  return thresholds;
}

std::vector<identification::Capture> captures_from(const std::vector<std::filesystem::path>& files,
                                                   const py::list& tables,
                                                   const std::filesystem::path& sidecar) {
  identification::check_sidecar(sidecar, files, !tables.empty());
  std::vector<identification::Capture> captures;
  for (const std::filesystem::path& file : files)
    std::ranges::move(identification::read_captures(file, sidecar), std::back_inserter(captures));
  for (const py::handle table : tables) captures.push_back(capture_of(table.cast<py::dict>()));
  return captures;
}

void add_motion(py::module_& module) {
  py::class_<Sweep, std::shared_ptr<Sweep>>(module, "Sweep")
      .def_static(
          "open",
          [](const std::filesystem::path& path) { return std::make_shared<Sweep>(motion::load_sweep(path)); },
          py::arg("path"))
      .def(
          "save", [](const Sweep& sweep, const std::filesystem::path& path) { motion::save(sweep, path); },
          py::arg("path"))
      .def("describe", &describe_sweep)
      .def("points", [](const Sweep& sweep) { return copied(sweep.points); })
      .def("features", &features_of)
      .def("labels", &labels_of)
      .def("reached", [](const Sweep& sweep) { return copied(sweep.reached); })
      .def("landing", [](const Sweep& sweep) { return copied(Eigen::MatrixXd(sweep.landing)); })
      .def("shares", [](const Sweep& sweep) { return copied(motion::release_shares(sweep)); })
      .def("trajectories", &trajectories_of)
      .def("at", &map_at, py::arg("points"), py::arg("release"))
      .def("draw", &drawn, py::arg("pattern"), py::arg("count"), py::arg("seed"), py::arg("release"))
      .def("clamp", &clamped, py::arg("pattern"), py::arg("points"), py::arg("release"))
      .def("landings", &landings_of, py::arg("release"))
      .def("html", [](const Sweep& sweep) { return motion::pattern_html(sweep); });
  module.def("run_sweep", &run_sweep, py::arg("path"), py::arg("text"), py::arg("progress"), py::arg("warn"),
             py::arg("checkpoint"), py::arg("threads"));
  module.def("feature_infos", [] {
    py::list list;
    for (const motion::FeatureInfo& info : motion::feature_infos())
      list.append(py::make_tuple(info.name, info.unit, info.meaning, info.needs_attitude));
    return list;
  });
  module.def("pattern_names", [] { return motion::pattern_names(); });
  module.def(
      "pattern_thresholds", [](const Thresholds& changed) { return by_name(thresholds_of(changed)); },
      py::arg("changed"));
  module.def("motion_records", &motion_records, py::arg("files"), py::arg("tables"), py::arg("sidecar"),
             py::arg("length"));
  module.def("record_features", &record_features, py::arg("record"), py::arg("settle"),
             py::arg("thresholds"));
  module.def("record_windows", &record_windows, py::arg("record"), py::arg("swings"), py::arg("overlap"),
             py::arg("thresholds"));
  module.def("pattern_transitions", &pattern_transitions, py::arg("sequences"));
  module.def("captures_html", &captures_html, py::arg("records"), py::arg("swings"), py::arg("overlap"),
             py::arg("thresholds"), py::arg("body"));
  module.def("regime", &regime, py::arg("model"), py::arg("values"));
  add_pattern_tools(module);
}

}  // namespace samara::python
