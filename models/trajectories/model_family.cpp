#include "samara/models/trajectories/model_family.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/trajectories/model_symmetry.h"

namespace samara::models {

namespace {

std::vector<std::string> names_in(const std::map<std::string, Interval>& box) {
  std::vector<std::string> names;
  for (const auto& [name, interval] : box) names.push_back(name);
  return names;
}

void check_box(const ParametricModel& model, const std::map<std::string, Interval>& box) {
  std::vector<double> lower;
  std::vector<double> upper;
  for (const auto& [name, interval] : box) {
    if (!(interval.width() > 0.0)) {
      throw ArgumentError(
          fmt::format("the box of \"{}\" goes from {} to {}; an interval with a length was expected", name,
                      interval.lower, interval.upper));
    }
    lower.push_back(interval.lower);
    upper.push_back(interval.upper);
  }
  model.check(lower);
  model.check(upper);
}

FamilyInfo describe(const ParametricModel& model, const std::map<std::string, Interval>& box,
                    const std::string& source) {
  const ModelInfo& m = model.model().info();
  FamilyInfo info{.model = m.name, .source = source, .fixed = model.fixed()};
  for (const FreeCoordinate& c : model.free()) {
    const Interval& interval = box.at(c.name);
    info.coordinates.push_back({c.name, c.unit, c.is_initial, interval.lower, interval.upper});
  }
  for (const StateInfo& state : m.states) info.outputs.push_back({state.name, state.unit});
  describe_equations(model, info);
  return info;
}

}  // namespace

void require_free_coordinates(const std::map<std::string, Interval>& box) {
  if (box.empty()) throw ArgumentError("the box is empty; at least one free coordinate was expected");
}

TrajectoryOutcome outcome_of(const Trajectory& trajectory) {
  if (trajectory.is_usable()) return {};
  return {TrajectoryStatus::not_integrated, trajectory.message, trajectory.reached};
}

ModelFamily::ModelFamily(std::shared_ptr<const Model> model, const std::map<std::string, double>& fixed,
                         const std::map<std::string, Interval>& box, const std::string& source)
    : model_(std::move(model), fixed, names_in(box)) {
  check_box(model_, box);
  info_ = describe(model_, box, source);
}

std::vector<int> ModelFamily::state_indices(const std::vector<std::string>& outputs) const {
  std::vector<int> indices;
  for (const std::string& output : outputs) {
    const auto found = std::ranges::find(info_.outputs, output, &FamilyOutput::name);
    if (found == info_.outputs.end()) {
      throw ArgumentError(fmt::format("model \"{}\" has no state \"{}\"", info_.model, output));
    }
    indices.push_back(static_cast<int>(found - info_.outputs.begin()));
  }
  return indices;
}

}  // namespace samara::models
