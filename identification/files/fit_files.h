#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/identification/captures/capture.h"
#include "samara/identification/fit/fit_objective.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/series/coefficient_series.h"

/// A whole fit from files, as `samara fit` does it: a codebook or a model, captures with their sidecars, a
/// config; captures that were left out are predicted, suspicious ones reported. Callers that have some of it in memory
/// may give that.
///
///     const FitReport report = fit_files({.source = "coin.h5", .captures = {"coin.toml"}});
///     std::cout << fit_text(report.fit);
namespace samara::identification {

struct FitRequest {
  std::string source = {};  ///< the file of a codebook, or the name of a model
  /// To fit: tables, sidecars (".toml"), or one PEtab problem (".yaml").
  std::vector<std::filesystem::path> captures = {};
  std::vector<std::filesystem::path> left_out = {};  ///< to predict, likewise
  /// In memory, in place of `source`: one of the two.
  std::shared_ptr<const codebooks::Codebook> book = {};
  std::shared_ptr<const models::Model> model = {};
  std::vector<Capture> measured = {};       ///< in memory, to fit, after those of `captures`
  std::string config_text = {};             ///< TOML, where `config` is empty
  bool with_objective = false;              ///< FitReport::objective is wanted
  std::filesystem::path sidecar = {};       ///< of every table; empty: those beside them
  std::filesystem::path config = {};        ///< TOML; empty: a codebook's own box
  std::filesystem::path coefficients = {};  ///< JSON of another fit: where this one begins
  /// s, in place of the config's: of each capture that is fitted, of each that is left out, and beyond it.
  std::optional<double> span = {}, left_out_span = {}, ahead = {};
  bool reference = false;     ///< integrate the equations of a codebook instead of asking it
  bool profiles = false;      ///< of the shared coefficients
  bool needs_series = false;  ///< refuse a config without [series]
  ProgressCallback progress = {};
  /// Told each warning once, those about the captures before the fit begins.
  std::function<void(const std::string& sentence)> warning = {};
};

struct FitReport {
  FitResult fit;  ///< of a series, that of all its values
  std::optional<CoefficientSeries> series = {};
  /// Whether there is what was asked for; else the message says why not.
  bool is_usable = false;
  std::string message = {};
  /// What was minimised, with all that it needs, if it was asked for: null of a series, where nothing was fitted, and
  /// where no start succeeded.
  std::shared_ptr<const FitObjective> objective = {};
  /// Of a PEtab problem, its tables as the fit leaves them; else empty.
  std::string petab_parameters = {}, petab_simulations = {};
};

/// Sentences name the settings as the options of `samara fit`, but for times that are none, which it finds by itself.
/// @throws ArgumentError for a request that makes no sense and for captures that do not suit the source;
/// InputError naming the file for everything wrong in one.
FitReport fit_files(const FitRequest& request);

/// Every file that fit_files() would read, those that sidecars name among them.
/// @throws as fit_files()
std::vector<std::filesystem::path> files_read(const FitRequest& request);

}  // namespace samara::identification
