#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/axes/quadrature.h"
#include "samara/pgd/tensors/tensor_train.h"

/// Moments of one scalar function in separated form over independent coordinates; what statistics.h is made of.
///
/// For every coordinate there are two quadratic maps on the rank indices: E, of means, and V, of covariances
/// of the factors. With the pair (P, Q) of products so far, starting from (1, 0), a coordinate is
///
///   active:   P' = E(P),         Q' = E(Q) + V(Q) + V(P)   its variance enters, alone or with what is in Q
///   averaged: P' = E(P),         Q' = E(Q)                 conditional expectation over it
///   kept:     P' = E(P) + V(P),  Q' = E(Q) + V(Q)          its variance enters only where Q's does
///
/// and Q ends as the closed variance of the active coordinates when the others are averaged, as the total one
/// when they are kept. Every map is a sum of squares: nothing is subtracted.
namespace samara::pgd {

/// How one coordinate is distributed, for functions given by their nodal values v.
struct InputMeasure {
  /// Uniform over the axis.
  explicit InputMeasure(const Axis& axis);
  /// @param rule nodes inside the axis, weights that sum to one
  InputMeasure(const Axis& axis, const QuadratureRule& rule);

  Eigen::VectorXd mean;  ///< the mean is mean . v
  SparseMatrix root;     ///< the mean of squares is |root v|^2
};

/// Not divided by the variance.
struct VarianceParts {
  double closed = 0.0;
  double total = 0.0;
  double interaction = 0.0;
};

struct Moments {
  double mean = 0.0;
  double variance = 0.0;
  double round_off = 0.0;            ///< of the standard deviation
  std::vector<VarianceParts> parts;  ///< per subset
};

using InputSubset = std::vector<bool>;  ///< per input: is it in the subset

/// Of sum_r rows(j, r) prod_k factors[k](x_k, r) for all rows j.
std::vector<Moments> sum_moments(const std::vector<InputMeasure>& inputs,
                                 const std::vector<Eigen::MatrixXd>& factors, const Eigen::MatrixXd& rows,
                                 const std::vector<InputSubset>& subsets);

/// Of a train of nodal values, one core per input.
Moments train_moments(const std::vector<InputMeasure>& inputs, const std::vector<TrainCore>& cores,
                      const std::vector<InputSubset>& subsets);

}  // namespace samara::pgd
