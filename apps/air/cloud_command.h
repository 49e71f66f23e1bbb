#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "options/arguments.h"
#include "samara/models/interface/parametric_model.h"

/// `samara simulate MODEL --realisations N ..`: many flights of one release in a random flow.
namespace samara::apps {

/// @throws ArgumentError for words of realisations without --realisations, or words of single trajectories with it.
void check_cloud_words(const SimulateArguments& arguments);

/// Of --seed. @throws ArgumentError unless it is a whole number from 0 on.
std::uint64_t seed_of(const CloudWords& words);

/// @returns the exit code
int fly_cloud(const SimulateArguments& arguments, const models::ParametricModel& model,
              const Eigen::VectorXd& times);

}  // namespace samara::apps
