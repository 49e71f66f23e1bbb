#include "samara/identification/problem/fit_problem.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/units.h"
#include "samara/identification/problem/camera.h"
#include "samara/identification/problem/joins.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/noise_scales.h"
#include "samara/identification/problem/segments.h"
#include "samara/identification/problem/unknown_charts.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

/// @throws ArgumentError for the first name that is no coordinate.
void check_coordinate(const models::FamilyInfo& family, const std::string& field, const std::string& name) {
  const std::vector<std::string> known = names_of(family.coordinates);
  if (contains(known, name)) return;
  throw ArgumentError(fmt::format("{}: the {} of \"{}\" has no free coordinate \"{}\"{}", field,
                                  family.source, family.model, name, suggestion(name, known)));
}

/// A name may stand in one list only, and must be known. What the family holds may be fixed again, at the
/// same value.
void check_names(const models::FamilyInfo& family, const FitOptions& options) {
  std::set<std::string> seen;
  const auto check = [&](const std::string& field, const std::string& name) {
    check_coordinate(family, field, name);
    if (!seen.insert(name).second) {
      throw ArgumentError(
          fmt::format("{}: \"{}\" has a role already; one of shared, per_capture, known, fixed was expected",
                      field, name));
    }
  };
  for (const std::string& name : options.unknowns.shared) check("shared", name);
  for (const std::string& name : options.unknowns.per_capture) check("per_capture", name);
  for (const auto& [name, value] : options.unknowns.known) check("known", name);
  for (const auto& [name, value] : options.unknowns.fixed) {
    const auto held = family.fixed.find(name);
    if (held == family.fixed.end()) {
      check("fixed", name);
    } else if (std::abs(held->second - value) > 1e-12 * std::abs(value)) {
      throw ArgumentError(fmt::format("fixed: \"{}\" is {}, but the {} holds it at {}", name, value,
                                      family.source, held->second));
    }
  }
  for (const auto& [name, interval] : options.unknowns.box) check_coordinate(family, "box", name);
}

/// The coordinate with the box of the fit, which must lie in the family's.
models::FamilyCoordinate narrowed(const models::FamilyInfo& family,
                                  const models::FamilyCoordinate& coordinate, const FitOptions& options) {
  const auto found = options.unknowns.box.find(coordinate.name);
  if (found == options.unknowns.box.end()) return coordinate;
  const models::Interval& box = found->second;
  if (box.lower < coordinate.lower || box.upper > coordinate.upper) {
    throw ArgumentError(fmt::format(
        "the box of \"{}\" goes from {} to {}; an interval within that of the {}, {} to {}, "
        "was expected",
        coordinate.name, box.lower, box.upper, family.source, coordinate.lower, coordinate.upper));
  }
  models::FamilyCoordinate result = coordinate;
  result.lower = box.lower;
  result.upper = box.upper;
  return result;
}

CoordinateSlot fixed_slot(const models::FamilyInfo& family, const models::FamilyCoordinate& coordinate,
                          double value) {
  if (value < coordinate.lower || value > coordinate.upper) {
    throw ArgumentError(
        fmt::format("\"{}\" is fixed at {}; a value in the box of the {}, {} to {}, was expected",
                    coordinate.name, value, family.source, coordinate.lower, coordinate.upper));
  }
  return {CoordinateRole::fixed, 0, value};
}

void assign_roles(const models::FamilyInfo& family, const FitOptions& options, FitProblem& problem) {
  const std::vector<std::string> measurement = measurement_names(options);
  for (const models::FamilyCoordinate& coordinate : family.coordinates) {
    if (coordinate.name == family.clock) {
      problem.clock = problem.slots.size();
      problem.slots.push_back({});
      continue;
    }
    if (const auto fixed = options.unknowns.fixed.find(coordinate.name);
        fixed != options.unknowns.fixed.end()) {
      problem.slots.push_back(fixed_slot(family, coordinate, fixed->second));
      problem.fixed[coordinate.name] = fixed->second;
      continue;
    }
    if (const auto known = options.unknowns.known.find(coordinate.name);
        known != options.unknowns.known.end()) {
      const auto index = static_cast<int>(std::distance(options.unknowns.known.begin(), known));
      problem.slots.push_back({CoordinateRole::known, index, 0.0});
      continue;
    }
    const bool is_own_by_default = coordinate.is_initial || contains(measurement, coordinate.name);
    const bool own = contains(options.unknowns.per_capture, coordinate.name) ||
                     (is_own_by_default && !contains(options.unknowns.shared, coordinate.name));
    auto& list = own ? problem.own : problem.shared;
    problem.slots.push_back(
        {own ? CoordinateRole::own : CoordinateRole::shared, static_cast<int>(list.size()), 0.0});
    list.push_back(narrowed(family, coordinate, options));
  }
}

