#pragma once

#include "samara/base/progress.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

/// Most attempts at a field, each for a fifth of the error of the one before.
inline constexpr int kFieldAttempts = 4;

/// Solves the plan of a field by enrichment of the linear engine.
/// @param attempt from 1
Solution solve_field(const Plan& plan, int attempt, const ProgressCallback& progress);

/// What the codebook is told of its field.
ModelDescription describe_field(const Plan& plan);

}  // namespace samara::codebooks
