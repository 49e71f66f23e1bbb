#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/linear/acceleration.h"
#include "samara/pgd/linear/mode_system.h"
#include "samara/pgd/linear/projection.h"

namespace samara::pgd {

/// One product found by the alternating-direction fixed point.
struct Product {
  std::vector<Eigen::VectorXd> factors;  ///< of Euclidean length 1
  double amplitude = 0.0;                ///< 0 if nothing was found in the directions tried
  /// amplitude <product, b - A u>: what the product takes off the functional that the projection minimises
  /// (twice the energy for symmetric positive Galerkin, the squared residual for the minimal residual).
  double gain = 0.0;
  int iterations = 0;
  bool converged = false;
  bool singular = false;  ///< a 1-D problem could not be solved
};

/// Finds the product R with <V, A R> = <V, b - A u> for variations V of one factor at a time, (6.12)-(6.13).
/// Holds the workspace; run() does not allocate once all modes are diagonal or dense. One iteration costs
/// O(links) and O(n (terms of b + parts terms of u)) per mode and the 1-D solves.
class FixedPoint {
 public:
  struct Options {
    int max_iterations = 20;
    double tolerance = 1e-2;
    Acceleration acceleration = Acceleration::none;
  };

  /// Form and systems must outlive it.
  FixedPoint(const ProjectedForm& form, std::vector<ModeSystem>& systems);

  /// Subtracts A u from the right-hand side of the runs to come. Allocates.
  void deflate(const SeparatedTensor& u);

  /// @param product first guess in `factors`, replaced by the result
  void run(const Options& options, Product& product);

 private:
  /// Solves for the factor of one mode; @returns false if singular or zero.
  bool solve_mode(int mode, Product& product, double& overlap);
  void refresh(int mode, const Eigen::VectorXd& factor);
  void start();
  void extrapolate(Product& product, bool first);

  const ProjectedForm& form_;
  OperatorChain plain_;
  std::vector<ModeSystem>& systems_;
  ChainProducts a_, b_, u_;
  Eigen::MatrixXd weights_of_b_, weights_of_u_;             ///< as rows
  std::vector<std::vector<Eigen::MatrixXd>> applied_to_u_;  ///< [mode][part]: size x terms of u
  std::vector<Eigen::VectorXd> coefficients_;               ///< [mode]: per part
  std::vector<Eigen::VectorXd> rhs_, solution_, applied_;
  std::vector<Eigen::VectorXd> before_, step_;  ///< of the acceleration
  double relaxation_ = 1.0;
};

}  // namespace samara::pgd
