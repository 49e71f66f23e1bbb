#pragma once

#include <memory>

#include "samara/codebooks/book/codebook.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/trajectories/trajectory_family.h"

/// A codebook as a family of trajectories (models/trajectories/trajectory_family.h): as it is stored, by the
/// composition of its flow map, and its model by the reference integrator over the same box.
namespace samara::codebooks {

/// The trajectories that a codebook holds, with exact gradients of the separated form, up to the end of its
/// time. Points outside its box have the status outside_box. Symmetries, attitude and equations are those of
/// the model with the codebook's name, where Samara has it.
/// @param book must outlive the family and its sources
/// @throws ArgumentError if the codebook has no time.
std::unique_ptr<models::TrajectoryFamily> codebook_trajectories(const Codebook& book);

/// The same coordinates, at any time: windows of the codebook composed by its flow map (flow_map.h). Outputs
/// are the states of the model; states without an axis start where the codebook holds them. A trajectory that
/// leaves the box on the way has the status outside_box, and says when and by which state.
/// @param book, second must outlive the family and its sources  @param second chart of the flow map; null: none
/// @throws ArgumentError as FlowMap.
std::unique_ptr<models::TrajectoryFamily> flow_map_trajectories(const Codebook& book,
                                                                const Codebook* second = nullptr);

/// What the codebook is a solution of, over the same box: its model by CVODES.
/// @throws ArgumentError if Samara has no model of that name.
std::unique_ptr<models::TrajectoryFamily> reference_trajectories(
    const Codebook& book, const models::IntegrateOptions& options = {});

}  // namespace samara::codebooks
