#include "samara/motion/events/moving_states.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::motion {

namespace {

struct UnitQuaternion {
  double w, x, y, z;
};

UnitQuaternion unit_quaternion(std::span<const double> state, const std::array<std::size_t, 4>& at) {
  const double w = state[at[0]], x = state[at[1]], y = state[at[2]], z = state[at[3]];
  const double scale = 1.0 / std::sqrt(w * w + x * x + y * y + z * z);
  return {scale * w, scale * x, scale * y, scale * z};
}

/// q v q*, by 2 r x (w v + r x v).
Eigen::Vector3d turned_to_world(const UnitQuaternion& q, const Eigen::Vector3d& v) {
  const double cx = q.y * v[2] - q.z * v[1] + q.w * v[0];
  const double cy = q.z * v[0] - q.x * v[2] + q.w * v[1];
  const double cz = q.x * v[1] - q.y * v[0] + q.w * v[2];
  return {v[0] + 2.0 * (q.y * cz - q.z * cy), v[1] + 2.0 * (q.z * cx - q.x * cz),
          v[2] + 2.0 * (q.x * cy - q.y * cx)};
}

/// The same of the z axis.
Eigen::Vector3d turned_z(const UnitQuaternion& q) {
  return {2.0 * (q.x * q.z + q.w * q.y), 2.0 * (q.y * q.z - q.w * q.x), 1.0 - 2.0 * (q.x * q.x + q.y * q.y)};
}

/// Value of a parameter, or 0 where the model has none of that name.
double parameter_or_zero(const models::ModelInfo& info, std::span<const double> parameters,
                         const std::string& name) {
  for (std::size_t j = 0; j < info.parameters.size(); ++j) {
    if (info.parameters[j].name == name) return parameters[j];
  }
  return 0.0;
}

/// Rotations by pi about x, y, z keep that coordinate and turn the two others.
void half_turn_about(int axis, std::span<double> reduced) {
  for (std::size_t k = 0; k < reduced.size(); ++k) {
    if (static_cast<int>(k % 3) != axis) reduced[k] = -reduced[k];
  }
}

}  // namespace

MovingStates::MovingStates(const models::ModelInfo& info, BodySymmetry symmetry)
    : count_(info.states.size()), symmetry_(symmetry) {
  const auto layout = StateLayout::of(info);
  if (!layout || !layout->has_velocities) {
    throw ArgumentError(
        fmt::format("model \"{}\" has no states x, y, z, qw, .., ux, .., wx, .. of a body in space, nor x, "
                    "y, theta, vx, vy, w "
                    "of one in a plane: its motions have no events",
                    info.name));
  }
  layout_ = *layout;
  const bool fits = symmetry == BodySymmetry::none || is_planar() == (symmetry == BodySymmetry::half_turn);
  if (!fits) {
    throw ArgumentError(fmt::format("model \"{}\" moves in {}, which the symmetry given is not of", info.name,
                                    is_planar() ? "a plane" : "space"));
  }
}

MovingStates MovingStates::of(const models::Model& model, std::span<const double> parameters) {
  const models::ModelInfo& info = model.info();
  const MovingStates plain(info, BodySymmetry::none);
  if (plain.is_planar()) {
    const bool turns = std::ranges::find(info.symmetries, "turn of the body by pi") != info.symmetries.end();
    return {info, turns ? BodySymmetry::half_turn : BodySymmetry::none};
  }
  const auto value = [&](const char* name) { return parameter_or_zero(info, parameters, name); };
  const double a = value("a"), b = value("b");
  // Of other bodies in space nothing says that a turn leaves them as they are.
  const bool is_ellipsoid = a > 0.0 && b > 0.0 && value("c") > 0.0;
  const bool is_centred = value("r_bx") == 0.0 && value("r_by") == 0.0 && value("r_bz") == 0.0;
  if (!is_ellipsoid || !is_centred) return plain;
  // Added masses are integrals, equal but for round-off.
  const auto are_equal = [&](const char* along, const char* across) {
    const double x = value(along), y = value(across);
    return std::abs(x - y) <= 1e-9 * std::max(std::abs(x), std::abs(y));
  };
  const bool is_round = a == b && are_equal("I_x", "I_y") && are_equal("M_x", "M_y") &&
                        are_equal("J_x", "J_y") && are_equal("linear_damping_x", "linear_damping_y");
  return {info, is_round ? BodySymmetry::disc : BodySymmetry::ellipsoid};
}

MovingStates MovingStates::of_record(bool is_planar) {
  MovingStates states;
  states.count_ = 9;
  states.layout_.is_planar = is_planar;
  states.is_of_record_ = true;
  return states;
}

Eigen::Vector3d MovingStates::place(std::span<const double> state) const {
  if (is_of_record_) return {state[0], state[1], state[2]};
  return layout_.place(state);
}

double MovingStates::speed_square(std::span<const double> state) const {
  if (is_of_record_) return Eigen::Map<const Eigen::Vector3d>(state.data() + 3).squaredNorm();
  double sum = 0.0;
  for (const std::size_t i : layout_.velocities()) sum += state[i] * state[i];
  return sum;
}

