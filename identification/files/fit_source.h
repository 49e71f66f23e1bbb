#pragma once

#include <memory>
#include <optional>
#include <string>

#include "arguments.h"
#include "samara/base/errors.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/identification/fit/prediction_config.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/identification/trajectories/trajectory_source.h"
#include "samara/models/interface/model.h"

/// What `samara fit` fits: a codebook or a model, and how.
namespace samara::apps {

/// What is fitted: the trajectories of a codebook (kept alive here) or of a model.
struct FitSource {
  std::shared_ptr<const models::Model> model;           ///< null for a codebook
  std::optional<identification::SeriesOptions> series;  ///< only with a model
  std::optional<codebooks::Codebook> book;
  std::unique_ptr<identification::TrajectoryFamily> family;
  identification::FitOptions options;
  identification::PredictionConfig prediction;
  std::optional<identification::FitResult> coefficients;  ///< of another fit
};

/// Reads source, config and coefficients. Warns of a codebook that does not keep its tolerance, of units, and
/// of coefficients whose fit did not converge.
/// @throws ArgumentError, InputError
FitSource open_fit_source(const FitArguments& arguments);

/// What is wrong with values that came from a file is wrong with the file.
template <class Call>
auto of_file(const std::string& file, const Call& call) {
  try {
    return call();
  } catch (const ArgumentError& error) {
    if (file.empty()) throw;
    throw InputError(file, error.what());
  }
}

}  // namespace samara::apps
