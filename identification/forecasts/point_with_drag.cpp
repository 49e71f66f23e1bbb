#include "samara/identification/forecasts/point_with_drag.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>

namespace samara::identification {

namespace {

/// Place and velocity at the first frame, and log k.
using Start = Eigen::VectorXd;

/// The component along which the point weighs, and how much, m/s^2.
struct Weight {
  Eigen::Index up;
  double net;
};

/// Places at times that do not fall, from the first frame on; times x components. Velocities are carried on by
/// steps that a strong drag does not make unstable: RK4 within a twentieth of a second and of 1/(k |v|).
Eigen::MatrixXd fly(const Start& start, const Weight& weight, double begin, const Eigen::VectorXd& times) {
  const Eigen::Index count = (start.size() - 1) / 2;
  const double k = std::exp(start[2 * count]);
  Eigen::Vector3d x = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
  x.head(count) = start.head(count);
  v.head(count) = start.segment(count, count);
  const Eigen::Vector3d pull = -weight.net * Eigen::Vector3d::Unit(weight.up);
  const auto acceleration = [&](const Eigen::Vector3d& velocity) -> Eigen::Vector3d {
    return pull - k * velocity.norm() * velocity;
  };
  Eigen::MatrixXd places(times.size(), count);
  double now = begin;
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    constexpr int kMostSteps = 10000;
    for (int taken = 0; now < times[row] && taken < kMostSteps; ++taken) {
      const double braking = k * std::max(v.norm(), std::sqrt(std::abs(weight.net) / k));
      const double h = std::min({times[row] - now, 0.05, 0.5 / braking});
      const Eigen::Vector3d a1 = acceleration(v), v2 = v + 0.5 * h * a1;
      const Eigen::Vector3d a2 = acceleration(v2), v3 = v + 0.5 * h * a2;
      const Eigen::Vector3d a3 = acceleration(v3), v4 = v + h * a3;
      const Eigen::Vector3d a4 = acceleration(v4);
      x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
      now = h < times[row] - now ? now + h : times[row];
    }
    places.row(row) = x.head(count).transpose();
  }
  return places;
}

struct Descent {
  Start start;
  double cost;
};

/// Levenberg and Marquardt, with derivatives by differences.
Descent descend(Start start, const Eigen::VectorXd& times, const Eigen::MatrixXd& seen,
                const Weight& weight) {
  const auto residual = [&](const Start& at) -> Eigen::VectorXd {
    return (fly(at, weight, times[0], times) - seen).reshaped();
  };
  Eigen::VectorXd r = residual(start);
  double cost = r.squaredNorm(), damping = 1e-3;
  constexpr int kMost = 20;
  for (int turn = 0; turn < kMost && damping < 1e8; ++turn) {
    Eigen::MatrixXd J(r.size(), start.size());
    for (Eigen::Index k = 0; k < start.size(); ++k) {
      constexpr double kStep = 1e-6;
      Start moved = start;
      moved[k] += kStep;
      J.col(k) = (residual(moved) - r) / kStep;
    }
    Eigen::MatrixXd normal = J.transpose() * J;
    normal.diagonal().array() += damping * normal.diagonal().array().max(1e-12);
    Start next = start - normal.ldlt().solve(J.transpose() * r);
    constexpr double kWidest = 12.0;  // of log k: final speeds of 8 mm/s to 1 km/s
    next.tail<1>() = next.tail<1>().cwiseMax(-kWidest).cwiseMin(kWidest);
    const Eigen::VectorXd there = next.allFinite() ? residual(next) : Eigen::VectorXd();
    if (there.size() > 0 && there.squaredNorm() < cost) {
      const bool is_still = cost - there.squaredNorm() < 1e-9 * cost;
      start = next;
      r = there;
      cost = r.squaredNorm();
      damping *= 0.2;
      if (is_still) break;
    } else {
      damping *= 8.0;
    }
  }
  return {start, cost};
}

}  // namespace

Eigen::MatrixXd predict_point_with_drag(const SeenMotion& span, const Eigen::VectorXd& times) {
  const Eigen::Index count = span.positions.cols();
  const Eigen::MatrixXd unsaid =
      Eigen::MatrixXd::Constant(times.size(), count, std::numeric_limits<double>::quiet_NaN());
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < span.times.size(); ++k) {
    if (span.positions.row(k).allFinite()) frames.push_back(k);
  }
  constexpr Eigen::Index kFewest = 4;
  if (span.up < 0 || span.up >= count || count > 3 || std::ssize(frames) < kFewest || times.size() == 0)
    return unsaid;
  const Eigen::VectorXd seen_times = span.times(frames);
  const Eigen::MatrixXd seen = span.positions(frames, Eigen::all);
  if (times.minCoeff() < seen_times[0] || !std::isfinite(span.net_weight)) return unsaid;

  const Eigen::Index last = seen_times.size() - 1;
  const double length = seen_times[last] - seen_times[0];
  const Eigen::VectorXd mean_velocity = (seen.row(last) - seen.row(0)).transpose() / length;
  // Still gaining speed, or near the final one.
  const double speed = std::max(std::abs(mean_velocity[span.up]), 0.01);
  const Weight weight = {span.up, span.net_weight};
  constexpr double kLightest = 1e-3;  // m/s^2: what floats has a drag, too
  Descent best{{}, std::numeric_limits<double>::infinity()};
  for (const double part : {0.1, 1.0}) {
    Start start(2 * count + 1);
    start << seen.row(0).transpose(), mean_velocity,
        std::log(part * std::max(std::abs(weight.net), kLightest) / (speed * speed));
    const Descent here = descend(start, seen_times, seen, weight);
    if (here.cost < best.cost) best = here;
  }
  if (best.start.size() == 0) return unsaid;
  std::vector<Eigen::Index> order(static_cast<std::size_t>(times.size()));
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<Eigen::Index>(k);
  std::ranges::sort(order, {}, [&](Eigen::Index k) { return times[k]; });
  Eigen::MatrixXd result = unsaid;
  const Eigen::MatrixXd flown = fly(best.start, weight, seen_times[0], times(order));
  for (std::size_t k = 0; k < order.size(); ++k)
    result.row(order[k]) = flown.row(static_cast<Eigen::Index>(k));
  return result;
}

}  // namespace samara::identification
