#include "samara/identification/problem/chart.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <ceres/jet.h>

#include "samara/models/integrators/rotations.h"

namespace samara::identification {

namespace {

/// A number with its derivatives by the parts of two quaternions.
using QuaternionJet = ceres::Jet<double, 8>;
using JetQuaternion = std::array<QuaternionJet, 4>;

/// conj(p) q
JetQuaternion conjugate_product(const JetQuaternion& p, const JetQuaternion& q) {
  return {p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3],
          p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2],
          p[0] * q[2] + p[1] * q[3] - p[2] * q[0] - p[3] * q[1],
          p[0] * q[3] - p[1] * q[2] + p[2] * q[1] - p[3] * q[0]};
}

/// The rotation vector of a quaternion of any length and sign.
std::array<QuaternionJet, 3> rotation_vector(JetQuaternion d) {
  if (d[0].a < 0.0) {
    for (QuaternionJet& part : d) part = -part;
  }
  const QuaternionJet sine2 = d[1] * d[1] + d[2] * d[2] + d[3] * d[3];
  QuaternionJet factor;
  if (sine2.a > 1e-14 * d[0].a * d[0].a) {
    const QuaternionJet sine = sqrt(sine2);
    factor = 2.0 * atan2(sine, d[0]) / sine;
  } else {
    factor = 2.0 / d[0];  // tan(x) = x to round-off
  }
  return {factor * d[1], factor * d[2], factor * d[3]};
}

}  // namespace

Chart::Chart(const std::vector<Kind>& kinds) {
  for (const Kind kind : kinds) {
    parts_.push_back({kind, size_, directions_});
    size_ += is_attitude(kind) ? 4 : 1;
    directions_ += directions_of(kind);
  }
}

int Chart::directions_of(Kind kind) {
  switch (kind) {
    case Kind::held:
      return 0;
    case Kind::quaternion:
      return 3;
    case Kind::axis:
      return 2;
    default:
      return 1;
  }
}

Chart Chart::holding(int unknown) const {
  std::vector<Kind> kinds;
  for (const Part& part : parts_) kinds.push_back(part.unknown == unknown ? Kind::held : part.kind);
  return Chart(kinds);
}

bool Chart::is_linear() const {
  return std::ranges::all_of(parts_, [](const Part& part) { return part.kind == Kind::linear; });
}

bool Chart::is_part_of_quaternion(int unknown) const {
  return std::ranges::any_of(parts_, [&](const Part& part) {
    return is_attitude(part.kind) && unknown >= part.unknown && unknown < part.unknown + 4;
  });
}

bool Chart::is_logarithmic(int unknown) const {
  return std::ranges::any_of(
      parts_, [&](const Part& part) { return part.kind == Kind::logarithmic && part.unknown == unknown; });
}

int Chart::direction_of(int unknown) const {
  for (const Part& part : parts_) {
    const int offset = unknown - part.unknown;
    if (offset >= 0 && offset < directions_of(part.kind)) return part.direction + offset;
  }
  return -1;
}

void Chart::plus(const double* x, const double* step, double* y) const {
  for (const Part& part : parts_) {
    const double* from = x + part.unknown;
    const double* d = step + part.direction;
    double* to = y + part.unknown;
    switch (part.kind) {
      case Kind::held:
        to[0] = from[0];
        break;
      case Kind::linear:
        to[0] = from[0] + d[0];
        break;
      case Kind::logarithmic:
        to[0] = from[0] * std::exp(d[0]);
        break;
      case Kind::axis:
      case Kind::quaternion: {
        const double about_z = part.kind == Kind::axis ? 0.0 : d[2];
        const models::Quaternion moved = models::normalised(models::product(
            {from[0], from[1], from[2], from[3]}, models::rotation_exponential({d[0], d[1], about_z})));
        std::ranges::copy(moved, to);
        break;
      }
    }
  }
}

void Chart::minus(const double* y, const double* x, double* step) const {
  for (const Part& part : parts_) {
    const double* from = x + part.unknown;
    const double* to = y + part.unknown;
    double* d = step + part.direction;
    switch (part.kind) {
      case Kind::held:
        break;
      case Kind::linear:
        d[0] = to[0] - from[0];
        break;
      case Kind::logarithmic:
        d[0] = std::log(to[0] / from[0]);
        break;
      case Kind::quaternion:
        Eigen::Map<Eigen::Vector3d, Eigen::Unaligned>{d} = turn_between(from, to).vector;
        break;
      case Kind::axis:
        Eigen::Map<Eigen::Vector2d, Eigen::Unaligned>{d} = turn_between(from, to).vector.head<2>();
        break;
    }
  }
}

Chart::Block Chart::plus_block(Kind kind, const double* q) {
  switch (kind) {
    case Kind::held:
      return Block(1, 0);
    case Kind::linear:
      return Block::Ones(1, 1);
    case Kind::logarithmic:
      return Block::Constant(1, 1, q[0]);
    case Kind::quaternion:
    case Kind::axis:
      break;
  }
  Eigen::Matrix<double, 4, 3> by_turn;
  by_turn << -q[1], -q[2], -q[3],  //
      q[0], -q[3], q[2],           //
      q[3], q[0], -q[1],           //
      -q[2], q[1], q[0];
  return 0.5 * by_turn.leftCols(directions_of(kind));
}

Chart::Block Chart::minus_block(Kind kind, const double* q) {
  if (is_attitude(kind)) return turn_between(q, q).by_to.topRows(directions_of(kind));
  return plus_block(kind, q).cwiseInverse().transpose();  // one number, or none
}

Eigen::MatrixXd Chart::plus_jacobian(const double* x) const {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(size_, directions_);
  for (const Part& part : parts_) {
    const Block block = plus_block(part.kind, x + part.unknown);
    jacobian.block(part.unknown, part.direction, block.rows(), block.cols()) = block;
  }
  return jacobian;
}

Eigen::MatrixXd Chart::minus_jacobian(const double* x) const {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(directions_, size_);
  for (const Part& part : parts_) {
    const Block block = minus_block(part.kind, x + part.unknown);
    jacobian.block(part.direction, part.unknown, block.rows(), block.cols()) = block;
  }
  return jacobian;
}

Turn turn_between(const double* from, const double* to) {
  JetQuaternion p, q;
  for (int i = 0; i < 4; ++i) {
    p[static_cast<std::size_t>(i)] = QuaternionJet(from[i], i);
    q[static_cast<std::size_t>(i)] = QuaternionJet(to[i], i + 4);
  }
  const std::array<QuaternionJet, 3> r = rotation_vector(conjugate_product(p, q));
  Turn turn;
  for (int i = 0; i < 3; ++i) {
    const QuaternionJet& component = r[static_cast<std::size_t>(i)];
    turn.vector[i] = component.a;
    turn.by_from.row(i) = component.v.head<4>().transpose();
    turn.by_to.row(i) = component.v.tail<4>().transpose();
  }
  return turn;
}

}  // namespace samara::identification
