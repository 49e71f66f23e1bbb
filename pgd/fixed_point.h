#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/linear_problem.h"
#include "samara/pgd/mode_system.h"

namespace samara::pgd {

/// One product found by the alternating-direction fixed point.
struct Product {
  std::vector<Eigen::VectorXd> factors;  ///< of Euclidean length 1
  double amplitude = 0.0;                ///< 0 if nothing was found in the directions tried
  int iterations = 0;
  bool converged = false;
  bool singular = false;  ///< a 1-D problem could not be solved
};

/// Finds the product R with <V, A R> = <V, b> for variations V of one factor at a time, (6.12)-(6.13).
/// Holds the workspace; run() does not allocate beyond the returned factors once all modes are diagonal or
/// dense.
class FixedPoint {
 public:
  struct Options {
    int max_iterations = 20;
    double tolerance = 1e-2;
  };

  explicit FixedPoint(const SeparatedOperator& a);

  /// @param b right-hand side, already deflated by the terms found before
  /// @param product first guess in `factors`, replaced by the result
  void run(const SeparatedTensor& b, const Options& options, Product& product);

 private:
  /// Solves for the factor of one mode; @returns false if singular or zero.
  bool solve_mode(const SeparatedTensor& b, int mode, Product& product, double& overlap);
  void refresh(const SeparatedTensor& b, int mode, const Eigen::VectorXd& factor);

  const SeparatedOperator& a_;
  std::vector<ModeSystem> systems_;
  Eigen::MatrixXd a_products_;  ///< (i, k): R_k^T A_k^i R_k
  Eigen::MatrixXd b_products_;  ///< (m, k): R_k^T b_k^m
  Eigen::VectorXd a_coefficients_;
  Eigen::VectorXd b_coefficients_;
  std::vector<Eigen::VectorXd> rhs_, solution_, applied_;
};

}  // namespace samara::pgd
