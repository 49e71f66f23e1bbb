#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/identification/fit/prediction.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "synthetic.h"

/// Motions whose continuation is known, for tests of predictions.
namespace predicted_motions {

using namespace samara::identification;

/// Braked motions of k = 1.4 with different speeds.
inline std::vector<Capture> braked(int first, int count, double noise) {
  std::mt19937_64 random(static_cast<std::uint64_t>(first) + 1);
  const std::vector<double> times = even_times(31, 1.5);
  std::vector<Capture> captures;
  for (int c = first; c < first + count; ++c) {
    captures.push_back(make_capture(fmt::format("{}", c), times,
                                    BrakedFamily::depths(1.4, 0.6 + 0.1 * c, times).array() + 0.2 * c));
    add_noise(captures.back(), noise, random);
  }
  return captures;
}

inline const PredictionScore& of(const std::vector<PredictionScore>& scores, const std::string& predictor,
                                 const std::string& quantity) {
  const auto found = std::ranges::find_if(
      scores, [&](const PredictionScore& s) { return s.predictor == predictor && s.quantity == quantity; });
  REQUIRE(found != scores.end());
  return *found;
}

inline const std::map<std::string, double>& plate() {
  static const std::map<std::string, double> values = {{"a", 0.05},   {"b", 0.03},       {"c", 0.001},
                                                       {"C_D0", 0.1}, {"C_T", 1.0},      {"C_R", 1.0},
                                                       {"C_w", 1.0},  {"density", 200.0}};
  return values;
}

inline std::unique_ptr<samara::models::TrajectoryFamily> plate_family() {
  std::map<std::string, samara::models::Interval> box = {{"C_D90", {0.5, 2.0}}};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.0, 1.0};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-1.0, 1.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-5.0, 5.0};
  return step_trajectories(samara::models::find_model("immersed_body"), plate(), box, 2e-3);
}

inline FitOptions plain() {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  return options;
}

}  // namespace predicted_motions