const models::FamilyOutput& find_output(const models::FamilyInfo& family, const std::string& field,
                                        const std::string& name) {
  std::vector<std::string> known;
  for (const models::FamilyOutput& output : family.outputs) {
    if (output.name == name) return output;
    known.push_back(output.name);
  }
  throw ArgumentError(fmt::format("{}: the {} of \"{}\" has no output \"{}\"{}", field, family.source,
                                  family.model, name, suggestion(name, known)));
}

/// The numbers of an attitude are compared as one, so that what is said of one of them would have no effect.
void require_compared_alone(const models::FamilyInfo& family, const std::string& field,
                            const std::string& name, const std::string& instead) {
  find_output(family, field, name);
  if (!contains(family.attitude, name)) return;
  throw ArgumentError(
      fmt::format("{}: \"{}\" is a number of an attitude ({}), which is compared by its turn; {}", field,
                  name, join(family.attitude), instead));
}

bool measure_attitude(const models::FamilyInfo& family, std::span<const Capture> captures) {
  const auto measured = [&](const std::string& name) {
    return std::ranges::all_of(captures, [&](const Capture& c) { return c.has(name); });
  };
  return !family.attitude.empty() && std::ranges::all_of(family.attitude, measured);
}

/// What was asked for, or every output that all captures measure.
std::vector<models::FamilyOutput> choose_outputs(const models::FamilyInfo& family,
                                                 std::span<const Capture> captures,
                                                 const std::vector<std::string>& names) {
  std::vector<models::FamilyOutput> chosen;
  for (const std::string& name : names) {
    const models::FamilyOutput& output = find_output(family, "outputs", name);
    if (!contains(family.attitude, name)) chosen.push_back(output);
    if (std::ranges::count(names, name) > 1)
      throw ArgumentError(fmt::format("outputs: \"{}\" stands there twice", name));
  }
  if (!names.empty()) return chosen;
  std::vector<std::string> known;
  for (const models::FamilyOutput& output : family.outputs) {
    known.push_back(output.name);
    if (contains(family.attitude, output.name)) continue;  // compared as one
    if (std::ranges::all_of(captures, [&](const Capture& c) { return c.has(output.name); }))
      chosen.push_back(output);
  }
  if (chosen.empty() && !measure_attitude(family, captures)) {
    // The fault of a file that measures none of them, if there is one.
    for (const Capture& capture : captures) {
      const auto measured = [&](const std::string& name) { return capture.has(name); };
      if (capture.file.empty() || std::ranges::any_of(known, measured)) continue;
      throw InputError(capture.file,
                       fmt::format("capture \"{}\" measures none of the outputs of \"{}\" ({}): a column of "
                                   "one of them, with its unit, was expected",
                                   capture.id, family.model, join(known)));
    }
    throw ArgumentError(fmt::format("the captures have no quantity in common with the outputs of \"{}\" ({})",
                                    family.model, join(known)));
  }
  return chosen;
}

double loss_scale(const models::FamilyOutput& output, const LossOptions& loss, bool is_only_output) {
  if (same_dimension(output.unit, "m")) return loss.length_scale;
  if (loss.kind == LossKind::none && is_only_output) return 1.0;
  throw ArgumentError(
      fmt::format("output \"{}\" [{}] has no loss scale; the size of a large residual was expected in "
                  "loss.scale",
                  output.name, output.unit));
}

void set_scale(const models::FamilyOutput& output, std::span<const Capture> captures,
               const FitOptions& options, bool is_only_output, ComparedOutput& compared) {
  const auto given = options.loss.scales.find(output.name);
  if (given != options.loss.scales.end()) {
    compared.scale = given->second;
  } else if (noise_is_estimated(options.noise, output.name)) {
    compared.scale =
        efficient_bend(options.loss.kind) * frame_scatter(captures, output.name, compared.period);
    compared.scale_is_scatter = true;
  } else {
    compared.scale = loss_scale(output, options.loss, is_only_output);
  }
}

