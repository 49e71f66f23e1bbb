#pragma once

#include "samara/codebooks/book/codebook.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

/// The model a codebook is a solution of, with the codebook's coordinates free.
/// @throws ArgumentError if this library does not know the model, or the codebook holds what was sampled from
/// a command or a series of coefficients, which have no equations.
models::ParametricModel model_of(const Codebook& book);

}  // namespace samara::codebooks
