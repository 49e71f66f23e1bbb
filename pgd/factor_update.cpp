#include "samara/pgd/factor_update.h"

#include <vector>

#include <Eigen/LU>

#include "samara/pgd/mode_system.h"

namespace samara::pgd {

namespace {

/// Inner products of u's factors with the operator's and the right-hand side's parts, mode by mode.
class Products {
 public:
  Products(const ProjectedForm& form, const SeparatedTensor& u) : form_(form) {
    a_.resize(u.factors.size());
    b_.resize(u.factors.size());
    for (std::size_t k = 0; k < u.factors.size(); ++k) refresh(k, u.factors[k]);
  }

  void refresh(std::size_t mode, const Eigen::MatrixXd& factor) {
    a_[mode].clear();
    for (const auto& term : form_.a.terms)
      a_[mode].emplace_back(factor.transpose() * term[mode].apply(factor));
    b_[mode] = factor.transpose() * form_.b.factors[mode];
  }

  /// Products over all modes but `without` (none left out if negative) of the operator's term i: terms x
  /// terms.
  Eigen::MatrixXd operator_products(std::size_t i, int without) const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Ones(a_[0][i].rows(), a_[0][i].cols());
    for (std::size_t k = 0; k < a_.size(); ++k) {
      if (static_cast<int>(k) != without) result.array() *= a_[k][i].array();
    }
    return result;
  }

  /// The same for the right-hand side, weights included: terms of u x terms of b.
  Eigen::MatrixXd rhs_products(int without) const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Ones(b_[0].rows(), 1) * form_.b.weights.transpose();
    for (std::size_t k = 0; k < b_.size(); ++k) {
      if (static_cast<int>(k) != without) result.array() *= b_[k].array();
    }
    return result;
  }

 private:
  const ProjectedForm& form_;
  std::vector<std::vector<Eigen::MatrixXd>> a_;  ///< [mode][i]: U_k^T A_k^i U_k
  std::vector<Eigen::MatrixXd> b_;               ///< [mode]: U_k^T b_k
};

}  // namespace

bool project_weights(const ProjectedForm& form, SeparatedTensor& u) {
  const Products products(form, u);
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(u.rank(), u.rank());
  for (std::size_t i = 0; i < form.a.terms.size(); ++i) system += products.operator_products(i, -1);
  const Eigen::VectorXd rhs = products.rhs_products(-1).rowwise().sum();
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(system);
  if (!lu.isInvertible()) return false;
  u.weights = lu.solve(rhs);
  return u.weights.allFinite();
}

bool update_factors(const ProjectedForm& form, SeparatedTensor& u, int sweeps) {
  Products products(form, u);
  std::vector<Eigen::MatrixXd> c(form.a.terms.size());
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    for (int mode = 0; mode < u.modes(); ++mode) {
      const auto k = static_cast<std::size_t>(mode);
      for (std::size_t i = 0; i < c.size(); ++i) c[i] = products.operator_products(i, mode);
      const Eigen::MatrixXd rhs = form.b.factors[k] * products.rhs_products(mode).transpose();
      if (!solve_factor_system(form.a, mode, c, rhs, u.factors[k])) return false;
      // Lengths go to the weights at once: factors of length one keep the systems well scaled.
      u.weights = u.factors[k].colwise().norm().transpose();
      if (u.weights.minCoeff() == 0.0) {
        u.normalise();
        return false;
      }
      u.factors[k].array().rowwise() /= u.weights.transpose().array();
      products.refresh(k, u.factors[k]);
    }
  }
  return true;
}

}  // namespace samara::pgd
