#pragma once

#include <memory>

#include "samara/codebooks/book/codebook.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories of a codebook where it covers them, of another family everywhere else: so that a fit by
/// segments takes most of its steps at the price of a query, and may still start outside the codebook's box.
namespace samara::codebooks {

/// The result has the coordinates, outputs and box of `direct`. Its states may start anywhere in the
/// directions in which the motion of the model does not depend on the place, also if the codebook holds them.
///
/// Where both answer, they differ by the codebook's error. A fit whose steps cross the border of its box
/// may stall there, if that error is not small beside the noise. What the model derives from its states is
/// derived from the mixed ones; it asks for all of them.
/// @param book must outlive the result
/// @throws ArgumentError if the codebook is of another model, has a coordinate that `direct` has not, or
///   holds one, itself or by a default of its model, that is free in `direct` or has another value there; from
///   at(), for an output that the codebook lacks. Fits whose segments are joined ask for all states.
std::unique_ptr<models::TrajectoryFamily> mixed_trajectories(
    const Codebook& book, std::unique_ptr<models::TrajectoryFamily> direct);

}  // namespace samara::codebooks
