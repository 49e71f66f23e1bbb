#include "samara/identification/problem/measurement.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture.h"

namespace samara::identification {

namespace {

void add_unknown(const models::FamilyCoordinate& unknown, models::FamilyInfo& family) {
  if (position(family.coordinates, unknown.name) || family.fixed.contains(unknown.name)) {
    throw ArgumentError(
        fmt::format("\"{}\" is a coordinate of \"{}\" itself; a model without one of that name was expected",
                    unknown.name, family.model));
  }
  family.coordinates.push_back(unknown);
}

void add_gain(const std::string& output, std::size_t slot, FitProblem& problem) {
  std::vector<std::string> compared;
  for (const ComparedOutput& one : problem.outputs) compared.push_back(one.name);
  const auto found = std::ranges::find(problem.outputs, output, &ComparedOutput::name);
  if (found == problem.outputs.end()) {
    throw ArgumentError(
        fmt::format("gain: \"{}\" is not among the compared outputs ({})", output, join(compared)));
  }
  if (problem.camera && problem.camera->scale) {
    const auto column = static_cast<int>(found - problem.outputs.begin());
    if (std::ranges::count(problem.camera->columns, column) > 0) {
      throw ArgumentError(
          fmt::format("gain: \"{0}\" is scaled by the camera already, and the two are one; either the gain "
                      "of \"{0}\" or the scale of the camera was expected",
                      output));
    }
  }
  found->gain = slot;
}

/// The delay, and where it may lie.
std::string delay_text(const models::Interval& range) {
  return range.width() > 0.0 ? fmt::format("a delay of {:.6g} s to {:.6g} s", range.lower, range.upper)
                             : fmt::format("a delay of {:.6g} s", range.lower);
}

}  // namespace

std::vector<models::FamilyCoordinate> measurement_coordinates(const FitOptions& options) {
  std::vector<models::FamilyCoordinate> all;
  if (const auto& delay = options.measurement.delay)
    all.push_back({kDelay, "s", false, delay->lower, delay->upper});
  for (const auto& [output, range] : options.measurement.gains)
    all.push_back({gain_name(output), "1", false, range.lower, range.upper});
  return all;
}

models::FamilyInfo with_measurement(const models::FamilyInfo& family, const FitOptions& options) {
  models::FamilyInfo extended = family;
  for (const models::FamilyCoordinate& unknown : measurement_coordinates(options))
    add_unknown(unknown, extended);
  return extended;
}

void add_measurement(const FitOptions& options, FitProblem& problem) {
  std::size_t slot = problem.slots.size() - measurement_names(options).size();
  problem.model_slots = slot;
  if (options.measurement.delay) {
    if (options.compared.stride) {
      throw ArgumentError(
          "delay: spans of a capture (stride) start where they are cut, not at a release, and have no delay; "
          "whole captures were expected");
    }
    problem.delay = slot++;
  }
  for (const auto& [output, range] : options.measurement.gains) add_gain(output, slot++, problem);
}

models::Interval delay_range(const FitProblem& problem, const Motion& motion) {
  if (!problem.delay) return {};
  const CoordinateSlot& slot = problem.slots[*problem.delay];
  const auto index = static_cast<std::size_t>(slot.index);
  switch (slot.role) {
    case CoordinateRole::shared:
      return {problem.shared[index].lower, problem.shared[index].upper};
    case CoordinateRole::own:
      return {problem.own[index].lower, problem.own[index].upper};
    case CoordinateRole::known:
      return {motion.known[index], motion.known[index]};
    case CoordinateRole::fixed:
      break;
  }
  return {slot.value, slot.value};
}

void check_delay(const models::FamilyInfo& family, const FitProblem& problem, const Motion& motion,
                 const models::Interval& frames, double rounding) {
  const models::Interval range = delay_range(problem, motion);
  const double first = frames.lower + range.lower;
  const double last = frames.upper + range.upper;
  if (first < -rounding) {
    refuse(motion.file,
           fmt::format(
               "capture \"{}\" has a frame {:.6g} s after the start of the motion, and {} asks the {} for it "
               "{:.6g} s before the start; a delay of {:.6g} s or more was expected",
               motion.id, frames.lower, delay_text(range), family.source, -first, 0.0 - frames.lower));
  }
  if (last > family.end_time + rounding) {
    refuse(
        motion.file,
        fmt::format(
            "capture \"{}\" lasts {:.6g} s, and with {} it asks for {:.6g} s, but the {} ends at {:.6g} s; a "
            "delay of at most {:.6g} s, or a shorter `span`, was expected",
            motion.id, frames.upper, delay_text(range), last, family.source, family.end_time,
            family.end_time - frames.upper));
  }
}

double delay_at(const FitProblem& problem, const Eigen::VectorXd& q) {
  return problem.delay ? q[static_cast<Eigen::Index>(*problem.delay)] : 0.0;
}

double gain_at(const ComparedOutput& output, const Eigen::VectorXd& q) {
  return output.gain ? q[static_cast<Eigen::Index>(*output.gain)] : 1.0;
}

bool is_of_measurement(const FitProblem& problem, int own) {
  if (own >= problem.own_count() - problem.camera_count()) return true;
  for (std::size_t k = problem.model_slots; k < problem.slots.size(); ++k) {
    if (problem.slots[k].role == CoordinateRole::own && problem.slots[k].index == own) return true;
  }
  return false;
}

}  // namespace samara::identification
