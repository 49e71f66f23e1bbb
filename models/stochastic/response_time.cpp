#include "samara/models/stochastic/response_time.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::models {

ResponseTime::ResponseTime(const ParametricModel& model, std::span<const double> point,
                           const GustLayout& layout)
    : model_(model.model()), layout_(layout) {
  const ModelInfo& info = model_.info();
  for (const ForceTermInfo& term : info.force_terms)
    is_of_fluid_.push_back(std::ranges::count(kNotDrag, term.name) == 0);
  p_.value = model.parameters(point);
  p_.given.assign(info.parameters.size(), 1);
  x_.resize(info.states.size());
  terms_.resize(info.force_terms.size());
}

double ResponseTime::operator()(const Lanes& lanes, int lane, double t, const Eigen::Vector3d& air) {
  if (terms_.empty()) return 0.0;
  lanes.read(lane, x_);
  layout_.write([&](int j, double value) { p_.value[static_cast<std::size_t>(j)] = value; }, t, air,
                Eigen::Vector3d::Zero());
  model_.forces(t, x_, p_, terms_);
  const std::vector<int>& rotation = layout_.rotation();
  double power = 0.0;
  for (std::size_t k = 0; k < terms_.size(); ++k) {
    if (!is_of_fluid_[k]) continue;
    power += terms_[k].power;
    for (std::size_t i = 0; i < rotation.size(); ++i) {
      const auto axis = static_cast<Eigen::Index>(rotation.size() == 1 ? 2 : i);
      power -= terms_[k].torque[axis] * x_[static_cast<std::size_t>(rotation[i])];
    }
  }
  for (const int i : rotation) x_[static_cast<std::size_t>(i)] = 0.0;
  const std::optional<double> energy = model_.kinetic_energy(t, x_, p_);
  if (!energy) return 0.0;
  return power != 0.0 ? 2.0 * *energy / std::abs(power) : std::numeric_limits<double>::infinity();
}

}  // namespace samara::models