bool has_offset(const models::FamilyInfo& family, const FitOptions& options, const std::string& output) {
  if (options.unknowns.offsets) return contains(*options.unknowns.offsets, output);
  return contains(family.translations, output) && !contains(names_of(family.coordinates), output + "(0)");
}

void assign_outputs(const models::FamilyInfo& family, std::span<const Capture> captures,
                    const FitOptions& options, FitProblem& problem) {
  const std::vector<models::FamilyOutput> chosen = choose_outputs(family, captures, options.compared.outputs);
  for (const auto& [name, scale] : options.loss.scales)
    require_compared_alone(family, "loss.scale", name, "attitude_scale is its size");
  for (const models::FamilyOutput& output : chosen) {
    ComparedOutput compared{.name = output.name, .unit = output.unit, .period = period_of(output, options)};
    set_scale(output, captures, options, chosen.size() == 1, compared);
    if (has_offset(family, options, output.name)) {
      compared.offset = static_cast<int>(problem.offsets.size());
      problem.offsets.push_back(output.name);
    }
    compared.scale_is_stated =
        options.loss.kind != LossKind::none || options.loss.scales.contains(output.name) ||
        (same_dimension(output.unit, "m") && options.loss.length_scale != LossOptions{}.length_scale);
    problem.outputs.push_back(compared);
    problem.requested.push_back(compared.name);
  }
  // What is asked for must be measured, by every capture (segments.h).
  const bool is_asked_for = std::ranges::any_of(
      options.compared.outputs, [&](const std::string& name) { return contains(family.attitude, name); });
  if (is_asked_for || (options.compared.outputs.empty() && measure_attitude(family, captures))) {
    problem.attitude_scale = options.loss.attitude_scale;
    problem.requested.insert(problem.requested.end(), family.attitude.begin(), family.attitude.end());
  }
  for (const auto& [name, period] : options.compared.periods)
    require_compared_alone(family, "periods", name, "it has no period");
  if (!options.unknowns.offsets) return;
  for (const std::string& name : *options.unknowns.offsets) {
    if (contains(problem.offsets, name)) continue;
    throw ArgumentError(
        fmt::format("offsets: \"{}\" is not among the compared outputs ({})", name, join(problem.requested)));
  }
}

/// Values that the options give shared coordinates for the first start.
/// @throws ArgumentError for what is not shared, and for values outside the box.
std::vector<std::pair<Eigen::Index, double>> stated_start(const FitOptions& options,
                                                          const FitProblem& problem) {
  std::vector<std::pair<Eigen::Index, double>> stated;
  for (const auto& [name, value] : options.starts.initial) {
    const std::optional<std::size_t> at = position(problem.shared, name);
    if (!at) {
      throw ArgumentError(fmt::format("initial: \"{}\" is not a shared coordinate{}", name,
                                      suggestion(name, names_of(problem.shared))));
    }
    const models::FamilyCoordinate& c = problem.shared[*at];
    if (!(value >= c.lower && value <= c.upper)) {
      throw ArgumentError(fmt::format("initial: \"{}\" is {}; a value in its box, {} to {}, was expected",
                                      name, value, c.lower, c.upper));
    }
    stated.emplace_back(static_cast<Eigen::Index>(*at), value);
  }
  return stated;
}

}  // namespace

int FitProblem::observation_count() const {
  std::size_t count = 0;
  for (const Segment& segment : segments) {
    count += segment.observations.size() + 3 * segment.attitudes.size();
  }
  return static_cast<int>(count);
}

void family_point(const FitProblem& problem, const Motion& motion, const double* shared, const double* own,
                  Eigen::VectorXd& q) {
  for (std::size_t k = 0; k < problem.slots.size(); ++k) {
    const CoordinateSlot& slot = problem.slots[k];
    double& value = q[static_cast<Eigen::Index>(k)];
    switch (slot.role) {
      case CoordinateRole::shared:
        value = shared[slot.index];
        break;
      case CoordinateRole::own:
        value = own[slot.index];
        break;
      case CoordinateRole::known:
        value = motion.known[static_cast<std::size_t>(slot.index)];
        break;
      case CoordinateRole::fixed:
        value = slot.value;
        break;
    }
  }
}

