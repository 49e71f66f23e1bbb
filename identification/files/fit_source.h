#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/base/errors.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/fit/prediction_config.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/warnings.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/models/interface/model.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/: what a request fits, a codebook or a model, and how.
namespace samara::identification {

/// What is fitted: the trajectories of a codebook (kept alive here) or of a model.
struct FitSource {
  std::shared_ptr<const models::Model> model;       ///< null for a codebook
  std::optional<SeriesOptions> series;              ///< only with a model
  std::shared_ptr<const codebooks::Codebook> book;  ///< null for a model
  /// Of a model: gives the trajectories that it covers; or null.
  std::shared_ptr<const codebooks::Codebook> cover;
  std::unique_ptr<models::TrajectoryFamily> family;
  FitOptions options;
  PredictionConfig prediction;
  std::optional<FitResult> coefficients;  ///< of another fit
  /// Of a codebook that does not keep its tolerance, of units, of coefficients whose fit did not converge.
  Warnings warnings;
};

/// Whether there are captures to fit, in files or in memory.
inline bool has_captures(const FitRequest& request) {
  return !request.captures.empty() || !request.measured.empty();
}

/// Every capture of these files. @param sidecar of every table; empty: those beside them
/// @throws as read_captures()
std::vector<Capture> read_all(const std::vector<std::filesystem::path>& files,
                              const std::filesystem::path& sidecar);

/// A file of equations, or a name that is no file, and has no dot or slash that would make it one.
bool is_model_source(const std::string& text);

/// Whether nothing is fitted: coefficients come from another fit, and there are only captures to predict.
bool predicts_only(const FitRequest& request);

/// Reads source, config and coefficients.
/// @throws ArgumentError, InputError
FitSource open_fit_source(const FitRequest& request);

/// Warns of values that were held where coefficients were found, and are held at others here.
/// @param file of the coefficients
void doubt_held_values(const FitResult& fitted, const models::FamilyInfo& info, const std::string& file,
                       Warnings& warnings);

/// What is wrong with values that came from a file is wrong with the file.
template <class Call>
auto of_file(const std::filesystem::path& file, const Call& call) {
  try {
    return call();
  } catch (const ArgumentError& error) {
    if (file.empty()) throw;
    throw InputError(file.string(), error.what());
  }
}

}  // namespace samara::identification
