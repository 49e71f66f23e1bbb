#include "samara/identification/smoothing/smoothing_attitude.h"

#include <cmath>
#include <limits>
#include <random>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "files.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/smoothing.h"

using namespace samara::identification;
using Eigen::Index;
using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

constexpr double kUnseenPart = std::numeric_limits<double>::quiet_NaN();

Quaterniond rotated(const Vector3d& phi) {
  const double angle = phi.norm();
  return angle > 0.0 ? Quaterniond(Eigen::AngleAxisd(angle, phi / angle)) : Quaterniond::Identity();
}

/// Precession and spin: q = exp(z a t) exp(x b) exp(z c t), whose body rate and its derivative are known.
struct Top {
  double precession = 3.0, tilt = 0.7, spin = 8.0;

  Quaterniond attitude(double t) const {
    return rotated({0.0, 0.0, precession * t}) * rotated({tilt, 0.0, 0.0}) * rotated({0.0, 0.0, spin * t});
  }
  Vector3d rate(double t) const {
    const Vector3d vertical_tilted(0.0, precession * std::sin(tilt), precession * std::cos(tilt));
    return rotated({0.0, 0.0, -spin * t}) * vertical_tilted + Vector3d(0.0, 0.0, spin);
  }
  Vector3d rate_derivative(double t) const { return rate(t).cross(Vector3d(0.0, 0.0, spin)); }
};

struct Seen {
  Eigen::VectorXd times;
  Eigen::MatrixX4d quaternions;
};

Seen seen_top(const Top& top, int count, double interval, double noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, noise);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  Seen seen{Eigen::VectorXd(count), Eigen::MatrixX4d(count, 4)};
  for (Index k = 0; k < count; ++k) {
    seen.times[k] = interval * (static_cast<double>(k) + jitter(random));
    const Vector3d error(normal(random), normal(random), normal(random));
    const Quaterniond q = top.attitude(seen.times[k]) * rotated(noise > 0.0 ? error : Vector3d::Zero());
    seen.quaternions.row(k) << q.w(), q.x(), q.y(), q.z();
  }
  return seen;
}

Quaterniond attitude_in(const SmoothedAttitude& s, Index row) {
  return {s.attitude(row, 0), s.attitude(row, 1), s.attitude(row, 2), s.attitude(row, 3)};
}

/// The small rotation from one attitude to another, in body axes, whatever the signs.
Vector3d small_rotation(const Quaterniond& from, const Quaterniond& to) {
  const Quaterniond between = from.conjugate() * to;
  return 2.0 * (between.w() < 0.0 ? -1.0 : 1.0) * between.vec();
}

}  // namespace

TEST_CASE("a steady spin is reproduced exactly, whatever the signs and lengths of its quaternions") {
  std::mt19937_64 random(1);
  const Vector3d rate(5.0, -9.0, 14.0);
  const Quaterniond start = rotated({0.3, 1.0, -0.5});
  Seen seen{Eigen::VectorXd::LinSpaced(80, 0.0, 0.79), Eigen::MatrixX4d(80, 4)};
  for (Index k = 0; k < 80; ++k) {
    const Quaterniond q = start * rotated(rate * seen.times[k]);
    const double factor = (random() % 2 == 0 ? 1.0 : -1.0) * (1.0 + 0.1 * static_cast<double>(random() % 5));
    seen.quaternions.row(k) = factor * Eigen::RowVector4d(q.w(), q.x(), q.y(), q.z());
  }
  seen.quaternions.middleRows(20, 5).setConstant(kUnseenPart);
  Eigen::Vector4d at(0.0, 0.222, 0.4005, 0.79);
  const SmoothedAttitude s = smooth_attitude(seen.times, seen.quaternions, at, {.bandwidth = 0.12});
  for (Index k = 0; k < at.size(); ++k) {
    CHECK(std::abs(s.attitude.row(k).norm() - 1.0) < 1e-15);
    CHECK(small_rotation(start * rotated(rate * at[k]), attitude_in(s, k)).norm() < 1e-13);
    CHECK((s.angular_velocity.row(k).transpose() - rate).norm() < 1e-10);
    CHECK(s.angular_acceleration.row(k).norm() < 1e-7);
  }
  CHECK(s.outlier.count() == 0);
}

TEST_CASE("attitude, angular velocity and its derivative converge with the order of the degree") {
  const Top top;
  const double t = 0.37;
  const auto errors = [&](double bandwidth) -> Vector3d {
    Seen seen{Eigen::VectorXd::LinSpaced(201, t - bandwidth, t + bandwidth), Eigen::MatrixX4d(201, 4)};
    for (Index k = 0; k < 201; ++k) {
      const Quaterniond q = top.attitude(seen.times[k]);
      seen.quaternions.row(k) << q.w(), q.x(), q.y(), q.z();
    }
    const SmoothedAttitude s = smooth_attitude(seen.times, seen.quaternions, Eigen::VectorXd::Constant(1, t),
                                               {.bandwidth = bandwidth, .outlier_threshold = INFINITY});
    return {small_rotation(top.attitude(t), attitude_in(s, 0)).norm(),
            (s.angular_velocity.row(0).transpose() - top.rate(t)).norm(),
            (s.angular_acceleration.row(0).transpose() - top.rate_derivative(t)).norm()};
  };
  // Quartics through the frames about the time: h^6, h^4 and h^4 (see smoothing_test.cpp).
  const Vector3d order = (errors(0.16).array() / errors(0.08).array()).log() / std::log(2.0);
  CHECK(order[0] > 5.7);
  CHECK(order[1] > 3.8);
  CHECK(order[2] > 3.8);
}

