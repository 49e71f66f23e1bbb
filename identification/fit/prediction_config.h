#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/fit/prediction.h"

/// What the config of a fit says of predictions:
///
///     [prediction]
///     span = "0.1 s"                      # seen of each capture left out; else the span of the fit
///     ahead = "1 s"
///     stride = "0.5 s"                    # a prediction every 0.5 s, not one from its start
///     left_out = { flight = ["98", "126"] }   # of the captures given, those with one of these labels
///     fitted = { flight = ["120"] }           # else all the others
///     folds = 5                           # or: each fifth of the clusters by a fit of the others
///     folds = { count = 5, seed = 1 }     #     dealt in a random order
///     hidden = ["wx(0)"]                  # of [known], what captures left out do not show
///     mixture = true                      # forecasts as distributions, and predictors mixed
///     views = [["area_1", "area_2"]]      # channels: what cameras along x and y show besides the place
namespace samara::identification {

/// Labels, and the texts that they may have. "id" and "file" (its name without folder and ending) are labels
/// of every capture.
using LabelChoice = std::map<std::string, std::vector<std::string>>;

struct PredictionConfig {
  std::optional<double> span = {}, ahead = {}, stride = {};  ///< s
  LabelChoice fitted = {}, left_out = {};                    ///< empty: not said
  std::optional<Folds> folds = {};
  std::vector<std::string> hidden = {};
  bool mixture = false;
  std::vector<ViewPair> views = {};  ///< no channel twice
};

/// Nothing is said where the file has no table [prediction].
/// @throws InputError as read_fit_config()
PredictionConfig read_prediction_config(const std::filesystem::path& path);
/// The same from a text. @param name stands for the file in messages.
PredictionConfig parse_prediction_config(std::string_view text, const std::string& name);

struct CaptureSplit {
  std::vector<Capture> fitted, left_out;
};
/// What is fitted and what is left out of the captures given; the rest takes no part.
/// @throws ArgumentError for a label or text that no capture has, and for captures that are both
CaptureSplit split(std::span<const Capture> captures, const PredictionConfig& config);

}  // namespace samara::identification
