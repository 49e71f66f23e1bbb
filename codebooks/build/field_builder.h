#pragma once

#include "samara/base/progress.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

/// Most attempts at a field, each for a smaller error than the one before.
inline constexpr int kFieldAttempts = 4;

/// What the first attempt aims at: the residual of the enrichment, and the error of its nodes.
double first_aim(const Plan& plan);

/// What to aim at after an aim that left this error: so much less as is missing, at most to a fifth.
double next_aim(double aim, double error, const Plan& plan);

/// Solves the plan of a field by enrichment of the linear engine.
/// @param attempt from 1
Solution solve_field(const Plan& plan, double aim, int attempt, const ProgressCallback& progress);

/// What the codebook is told of its field.
ModelDescription describe_field(const Plan& plan);

}  // namespace samara::codebooks
