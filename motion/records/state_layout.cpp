#include "samara/motion/records/state_layout.h"

#include <algorithm>

namespace samara::motion {

namespace {

/// Indices of states of these names. @returns whether all are there
template <std::size_t N>
bool find_states(const models::ModelInfo& info, const std::array<const char*, N>& names,
                 std::span<std::size_t> indices) {
  for (std::size_t k = 0; k < N; ++k) {
    const auto found = std::ranges::find(info.states, names[k], &models::StateInfo::name);
    if (found == info.states.end()) return false;
    indices[k] = static_cast<std::size_t>(found - info.states.begin());
  }
  return true;
}

}  // namespace

std::optional<StateLayout> StateLayout::of(const models::ModelInfo& info) {
  StateLayout layout;
  if (find_states<3>(info, {"x", "y", "z"}, layout.position)) {
    if (!find_states<4>(info, {"qw", "qx", "qy", "qz"}, layout.attitude)) return {};
    layout.has_velocities = find_states<3>(info, {"ux", "uy", "uz"}, layout.velocity) &&
                            find_states<3>(info, {"wx", "wy", "wz"}, layout.rate);
    return layout;
  }
  std::array<std::size_t, 1> z = {};
  layout.is_planar = true;
  if (find_states<1>(info, {"z"}, z) || !find_states<2>(info, {"x", "y"}, layout.position) ||
      !find_states<1>(info, {"theta"}, layout.attitude))
    return {};
  layout.has_velocities =
      find_states<2>(info, {"vx", "vy"}, layout.velocity) && find_states<1>(info, {"w"}, layout.rate);
  return layout;
}

}  // namespace samara::motion
