#include "samara/models/bodies/body_pose.h"

#include <algorithm>
#include <cmath>

namespace samara::models {

namespace {

const StateInfo* state_of(const ModelInfo& info, const std::string& name) {
  const auto found = std::ranges::find(info.states, name, &StateInfo::name);
  return found == info.states.end() ? nullptr : &*found;
}

const StateGroup* group_of(const ModelInfo& info, StateGroupKind kind) {
  const auto found = std::ranges::find(info.groups, kind, &StateGroup::kind);
  return found == info.groups.end() ? nullptr : &*found;
}

void append(std::vector<std::string>& names, const ModelInfo& info, const StateGroup& group, int count) {
  for (int k = 0; k < count; ++k)
    names.push_back(info.states[static_cast<std::size_t>(group.first + k)].name);
}

}  // namespace

BodyPose PoseStates::pose(std::span<const double> values) const {
  BodyPose pose;
  switch (kind) {
    case Kind::line:
      pose.p_WB.z() = is_downward ? -values[0] : values[0];
      break;
    case Kind::plane:
      pose.p_WB = {values[0], 0.0, values[1]};
      // From x to z is a turn about -y.
      pose.q_WB = {std::cos(0.5 * values[2]), 0.0, -std::sin(0.5 * values[2]), 0.0};
      break;
    case Kind::space:
      pose.q_WB = Eigen::Vector4d(values[3], values[4], values[5], values[6]).normalized();
      [[fallthrough]];
    case Kind::point:
      pose.p_WB = {values[0], values[1], values[2]};
  }
  return pose;
}

std::optional<PoseStates> pose_states_of(const ModelInfo& info) {
  using Kind = PoseStates::Kind;
  if (const StateGroup* position = group_of(info, StateGroupKind::position)) {
    const StateGroup* attitude = group_of(info, StateGroupKind::quaternion);
    PoseStates states{.kind = attitude != nullptr ? Kind::space : Kind::point,
                      .names = {},
                      .unit = info.states[static_cast<std::size_t>(position->first)].unit};
    append(states.names, info, *position, 3);
    if (attitude != nullptr) append(states.names, info, *attitude, 4);
    return states;
  }
  const StateInfo* const x = state_of(info, "x");
  const StateInfo* const y = state_of(info, "y");
  const StateInfo* const z = state_of(info, "z");
  if (x != nullptr && (y == nullptr) != (z == nullptr) && state_of(info, "theta") != nullptr) {
    const StateInfo* const up = y != nullptr ? y : z;
    if (x->unit != up->unit) return std::nullopt;
    return PoseStates{.kind = Kind::plane, .names = {"x", up->name, "theta"}, .unit = x->unit};
  }
  if ((x != nullptr) + (y != nullptr) + (z != nullptr) != 1) return std::nullopt;
  const StateInfo* const only = x != nullptr ? x : y != nullptr ? y : z;
  if (only->unit != "m") return std::nullopt;
  return PoseStates{.kind = Kind::line,
                    .names = {only->name},
                    .unit = only->unit,
                    .is_downward = only->description.find("downward") != std::string::npos};
}

}  // namespace samara::models
