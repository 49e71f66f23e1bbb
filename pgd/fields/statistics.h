#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/quadrature.h"
#include "samara/pgd/fields/field.h"

/// Mean, variance and Sobol' indices of separated functions whose coordinates are independent: uniform over the box,
/// or distributed as a quadrature rule says.
///
/// With the analysis of variance f = sum over subsets A of f_A(x_A) and D_A = Var(f_A) (Sobol' 1993; Saltelli
/// et al. 2008), the variance is D = sum_A D_A and, for a subset A of the coordinates,
///
///   closed(A)      = sum of D_B / D over B inside A    = Var(E[f | x_A]) / D,
///   total(A)       = sum of D_B / D over B touching A  = 1 - closed(all others),
///   interaction(A) = D_A / D,
///
/// first order being closed({k}). All integrals are exact for the represented function: of products of two
/// factors by the mass matrix of the axis, or by the rule. Factors are split into mean and remainder before anything is
/// squared, and variances are sums of squares of remainders, so that a large mean costs no digits of a small
/// variance beyond those that the nodal values have lost already. Sums of products whose terms cancel are
/// brought to train form first, where they do not.
///
/// Usage:
///   Statistics s = statistics(field, {.free_axis = "t"});
///   s.mean(m, i), s.variance(m, i), s.total[k](m, i)   // output m, node i of t, input s.inputs[k]
namespace samara::pgd {

struct StatisticsOptions {
  /// This axis is no random input: statistics are given at each of its nodes. Empty: all axes are inputs.
  std::string free_axis = "";
  /// How inputs are distributed that are not uniform, by name: nodes inside the axis, in its unit, and weights from 0
  /// on that sum to one. Means are sums over the nodes.
  std::map<std::string, QuadratureRule> distributions = {};
  /// Further subsets of inputs to give indices of.
  std::vector<std::vector<std::string>> subsets = {};
};

/// Indices of one subset of inputs, outputs x nodes of the free axis (one column without).
struct SubsetIndices {
  std::vector<std::string> axes;
  Eigen::MatrixXd closed, total, interaction;
};

/// All matrices: outputs x nodes of the free axis (one column without).
struct Statistics {
  std::vector<std::string> inputs;  ///< names of the random axes, in the order of the field
  Eigen::VectorXd free_nodes;       ///< coordinates of the free axis' nodes; empty without
  Eigen::MatrixXd mean;             ///< unit of the output
  Eigen::MatrixXd variance;         ///< square of the unit of the output
  /// 1 where the function does not depend on the inputs: its standard deviation is below the round-off of its
  /// terms, 1e-14 times the sum of their root mean squares. Its variance and all its indices are then exactly
  /// zero (never NaN), also the totals, which otherwise sum to one or more.
  Eigen::MatrixXi constant;
  std::vector<Eigen::MatrixXd> first_order, total;  ///< per input
  std::vector<SubsetIndices> subsets;               ///< as asked for
};

/// Of every output of a field. Rank R, d axes of n nodes, M outputs, T nodes of the free axis (1 without), Q
/// indices: O(R^2 (d n + d Q + M T Q)), no loop over the grid; d R^2 numbers of storage.
/// @throws ArgumentError if an axis is unknown (the nearest is named), no input is left, a subset is
/// empty, names an axis twice, or holds the free axis, or a rule is none of a distribution on its axis.
Statistics statistics(const SeparatedField& field, const StatisticsOptions& options = {});

/// The same of a train. O(M T Q d n r^3) for ranks r.
Statistics statistics(const TrainField& field, const StatisticsOptions& options = {});

/// Of either.
Statistics statistics(const Field& field, const StatisticsOptions& options = {});

}  // namespace samara::pgd
