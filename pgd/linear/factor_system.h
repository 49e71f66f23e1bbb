#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/linear/mode_system.h"
#include "samara/pgd/linear/sparse_solver.h"

namespace samara::pgd {

/// Solves sum_p A^p X C_p^T = B for the whole factor matrix X (size x terms) of one mode; A^p: the parts
/// of its 1-D problems, C_p: terms x terms.
///
/// Diagonal parts decouple the nodes: O(n R^3). Up to two parts with symmetric coefficients, one of them
/// positive, decouple the terms by a generalised eigenproblem: R systems of one factor each, O(R^3) and R
/// sparse solves, linear in n for a 1-D mesh. Other sparse parts give one system of n R unknowns with the
/// band of the axis; dense ones one system for every block of a common lower triangular structure.
/// @returns false if the system is singular to working precision; X is then unchanged.
bool solve_factor_system(ModeSystem& system, const std::vector<Eigen::MatrixXd>& c, const Eigen::MatrixXd& b,
                         SparseSolverKind kind, Eigen::MatrixXd& x);

}  // namespace samara::pgd
