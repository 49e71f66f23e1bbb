#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/identification/following/follow_report.h"

/// A motion followed, from files, as `samara follow` does it.
///
///     const FollowReport report = follow_files({.source = "coin.h5", .fit = "fit.json", .track = "drop.csv"});
///     std::cout << follow_text(report);
namespace samara::identification {

struct FollowRequest {
  std::string source = {};  ///< a model by its name or its file of equations, or the file of a codebook
  std::filesystem::path fit = {};      ///< JSON of a fit of that model
  std::filesystem::path track = {};    ///< a table, or a sidecar (".toml"), with one capture
  std::filesystem::path sidecar = {};  ///< of every table; empty: those beside them
  /// Of that fit, TOML: where it found what is known of each capture, and its steps. Empty: labels of coordinates' own
  /// names, and steps of FollowOptions.
  std::filesystem::path config = {};
  /// Captures on which noise is chosen, not the track among them; empty: as given.
  std::vector<std::filesystem::path> training = {};
  double ahead = 0.0;  ///< s; 0: no forecasts
  /// Held, whatever training captures choose of the rest. What is neither given nor chosen is 0, and without noise of
  /// velocities and rates the model is exact.
  GivenNoise noise = {};
  /// Noise of outputs, or of the "attitude", SI, in place of the fit's, once names and units are known. Empty: none.
  std::function<std::map<std::string, double>(const models::ModelInfo& model)> frame_noise = {};
  std::optional<double> step = {};  ///< s, of Runge-Kutta steps
  std::optional<int> start_frames = {};
  ProgressCallback progress = {};
};

/// @throws ArgumentError for a request that makes no sense, and for noise that no state of the model has; InputError
/// naming the file for everything wrong in one.
FollowReport follow_files(const FollowRequest& request);

}  // namespace samara::identification
