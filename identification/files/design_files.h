#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "samara/identification/design/design.h"

/// The next experiment from files, as `samara design` does it.
///
///     const Design design = design_files({.source = "coin.h5", .fit = "fit.json"});
///     std::cout << design_text(design);
namespace samara::identification {

struct DesignRequest {
  std::string source = {};            ///< the file of a codebook, or the name of a model
  std::filesystem::path fit = {};     ///< JSON of the fit so far
  std::filesystem::path config = {};  ///< of that fit, TOML; a model needs it for its box and what is held
  /// What is asked for, once names and units are known. Empty: the defaults.
  std::function<DesignOptions(const models::FamilyInfo& family)> options = {};
  /// Told what is doubtful about source and fit, each once, before the work begins.
  std::function<void(const std::string& sentence)> warning = {};
};

/// @throws ArgumentError for a request that makes no sense; InputError naming the file for everything wrong
/// in one; NoResultError as design_experiment().
Design design_files(const DesignRequest& request);

}  // namespace samara::identification
