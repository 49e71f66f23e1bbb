#pragma once

#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/warnings.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/trajectory_family.h"

/// `count` times from 0 to `end`.
inline std::vector<double> even_times(int count, double end) {
  std::vector<double> times;
  for (int k = 0; k < count; ++k) times.push_back(end * k / (count - 1));
  return times;
}

inline samara::identification::Capture make_capture(const std::string& id, const std::vector<double>& times,
                                                    const Eigen::VectorXd& x) {
  samara::identification::Capture capture;
  capture.id = id;
  capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  capture.channels.push_back({"x", "m", x});
  return capture;
}

inline void add_noise(samara::identification::Capture& capture, double sigma, std::mt19937_64& random) {
  std::normal_distribution<double> normal(0.0, sigma);
  for (samara::identification::Channel& channel : capture.channels) {
    for (double& value : channel.values) value += normal(random);
  }
}

/// One warning a line.
inline std::string text_of(const samara::identification::Warnings& warnings) {
  return fmt::format("{}", fmt::join(warnings.sentences(), "\n"));
}

/// A coin in water.
inline const std::map<std::string, double>& coin_fixed() {
  static const std::map<std::string, double> fixed = {
      {"area", 4.71435e-4}, {"thickness", 2.55e-3}, {"density", 6338.6}};
  return fixed;
}

inline std::unique_ptr<samara::models::TrajectoryFamily> coin_family() {
  return samara::models::reference_trajectories(samara::models::find_model("vertical_fall"), coin_fixed(),
                                                {{"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}});
}

/// Depth of the coin by the integrator, from `offset` on.
inline samara::identification::Capture coin_capture(const std::string& id, double C_D, double v0,
                                                    double offset) {
  const samara::models::ParametricModel model(samara::models::find_model("vertical_fall"), coin_fixed(),
                                              {"C_D", "v(0)"});
  const std::vector<double> times = even_times(25, 0.4);
  const auto trajectory = samara::models::integrate(model, std::vector{C_D, v0}, times);
  return make_capture(id, times, trajectory.states.col(1).array() + offset);
}

/// x = v0 (1 - exp(-k t))/k: a body that drag proportional to speed brings to rest. In closed form: for tests
/// that run many fits.
class BrakedFamily final : public samara::models::TrajectoryFamily {
 public:
  BrakedFamily() {
    info_.model = "braked";
    info_.source = "closed form";
    info_.coordinates = {{"k", "s^-1", false, 0.2, 5.0}, {"v(0)", "m/s", true, 0.2, 3.0}};
    info_.outputs = {{"x", "m"}};
    info_.translations = {"x"};
  }

  static double depth(double k, double v0, double t) { return v0 * -std::expm1(-k * t) / k; }
  static Eigen::VectorXd depths(double k, double v0, const std::vector<double>& times) {
    Eigen::VectorXd x(static_cast<Eigen::Index>(times.size()));
    for (Eigen::Index row = 0; row < x.size(); ++row)
      x[row] = depth(k, v0, times[static_cast<std::size_t>(row)]);
    return x;
  }

  samara::models::FamilyInfo& mutable_info() { return info_; }
  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>& times,
                                                       const std::vector<std::string>&) const override {
    return std::make_unique<Source>(times);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    explicit Source(const std::vector<double>& at_times) : times(at_times) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      values.col(0) = depths(q[0], q[1], times);
      if (!derivatives) return {};
      for (std::size_t row = 0; row < times.size(); ++row) {
        const double kt = q[0] * times[row];
        const auto at = static_cast<Eigen::Index>(row);
        (*derivatives)(at, 0) = q[1] * (kt * std::exp(-kt) + std::expm1(-kt)) / (q[0] * q[0]);
        (*derivatives)(at, 1) = depth(q[0], 1.0, times[row]);
      }
      return {};
    }
    std::vector<double> times;
  };

  samara::models::FamilyInfo info_;
};
