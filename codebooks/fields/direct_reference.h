#pragma once

#include "samara/codebooks/certify/certify_field.h"
#include "samara/pgd/linear/parametric_problem.h"

namespace samara::codebooks {

/// Solves a linear problem at one point of its parameters after the other, without separation: in space alone by
/// sparse factorisation; in space and time by CVODE on the nodes of space (the method of lines). The error of the
/// nodes in space is not in a certificate against it, that of nodes in time and of the parameters is.
/// @param problem with one axis of space and at most one of time, whose first node is known; parameters enter its
/// terms as diagonals; of time there are derivatives (Axis::derivative(), scaled) and terms that do not change
/// @param scale of the solution: steps of CVODE may err by a hundredth of tolerance * scale
/// @param tolerance relative, of CVODE
/// @throws ArgumentError for a problem of another kind
FieldReference direct_reference(const pgd::ParametricProblem& problem, double scale, double tolerance = 1e-9);

}  // namespace samara::codebooks
