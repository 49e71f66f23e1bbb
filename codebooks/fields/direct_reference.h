#pragma once

#include "samara/codebooks/certify/certify_field.h"
#include "samara/pgd/linear/parametric_problem.h"

namespace samara::codebooks {

/// Solves a linear problem at one point of its parameters after the other, without separation: in space alone by
/// sparse factorisation; in space and time by CVODE on the nodes of space (the method of lines).
///
/// A certificate against it holds the error of the solution's nodes in time and parameters. It does not hold that of
/// the nodes in space, nor that of the data between nodes: the problem knows coefficients, sources and lift at the
/// nodes of parameters and time only, and ParametricProblem::at interpolates them. Data that their axes do not hold
/// exactly (polynomials up to the degree of the axis are) want a finer axis or a reference of the problem's own.
/// @param problem with one axis of space and at most one of time, whose first node is known; parameters enter its
/// terms as diagonals; of time there are derivatives (Axis::derivative(), scaled) and terms that do not change
/// (multiples of the identity)
/// @param scale of the solution: steps of CVODE may err by a hundredth of tolerance * scale
/// @param tolerance relative, of CVODE
/// @throws ArgumentError for a problem of another kind; the reference itself for times before the axis of time
FieldReference direct_reference(const pgd::ParametricProblem& problem, double scale, double tolerance = 1e-9);

}  // namespace samara::codebooks
