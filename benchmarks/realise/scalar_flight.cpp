#include "scalar_flight.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include <Eigen/Geometry>

#include "samara/models/laws/immersed_body.h"

namespace samara::benchmarks {

namespace {

using models::laws::GustRamp;
using models::laws::ImmersedBody;
using State = std::array<double, models::laws::kPoseStates>;

void take_step(double t, double h, State& x, const double* p) {
  const GustRamp flow;
  const auto rate = [&](double time, const State& at) {
    State f;
    ImmersedBody::rhs(flow, time, at.data(), p, f.data());
    return f;
  };
  const auto ahead = [&](const State& k, double way) {
    State y = x;
    for (std::size_t i = 0; i < y.size(); ++i) y[i] += way * k[i];
    return y;
  };
  const State k1 = rate(t, x);
  const State k2 = rate(t + 0.5 * h, ahead(k1, 0.5 * h));
  const State k3 = rate(t + 0.5 * h, ahead(k2, 0.5 * h));
  const State k4 = rate(t + h, ahead(k3, h));
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
}

Eigen::Vector3d velocity_of(const State& x) {
  const Eigen::Quaterniond q(x[3], x[4], x[5], x[6]);
  return q.normalized() * Eigen::Vector3d(x[7], x[8], x[9]);
}

}  // namespace

double fly_one_by_one(const std::vector<double>& x_0, const std::vector<double>& p_0,
                      const ScalarGusts& gusts, long flights, double step, long steps) {
  double sum = 0.0;
  std::vector<double> p = p_0;
  double* const ramp = p.data() + ImmersedBody::kParameters;
  for (long n = 0; n < flights; ++n) {
    std::mt19937 generator(static_cast<unsigned>(n));
    std::normal_distribution<double> normal;
    const auto draw = [&] {
      return Eigen::Vector3d(normal(generator), normal(generator), normal(generator));
    };
    State x;
    std::ranges::copy(x_0, x.begin());
    Eigen::Vector3d w = draw();
    Eigen::Vector3d air = gusts.sigma * w;
    Eigen::Vector3d mean_u_r = velocity_of(x);
    for (long k = 0; k < steps; ++k) {
      mean_u_r -= std::expm1(-0.1 * step / gusts.T) * (velocity_of(x) - air - mean_u_r);
      const double speed = mean_u_r.norm(), bs = 0.565 * 6.0 / gusts.C_0 * speed / gusts.sigma;
      const double along = std::exp(-step / gusts.T * std::sqrt(1.0 + bs * bs));
      const double across = std::exp(-step / gusts.T * std::sqrt(1.0 + 4.0 * bs * bs));
      const Eigen::Vector3d axis = mean_u_r / speed, xi = draw();
      const double across_noise = std::sqrt(1.0 - across * across);
      w = across * w + across_noise * xi +
          ((along - across) * axis.dot(w) + (std::sqrt(1.0 - along * along) - across_noise) * axis.dot(xi)) *
              axis;
      const Eigen::Vector3d next = gusts.sigma * w;
      const double t = static_cast<double>(k) * step;
      ramp[0] = t;
      for (int i = 0; i < 3; ++i) {
        ramp[1 + i] = air[i];
        ramp[4 + i] = (next[i] - air[i]) / step;
      }
      take_step(t, step, x, p.data());
      air = next;
    }
    sum += x[2];
  }
  return sum / static_cast<double>(flights);
}

}  // namespace samara::benchmarks
