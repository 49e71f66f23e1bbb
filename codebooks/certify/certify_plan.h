#pragma once

#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

/// Measures a codebook that was sampled from a command against the command of a plan, called by the plan's
/// batches and timeout. What the codebook says of its command is never executed. The first point without an
/// answer ends the calls; later points count as failed, too. Of `options`, threads and integrator are
/// not used.
/// @throws NoResultError if the program printed more than it was asked for; ArgumentError if points < 1 or
/// more than the plan allows, the codebook is one of a model or the plan is, or their inputs, box, fixed
/// values, outputs or times differ.
Certificate certify(const Codebook& book, const Plan& plan, const CertifyOptions& options);

}  // namespace samara::codebooks
