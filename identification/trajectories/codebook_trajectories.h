#pragma once

#include <memory>

#include "samara/codebooks/book/codebook.h"
#include "samara/identification/trajectories/trajectory_source.h"

namespace samara::identification {

/// The trajectories that a codebook holds; exact gradients of the separated form. The codebook must outlive
/// the family and its sources. Symmetries, attitude and equations, from which segments take their start
/// states, are those of the model with the codebook's name, where Samara has it.
std::unique_ptr<TrajectoryFamily> codebook_trajectories(const codebooks::Codebook& book);

}  // namespace samara::identification
