#pragma once

#include <functional>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/source/call_memory.h"

namespace samara::codebooks {

/// The calls of a build by sampling, with those of its checkpoint if it is resumed. A disk that is full must
/// not end a build that needs no disk: it is told once.
/// @param options must outlive what is returned
/// @throws InputError for a checkpoint that is broken or of another plan
CallMemory calls_of(const Plan& plan, SampledSource source, const BuildOptions& options);

/// Measures a piece, of a rounded field that took so many calls, until it finds it wrong.
using CertifyClaim = std::function<Measured(const Piece& piece, double calls)>;

/// Solves a plan by sampling (pgd/sampling/sampling.h) the trajectories of a model, or a command.
///
/// With time, pilots, in corners and inside of the box, choose its axis: interpolation between its nodes
/// follows them to 0.1 of the tolerance. Then every call gives all outputs at all nodes of time; the cross is
/// built to half the tolerance (0.8 of it without time). The first core of the train, over outputs and times,
/// is split into one of the outputs and one of time, and the train rounded to 0.1 of the tolerance and
/// what the cross did not use of its share.
///
/// What sampling claims to be met is certified, on fresh points each time. Where the certificate finds it
/// wrong, these points go into the sample, and sampling goes on.
///
/// A point without an answer ends the build with the status "failed" and the point; the best so far is the
/// piece. All calls are stored in the end.
/// @param max_calls pilots included; answers remembered from an earlier build count as if they were made
/// @returns why there is no field, if none was found before the end
/// @throws NoResultError where calls cannot be made at all
Outcome<Solution> solve_by_sampling(const Plan& plan, CallMemory& calls, long max_calls,
                                    const ProgressCallback& progress, const CertifyClaim& certify_claim);

}  // namespace samara::codebooks
