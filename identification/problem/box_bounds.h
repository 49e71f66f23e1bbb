#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"

/// Internal to identification/.
namespace samara::identification {

/// Which unknowns of a block lie at a bound of their box; offsets have none, nor has what a quaternion
/// consists of.
/// @param coordinates of the first unknowns of the block
std::vector<char> at_bounds(const std::vector<models::FamilyCoordinate>& coordinates, const Chart& chart,
                            const Eigen::Ref<const Eigen::VectorXd>& values);

}  // namespace samara::identification
