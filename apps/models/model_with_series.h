#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "samara/codebooks/book/codebook.h"
#include "samara/models/interface/model.h"

namespace samara::apps {

/// A model whose parameters follow the codebook of a series.
struct ModelWithSeries {
  std::unique_ptr<const codebooks::Codebook> book;  ///< the model looks into it
  std::shared_ptr<const models::Model> model;
  /// Of parameters and initial values: what was set, and what the series holds besides.
  std::map<std::string, double> values;

  /// @throws OutsideBoxError if the series does not reach from 0 to `end`.
  void check_time(double end) const;
};

/// @param set values that were set, SI
/// @throws InputError for a file that is no series of the model; ArgumentError if one of its coefficients was
///   set.
ModelWithSeries model_with_series(const std::string& file, const std::shared_ptr<const models::Model>& model,
                                  const std::map<std::string, double>& set);

}  // namespace samara::apps