Eigen::Vector4d start_attitude(const FitProblem& problem, const Segment& segment) {
  if (!segment.attitudes.empty()) return Eigen::Vector4d(segment.attitudes.front().q_WB.data());
  Eigen::Vector4d middle;
  for (std::size_t part = 0; part < 4; ++part) {
    const models::FamilyCoordinate& c = problem.own[*problem.own_attitude + part];
    middle[static_cast<Eigen::Index>(part)] = 0.5 * (c.lower + c.upper);
  }
  return unit_attitude(middle);
}

Eigen::Vector4d unit_attitude(const Eigen::Vector4d& q) {
  constexpr double kShort = 0.1;
  const double length = q.norm();
  return length < kShort ? Eigen::Vector4d(1.0, 0.0, 0.0, 0.0) : Eigen::Vector4d(q / length);
}

double period_of(const models::FamilyOutput& output, const FitOptions& options) {
  constexpr double kFullTurn = 2.0 * std::numbers::pi;
  const auto found = options.compared.periods.find(output.name);
  if (found != options.compared.periods.end()) return found->second;
  return output.unit == "rad" ? kFullTurn : 0.0;
}

int FitProblem::join_rows() const {
  int rows = 0;
  for (const JoinRule& rule : joins) rows += rule.rows();
  return rows;
}

bool FitProblem::is_joined() const {
  return std::ranges::any_of(segments, &Segment::joined);
}

namespace {

/// Captures, or the spans of each.
std::vector<Capture> cut(const models::FamilyInfo& family, std::span<const Capture> captures,
                         const FitOptions& options) {
  if (!family.autonomous) {
    throw ArgumentError(
        fmt::format("stride: the equations of \"{}\" depend on time, and spans have times of their own; "
                    "whole captures were expected",
                    family.model));
  }
  std::vector<Capture> parts;
  for (const Capture& capture : captures) {
    for (Capture& part :
         spans(capture, *options.compared.span, *options.compared.stride, options.compared.outputs))
      parts.push_back(std::move(part));
  }
  if (parts.empty()) {
    throw ArgumentError(fmt::format("none of {} captures holds a span of {} s; a shorter one was expected",
                                    captures.size(), *options.compared.span));
  }
  return parts;
}

}  // namespace

FitProblem describe_problem(const models::FamilyInfo& of_model, std::span<const Capture> captures,
                            const FitOptions& options) {
  validate(options);
  if (captures.empty()) throw ArgumentError("there are no captures; at least one was expected");
  const models::FamilyInfo family = with_measurement(of_model, options);
  check_names(family, options);
  FitProblem problem;
  problem.loss = options.loss.kind;
  problem.averaged_frames = options.compared.averaged_frames;
  problem.fixed = family.fixed;
  for (const auto& [name, value] : options.unknowns.known) problem.known.push_back(name);
  assign_roles(family, options, problem);
  assign_outputs(family, captures, options, problem);
  add_camera(family, options, problem);
  add_measurement(options, problem);
  return problem;
}

FitProblem make_problem(const models::FamilyInfo& family, std::span<const Capture> whole,
                        const FitOptions& options) {
  validate(options);
  std::vector<Capture> parts;
  if (options.compared.stride) parts = cut(family, whole, options);
  const std::span<const Capture> captures = options.compared.stride ? std::span<const Capture>(parts) : whole;
  FitProblem problem = describe_problem(family, captures, options);
  if (problem.shared_count() + problem.own_count() == 0) {
    throw ArgumentError("every coordinate is fixed; at least one to fit was expected");
  }
  add_charts(family, options, problem);
  add_priors(options, problem);
  problem.initial = stated_start(options, problem);
  add_segments(with_measurement(family, options), captures, options, problem);
  if (options.starts.round_body && problem.is_joined()) {
    throw ArgumentError(
        "round_body is set and captures are cut into joined segments; segments.length no shorter than the "
        "captures was expected");
  }
  if (problem.is_joined()) add_joins(family, problem);
  return problem;
}

}  // namespace samara::identification
