#include "samara/models/stochastic/gust_layout.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

namespace {

/// -1: there is none.
int parameter_index(const ModelInfo& info, const std::string& name) {
  const auto found = std::ranges::find(info.parameters, name, &ParameterInfo::name);
  return found == info.parameters.end() ? -1 : static_cast<int>(found - info.parameters.begin());
}

int state_index(const ModelInfo& info, const std::string& name) {
  const auto found = std::ranges::find(info.states, name, &StateInfo::name);
  return found == info.states.end() ? -1 : static_cast<int>(found - info.states.begin());
}

std::vector<int> three_from(int first) {
  return {first, first + 1, first + 2};
}

/// Index of the first state of the groups of a kind.
std::vector<int> groups_of(const ModelInfo& info, StateGroupKind kind) {
  std::vector<int> first;
  for (const StateGroup& group : info.groups) {
    if (group.kind == kind) first.push_back(group.first);
  }
  return first;
}

std::vector<std::string> gust_names(bool in_plane) {
  const std::string axes = in_plane ? "xy" : "xyz";
  std::vector<std::string> names = {"gust_start"};
  for (const char* of : {"gust_", "gust_rate_"}) {
    for (const char axis : axes) names.push_back(std::string(of) + axis);
  }
  for (const char of : axes) {
    for (const char along : axes) names.push_back(std::string("gust_gradient_") + of + along);
  }
  if (in_plane) {
    names.emplace_back("gust_spin");
  } else {
    for (const char axis : axes) names.push_back(std::string("gust_spin_") + axis);
  }
  return names;
}

}  // namespace

GustLayout::GustLayout(const Model& model) {
  const ModelInfo& info = model.info();
  const auto lacks = [&](const std::string& what) {
    return ArgumentError(
        fmt::format("model \"{}\" has no {}: it cannot fly through gusts; one like immersed_body_in_gusts, "
                    "sphere_flight_in_gusts or falling_plate_in_gusts was expected",
                    info.name, what));
  };
  const int theta = state_index(info, "theta");
  if (theta >= 0) space_ = Space::plane;
  names_ = gust_names(space_ == Space::plane);
  for (const std::string& name : names_) {
    parameters_.push_back(parameter_index(info, name));
    if (parameters_.back() < 0) throw lacks("parameter " + name);
  }
  if (space_ == Space::plane) {
    attitude_ = theta;
    position_ = {state_index(info, "x"), state_index(info, "y")};
    velocity_ = {state_index(info, "vx"), state_index(info, "vy")};
    rotation_ = {state_index(info, "w")};
    for (const auto* of : {&position_, &velocity_, &rotation_}) {
      if (std::ranges::count(*of, -1) > 0) throw lacks("states vx, vy, w, theta, x, y");
    }
    return;
  }
  const std::vector<int> place = groups_of(info, StateGroupKind::position);
  const std::vector<int> quaternion = groups_of(info, StateGroupKind::quaternion);
  const std::vector<int> vectors = groups_of(info, StateGroupKind::vector);
  if (place.size() != 1) throw lacks("group of states for its position");
  position_ = three_from(place[0]);
  const int states = static_cast<int>(info.states.size());
  if (quaternion.size() == 1 && quaternion[0] + 10 <= states) {
    attitude_ = quaternion[0];
    velocity_ = three_from(attitude_ + 4);
    rotation_ = three_from(attitude_ + 7);
  } else if (quaternion.empty() && vectors.size() == 2) {
    space_ = Space::point;
    velocity_ = three_from(vectors[0]);
    rotation_ = three_from(vectors[1]);
  } else {
    throw lacks("states of an attitude and its velocities, nor two vectors");
  }
}

Eigen::Matrix3d GustLayout::follows(const Model& model, std::span<const double> x, ParameterValues p) const {
  const auto states = static_cast<std::size_t>(model.info().states.size());
  BodyOnPath motion;
  read([&](int i) { return x[static_cast<std::size_t>(i)]; }, motion);
  const auto acceleration = [&](const Eigen::Vector3d& rate) {
    write([&](int j, double value) { p.value[static_cast<std::size_t>(j)] = value; }, 0.0,
          Eigen::Vector3d::Zero(), rate);
    std::vector<double> f(states);
    model.rhs(0.0, x, p, f);
    Eigen::Vector3d change = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < velocity_.size(); ++i) {
      const int axis = space_ == Space::plane && i == 1 ? 2 : static_cast<int>(i);
      change[axis] = f[static_cast<std::size_t>(velocity_[i])];
    }
    return change;
  };
  const Eigen::Vector3d still = acceleration(Eigen::Vector3d::Zero());
  Eigen::Matrix3d by_world;
  for (int k = 0; k < 3; ++k) by_world.col(k) = acceleration(Eigen::Vector3d::Unit(k)) - still;
  // A point has its velocities in the world, where its attitude is the identity.
  return by_world * motion.attitude;
}

double outline_radius(const ModelInfo& info, std::span<const double> parameters) {
  const auto value = [&](const char* name) {
    const int index = parameter_index(info, name);
    return index < 0 ? 0.0 : parameters[static_cast<std::size_t>(index)];
  };
  if (parameter_index(info, "a") >= 0 && parameter_index(info, "b") >= 0)
    return std::sqrt(value("a") * value("b"));
  if (parameter_index(info, "semi_chord") >= 0) return value("semi_chord");
  // Of a body by coefficients its reference area stands for its outline.
  if (parameter_index(info, "area") >= 0) return std::sqrt(value("area") / std::numbers::pi);
  return 0.5 * value("diameter");
}

}  // namespace samara::models
