#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/identification/fit/forecast_comparison.h"

/// Which model, from files: configs of fits, each with its model or codebook, and the captures that all of them are to
/// predict.
///
///     const ModelComparison comparison = compare_files({.configs = {"plain.toml", "wake.toml"},
///                                                       .sources = {"immersed_body", "immersed_body_with_wake"},
///                                                       .captures = {"drops.toml"}, .by = "drop"});
///     std::cout << comparison_text(comparison);  // fit/forecast_comparison_report.h
namespace samara::identification {

struct ComparisonRequest {
  /// TOML; their [prediction] says what is seen, and how far ahead.
  std::vector<std::filesystem::path> configs = {};
  std::vector<std::string> sources = {};  ///< models or codebooks: one for all, or one for each config
  std::vector<std::filesystem::path> captures = {};
  std::filesystem::path sidecar = {};  ///< of every table; empty: those beside them
  std::string by = {};                 ///< label of the clusters that are left out; "id": each capture
  std::optional<int> folds = {};       ///< clusters are dealt into so many; empty: each is left out alone
  std::optional<double> span = {}, ahead = {};  ///< s, in place of those of [prediction]
  ResamplingOptions resampling = {};
  ProgressCallback progress = {};
  std::function<void(const std::string& sentence)> warning = {};  ///< told each warning once
};

/// Of each config, the captures that its [prediction] fits or leaves out: all, where it says neither. Its own folds are
/// not looked at.
/// @throws ArgumentError for a request that makes no sense and for captures that do not suit a source; InputError
/// naming the file for everything wrong in one.
ModelComparison compare_files(const ComparisonRequest& request);

}  // namespace samara::identification