TEST_CASE("standard errors of attitudes cover the truth as often as they say") {
  const Top top;
  const double noise = 0.035;  // 2 degrees
  const int records = 150;
  int inside[3] = {};
  double estimated = 0.0;
  for (unsigned record = 0; record < records; ++record) {
    std::mt19937_64 random(record);
    const Seen seen = seen_top(top, 60, 1.0 / 240.0, noise, random);
    const double t = record % 2 == 0 ? 0.12 : seen.times[0];
    const SmoothedAttitude s =
        smooth_attitude(seen.times, seen.quaternions, Eigen::VectorXd::Constant(1, t), {.bandwidth = 0.08});
    estimated += s.noise / records;
    const Vector3d errors[3] = {small_rotation(top.attitude(t), attitude_in(s, 0)),
                                s.angular_velocity.row(0).transpose() - top.rate(t),
                                s.angular_acceleration.row(0).transpose() - top.rate_derivative(t)};
    for (Index axis = 0; axis < 3; ++axis) {
      inside[0] += std::abs(errors[0][axis]) < 1.96 * s.attitude_error(0, axis);
      inside[1] += std::abs(errors[1][axis]) < 1.96 * s.angular_velocity_error(0, axis);
      inside[2] += std::abs(errors[2][axis]) < 1.96 * s.angular_acceleration_error(0, axis);
    }
  }
  // 450 components: 1.0 % standard deviation.
  for (const int count : inside) {
    CHECK(count > 0.92 * 3 * records);
    CHECK(count < 0.98 * 3 * records);
  }
  CHECK(std::abs(estimated - noise) < 0.02 * noise);
}

TEST_CASE("a tumbling plate whose sides look alike keeps its sense of rotation") {
  // Any of its half turns, any sign, 5 % wrong poses: the smoothed attitude is the true one up to one
  // symmetry for the whole record, and the wrong poses are named.
  const BodySymmetries symmetries = half_turns();
  for (unsigned record = 0; record < 10; ++record) {
    std::mt19937_64 random(record);
    const Top top{.precession = 4.0, .tilt = 1.2, .spin = 20.0};
    Seen seen = seen_top(top, 120, 1.0 / 120.0, 0.035, random);
    Eigen::Array<bool, Eigen::Dynamic, 1> wrong(120);
    for (Index k = 0; k < 120; ++k) {
      Quaterniond q(seen.quaternions(k, 0), seen.quaternions(k, 1), seen.quaternions(k, 2),
                    seen.quaternions(k, 3));
      wrong[k] = k > 4 && random() % 20 == 0;
      if (wrong[k]) q = q * rotated({0.8, -0.6, 0.5});
      const auto look = random() % 4;
      if (look > 0) {
        const Eigen::Vector4d& g = symmetries[look - 1];
        q = q * Quaterniond(g[0], g[1], g[2], g[3]);
      }
      if (random() % 2 == 0) q.coeffs() *= -1.0;
      seen.quaternions.row(k) << q.w(), q.x(), q.y(), q.z();
    }
    const Eigen::VectorXd at = seen.times.segment(2, 116);
    const SmoothedAttitude s =
        smooth_attitude(seen.times, seen.quaternions, at, {.bandwidth = 0.1}, symmetries);
    // The symmetry of the first frame is everyone's.
    Quaterniond look = Quaterniond::Identity();
    double nearest = small_rotation(top.attitude(at[0]), attitude_in(s, 0)).norm();
    for (const Eigen::Vector4d& g : symmetries) {
      const Quaterniond candidate(g[0], g[1], g[2], g[3]);
      const double distance = small_rotation(top.attitude(at[0]) * candidate, attitude_in(s, 0)).norm();
      if (distance < nearest) {
        nearest = distance;
        look = candidate;
      }
    }
    double largest = 0.0;
    for (Index k = 0; k < at.size(); ++k) {
      const Vector3d error = small_rotation(top.attitude(at[k]) * look, attitude_in(s, k));
      const Vector3d rate_error = s.angular_velocity.row(k).transpose() - look.conjugate() * top.rate(at[k]);
      largest = std::max({largest, error.cwiseAbs().maxCoeff() / s.attitude_error(k, 0),
                          rate_error.cwiseAbs().maxCoeff() / s.angular_velocity_error(k, 0)});
    }
    CHECK(largest < 6.0);
    CHECK((wrong && !s.outlier).segment(2, 116).count() == 0);
    CHECK((!wrong && s.outlier).count() <= 1);
  }
}

TEST_CASE("smoothing of attitudes refuses what is none") {
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(10, 0.0, 0.9);
  Eigen::MatrixX4d quaternions = Eigen::MatrixX4d::Zero(10, 4);
  const auto refusal = [&](const BodySymmetries& symmetries) {
    return error_of<samara::ArgumentError>(
        [&] { smooth_attitude(times, quaternions, times.head(1), {}, symmetries); });
  };
  CHECK(refusal({}) == "the quaternion of frame 0 has length 0");
  quaternions.col(0).setOnes();
  CHECK(refusal({}) == "no exception");
  CHECK(refusal({{1.0, 1.0, 0.0, 0.0}}) ==
        "a symmetry of the body is (1, 1, 0, 0); a unit quaternion was expected");
}