BodyMotion MovingStates::at(std::span<const double> state) const {
  BodyMotion motion;
  if (is_of_record_) {
    motion.position = Eigen::Map<const Eigen::Vector3d>(state.data());
    motion.velocity = Eigen::Map<const Eigen::Vector3d>(state.data() + 3);
    motion.normal = Eigen::Map<const Eigen::Vector3d>(state.data() + 6);
    return motion;
  }
  const auto& v = layout_.velocity;
  motion.position = layout_.place(state);
  if (is_planar()) {
    const double angle = state[layout_.attitude[0]], s = std::sin(angle), c = std::cos(angle);
    const double vx = state[v[0]], vy = state[v[1]];
    motion.velocity = {vx * c - vy * s, 0.0, vx * s + vy * c};
    motion.normal = {-s, 0.0, c};
    return motion;
  }
  const UnitQuaternion q = unit_quaternion(state, layout_.attitude);
  motion.velocity = turned_to_world(q, {state[v[0]], state[v[1]], state[v[2]]});
  motion.normal = turned_z(q);
  return motion;
}

void MovingStates::reduce(std::span<const double> state, std::span<double> reduced) const {
  const auto &v = layout_.velocity, &w = layout_.rate;
  if (is_planar()) {
    const double angle = (symmetry_ == BodySymmetry::half_turn ? 2.0 : 1.0) * state[layout_.attitude[0]];
    reduced[0] = state[v[0]];
    reduced[1] = state[v[1]];
    reduced[2] = state[w[0]];
    reduced[3] = std::sin(angle);
    reduced[4] = std::cos(angle);
    return;
  }
  const UnitQuaternion q = unit_quaternion(state, layout_.attitude);
  const UnitQuaternion back = {q.w, -q.x, -q.y, -q.z};
  const Eigen::Vector3d down = turned_to_world(back, -Eigen::Vector3d::UnitZ());
  for (std::size_t k = 0; k < 3; ++k) {
    reduced[k] = down[static_cast<Eigen::Index>(k)];
    reduced[3 + k] = state[v[k]];
    reduced[6 + k] = state[w[k]];
  }
  if (symmetry_ != BodySymmetry::disc) return;
  const double across = std::hypot(reduced[3], reduced[4]);
  if (!(across > 0.0)) return;
  const double c = reduced[3] / across, s = reduced[4] / across;
  for (std::size_t k = 0; k < 9; k += 3) {
    const double along = reduced[k];
    reduced[k] = c * along + s * reduced[k + 1];
    reduced[k + 1] = c * reduced[k + 1] - s * along;
  }
}

int MovingStates::copies() const {
  switch (symmetry_) {
    case BodySymmetry::none:
      return 1;
    case BodySymmetry::half_turn:
    case BodySymmetry::disc:
      return 2;
    case BodySymmetry::ellipsoid:
      return 4;
  }
  return 1;
}

void MovingStates::turn_to_copy(int k, std::span<double> reduced) const {
  if (k == 0) return;
  if (is_planar()) {
    reduced[0] = -reduced[0];
    reduced[1] = -reduced[1];
    return;
  }
  // A disc's axes are given by its velocity; what remains is the half turn about it.
  half_turn_about(symmetry_ == BodySymmetry::disc ? 0 : k - 1, reduced);
}

StateMetric StateMetric::fitted(const MovingStates& states,
                                const Eigen::Ref<const Eigen::MatrixXd>& reduced) {
  if (reduced.rows() < 2 || reduced.cols() != states.reduced_size()) {
    throw ArgumentError(
        fmt::format("{} reduced states of {} numbers were given for a metric, expected two or more of {}",
                    reduced.rows(), reduced.cols(), states.reduced_size()));
  }
  Eigen::VectorXd weights(states.reduced_size());
  const auto over = [](double weight, double deviation, const char* what) {
    if (!(deviation > 0.0) || !std::isfinite(deviation))
      throw ArgumentError(fmt::format(
          "the states for a metric have a deviation of {} in {}, expected more than 0", deviation, what));
    return weight / deviation;
  };
  if (states.is_planar()) {
    constexpr std::array kNames = {"vx", "vy", "w"};
    for (Eigen::Index k = 0; k < 3; ++k) {
      const auto column = reduced.col(k).array();
      // With its copies the mean of a velocity is zero.
      const double mean = k < 2 && states.copies() > 1 ? 0.0 : column.mean();
      weights[k] = over(1.0, std::sqrt((column - mean).square().mean()), kNames[static_cast<std::size_t>(k)]);
    }
    weights.tail(2).setConstant(1.0 / 1.2);
    return StateMetric(weights);
  }
  const auto rms = [&](Eigen::Index first) {
    return std::sqrt(reduced.middleCols(first, 3).array().square().mean());
  };
  weights.head(3).setConstant(1.5);
  weights.segment(3, 3).setConstant(over(1.5, rms(3), "u"));
  weights.tail(3).setConstant(over(1.0, rms(6), "w"));
  return StateMetric(weights);
}

}  // namespace samara::motion
