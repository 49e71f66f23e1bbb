#pragma once

#include <random>

#include "samara/models/checks/check_parts.h"

namespace samara::models {

/// ModelInfo::affine_in holds names of parameters, and f is affine in them together.
void check_affinity(const Model& model, const Point& point, std::mt19937& random, Findings& findings);

/// Force terms are finite, and their powers sum to the rate of the kinetic energy where there is one.
void check_forces(const Model& model, const Point& point, double tolerance, Findings& findings);

/// A force term whose description ends with "no power" does none, and one that ends with "takes power" gives none.
void check_passivity(const Model& model, const Point& point, Findings& findings);

/// Groups lie within the states and do not overlap; false if they do not.
bool check_groups(const ModelInfo& info, Findings& findings);
/// Quaternions keep their norm; where "rotation about z" is a symmetry, f turns with the groups.
void check_rotation(const Model& model, const Point& point, std::mt19937& random, Findings& findings);
/// Number of states in a group.
int group_size(StateGroupKind kind);

}  // namespace samara::models
