#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/evolution/evolution_problem.h"

namespace samara::pgd {

/// coefficient * prod_k q_k^a_k * prod_m x_m^b_m, a term of the rate of one state.
struct Monomial {
  int state = 0;  ///< whose rate it belongs to
  double coefficient = 0.0;
  std::vector<int> parameter_powers = {};  ///< a, one per parameter; empty: all zero
  std::vector<int> state_powers = {};      ///< b, one per state; empty: all zero
};

/// x' = f(x, q) with a polynomial f that is known term by term: products of separated fields give it in
/// separated form without a single evaluation.
class PolynomialSystem final : public EvolutionSystem {
 public:
  /// @throws ArgumentError if a term names a state that does not exist, its coefficient is not finite, or its
  /// powers are negative or of the wrong number.
  PolynomialSystem(int states, int parameters, std::vector<Monomial> terms);

  int state_count() const override { return states_; }
  int parameter_count() const { return parameters_; }
  const std::vector<Monomial>& terms() const { return terms_; }
  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override;
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override;
  /// True if no term has a power of more than one in the parameters together.
  bool affine_in_parameters() const override;
  const PolynomialSystem* polynomial() const override { return this; }

 private:
  /// A coefficient times parameters and states, each as often as its power says: few multiplications, no powers.
  struct Product {
    int row;
    double coefficient;
    std::vector<int> parameters, states;
  };

  /// Adds the products at each column of x and q to the rows they belong to.
  static void sum(const std::vector<Product>& products, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                  Eigen::MatrixXd& sums);

  int states_;
  int parameters_;
  std::vector<Monomial> terms_;
  std::vector<Product> rates_;   ///< rows of f
  std::vector<Product> slopes_;  ///< rows of the Jacobian, column by column
};

}  // namespace samara::pgd
