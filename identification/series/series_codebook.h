#pragma once

#include <memory>
#include <string>

#include "samara/codebooks/book/codebook.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/models/interface/following_model.h"

namespace samara::identification {

/// The series as a codebook of one axis, t, whose outputs are the coefficients. Its certificate holds their
/// standard errors: it says how well captures determine them, not how well anything was integrated.
/// @throws ArgumentError if the fit of the series failed.
codebooks::Codebook series_codebook(const CoefficientSeries& series);

/// What a codebook of coefficients over time names as its model: it is no solution of that one.
std::string series_name(const std::string& model);

/// The course of a codebook over time alone whose outputs are parameters of the model: for following(). The
/// codebook must outlive it.
/// @throws ArgumentError if the codebook has other coordinates than time, is the series of another model, or
///   has outputs that are no parameters of the model, in another unit, or outside their meaning.
std::shared_ptr<const models::ParameterCourse> codebook_course(const codebooks::Codebook& book,
                                                               const models::ModelInfo& model);

}  // namespace samara::identification
