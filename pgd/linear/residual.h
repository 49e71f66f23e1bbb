#pragma once

#include "samara/pgd/linear/linear_problem.h"
#include "samara/pgd/linear/operator_chain.h"
#include "samara/pgd/linear/row_measure.h"

namespace samara::pgd {

/// Relative residuals ||D U - G|| / ||G|| of one problem, as its row weights or norms measure it, for many U.
/// The problem must outlive it. Without a right-hand side the residual is 0 for U without terms, else
/// infinite.
class Residual {
 public:
  explicit Residual(const LinearProblem& problem);

  /// By inner products: O(links^2 R^2 + n R^2 parts^2) per mode for R terms of U. Resolves down to about 1e-8
  /// of the sizes of the terms of D U and G, the most that it then returns.
  double fast(const SeparatedTensor& u) const;
  /// By orthogonalisation: O(n (S R + R_G)^3) per mode, S the states of the operator's chain. Resolves down
  /// to the rounding of D U itself, 1e-16 of the sizes of what D adds up, and returns that if it is larger.
  double exact(const SeparatedTensor& u) const;
  /// The fast one where it is clear of its noise (a relative error below half a per cent), else the exact
  /// one.
  double resolved(const SeparatedTensor& u) const;
  /// Whether G vanishes to working precision.
  bool is_zero() const { return rhs_norm_ == 0.0; }

 private:
  struct Squared {
    double value = 0.0;  ///< ||D U - G||^2
    double noise = 0.0;  ///< its rounding
  };
  Squared squared(const SeparatedTensor& u) const;
  /// Rounding of D U - G, relative to G.
  double rounding(const SeparatedTensor& u) const;

  /// Parts of mode k times U's factor, as measured.
  std::vector<Eigen::MatrixXd> applied(int mode, const SeparatedTensor& u) const;

  OperatorChain chain_;
  std::vector<RowMeasure> measures_;
  SeparatedTensor rhs_;       ///< as measured
  double rhs_norm_ = 0.0;     ///< 0 also where the terms of G cancel to rounding
  double rhs_squares_ = 0.0;  ///< sum of the squared norms of its terms
};

/// The same for a single U.
double fast_relative_residual(const LinearProblem& problem, const SeparatedTensor& u);
double relative_residual(const LinearProblem& problem, const SeparatedTensor& u);

}  // namespace samara::pgd
