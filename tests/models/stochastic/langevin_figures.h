#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>

#include "samara/base/streams.h"

/// What a process must have to be the velocity and the path of the fluid, all at once: one with the right variance
/// alone may have anything else wrong.
///
/// Unit deviation and unit time T throughout.

/// Velocities and positions of many particles at 0, h, 2 h, .., steps h; all start at x = 0.
struct ProcessRecord {
  Eigen::MatrixXd u, x;  ///< particles x (1 + steps)
};

/// Runs that many particles for that many steps of length h.
using Process = std::function<ProcessRecord(double h, long steps, long particles)>;

struct Figure {
  std::string name;
  double value, expected, tolerance;
  bool holds() const { return std::abs(value - expected) <= tolerance; }
};

/// Variance, autocorrelation, structure function and spread at step length h, each within 4 standard errors.
inline std::vector<Figure> figures_of(const Process& process, double h, long particles) {
  const long per_T = std::max(1L, std::lround(1.0 / h));
  const long last = std::max(1L, std::lround(6.0 / h));
  const ProcessRecord record = process(h, last, particles);
  const auto n = static_cast<double>(record.u.rows());
  const auto mean = [&](const Eigen::ArrayXd& values) { return values.mean(); };
  const Eigen::ArrayXd u_0 = record.u.col(0), u_h = record.u.col(1), u_T = record.u.col(per_T),
                       u_end = record.u.col(last), x_end = record.x.col(last);
  const double t = static_cast<double>(per_T) * h, end = static_cast<double>(last) * h;
  const double of_variance = 4.0 * std::sqrt(2.0 / n);
  const double increment = 2.0 * (1.0 - std::exp(-h)), spread = 2.0 * (end - 1.0 + std::exp(-end));
  return {{"variance", mean(u_end.square()), 1.0, of_variance},
          {"autocorrelation", mean(u_0 * u_T), std::exp(-t), 4.0 * std::sqrt((1.0 + std::exp(-2.0 * t)) / n)},
          {"structure function", mean((u_h - u_0).square()), increment, increment * of_variance},
          {"spread", mean(x_end.square()), spread, spread * of_variance}};
}

/// Figures that do not hold at step lengths from T/100 to 2 T, by one set of constants.
inline std::vector<std::string> faults_of(const Process& process) {
  std::vector<std::string> faults;
  for (const double h : {0.01, 0.1, 0.5, 1.0, 2.0}) {
    for (const Figure& figure : figures_of(process, h, h < 0.1 ? 5000 : 30000)) {
      if (!figure.holds())
        faults.push_back(fmt::format("{} at h = {} T: {}, expected {} +- {}", figure.name, h, figure.value,
                                     figure.expected, figure.tolerance));
    }
  }
  return faults;
}

/// A process that moves one velocity at a time: next(u, h, standard normal).
inline Process stepped(const std::function<double(double u, double h, double normal)>& next) {
  return [next](double h, long steps, long particles) {
    ProcessRecord record = {Eigen::MatrixXd(particles, steps + 1),
                            Eigen::MatrixXd::Zero(particles, steps + 1)};
    for (long n = 0; n < particles; ++n) {
      samara::Stream noise(11, static_cast<std::uint64_t>(n));
      record.u(n, 0) = noise.normal();
      for (long k = 0; k < steps; ++k) {
        record.u(n, k + 1) = next(record.u(n, k), h, noise.normal());
        record.x(n, k + 1) = record.x(n, k) + h * record.u(n, k + 1);
      }
    }
    return record;
  };
}

/// Concentrations in bins of a period, of particles that were even at first.
inline Eigen::VectorXd concentrations(const Eigen::ArrayXd& z, int bins) {
  Eigen::VectorXd count = Eigen::VectorXd::Zero(bins);
  for (const double place : z) {
    const double folded = place - std::floor(place);
    count[std::min(bins - 1, static_cast<int>(folded * bins))] += 1.0;
  }
  return count * bins / static_cast<double>(z.size());
}
