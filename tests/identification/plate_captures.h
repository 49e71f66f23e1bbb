#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/pgd/tensors/random.h"

/// Angle and place of a plate as a camera sees them, with normal noise.
/// @param states of falling_plate_nd, a row for each time
inline samara::identification::Capture seen_plate(const std::vector<double>& times,
                                                  const Eigen::MatrixXd& states, double noise,
                                                  std::uint64_t seed) {
  samara::pgd::Random random(seed);
  samara::identification::Capture capture;
  capture.id = "plate";
  capture.times =
      Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size())).array() -
      times.front();
  const std::vector<std::pair<std::string, int>> seen = {{"theta", 3}, {"x", 4}, {"y", 5}};
  for (const auto& [name, state] : seen) {
    samara::identification::Channel channel{name, "1", states.col(state)};
    for (double& value : channel.values) value += noise * random.normal();
    capture.channels.push_back(std::move(channel));
  }
  return capture;
}

/// `frames` times over 6 units of time from `begin` on.
inline std::vector<double> plate_times(int frames, double begin) {
  constexpr double kEnd = 6.0;
  std::vector<double> times;
  for (int k = 0; k < frames; ++k) times.push_back(begin + kEnd * k / (frames - 1));
  return times;
}

/// States of a plate at times, by CVODES.
inline Eigen::MatrixXd plate_states(const std::map<std::string, double>& values,
                                    const std::vector<double>& times) {
  const samara::models::ParametricModel model(samara::models::find_model("falling_plate_nd"), values, {});
  return samara::models::integrate(model, {}, times).states;
}
