#include "samara/pgd/linear/factor_update.h"

#include <Eigen/LU>

#include "samara/pgd/linear/factor_system.h"

namespace samara::pgd {

namespace {

/// Inner products of u's factors with the operator's and the right-hand side's parts.
class Products {
 public:
  Products(const ProjectedForm& form, const SeparatedTensor& u)
      : form_(form),
        plain_(OperatorChain::identity(u.sizes())),
        first_(Eigen::VectorXd::Ones(u.rank()) * form.b.weights.transpose()),
        a_(form.a, u.rank(), u.rank()),
        b_(plain_, u.rank(), form.b.rank()) {
    for (int k = 0; k < u.modes(); ++k) refresh(k, u.factors[static_cast<std::size_t>(k)]);
  }

  void refresh(int mode, const Eigen::MatrixXd& factor) {
    a_.refresh(mode, factor, factor);
    b_.gram(mode, 0).noalias() = factor.transpose() * form_.b.factors[static_cast<std::size_t>(mode)];
  }
  void start() {
    a_.start();
    b_.start(first_);
  }
  void advance(int mode) {
    a_.advance(mode);
    b_.advance(mode);
  }
  const std::vector<Eigen::MatrixXd>& operator_coefficients(int mode) { return a_.coefficients(mode); }
  /// size x terms of u
  Eigen::MatrixXd rhs(int mode) {
    return form_.b.factors[static_cast<std::size_t>(mode)] * b_.coefficients(mode).front().transpose();
  }
  const Eigen::MatrixXd& operator_total() const { return a_.total(); }
  Eigen::VectorXd rhs_total() const { return b_.total().rowwise().sum(); }

 private:
  const ProjectedForm& form_;
  OperatorChain plain_;
  Eigen::MatrixXd first_;
  ChainProducts a_, b_;
};

}  // namespace

bool project_weights(const ProjectedForm& form, SeparatedTensor& u) {
  Products products(form, u);
  products.start();
  for (int k = 0; k < u.modes(); ++k) products.advance(k);
  const Eigen::FullPivLU<Eigen::MatrixXd> lu(products.operator_total());
  if (!lu.isInvertible()) return false;
  const Eigen::VectorXd weights = lu.solve(products.rhs_total());
  if (!weights.allFinite()) return false;
  u.weights = weights;
  return true;
}

bool update_factors(const ProjectedForm& form, std::vector<ModeSystem>& systems, SeparatedTensor& u,
                    const FactorUpdateOptions& options) {
  Products products(form, u);
  for (int sweep = 0; sweep < options.sweeps; ++sweep) {
    const Eigen::VectorXd before = u.weights;
    products.start();
    for (int k = 0; k < u.modes(); ++k) {
      Eigen::MatrixXd& factor = u.factors[static_cast<std::size_t>(k)];
      if (!solve_factor_system(systems[static_cast<std::size_t>(k)], products.operator_coefficients(k),
                               products.rhs(k), options.solver, factor)) {
        return false;
      }
      // Lengths go to the weights at once: factors of length one keep the systems well scaled.
      u.weights = factor.colwise().norm().transpose();
      if (u.weights.minCoeff() == 0.0) {
        u.normalise();
        return false;
      }
      factor.array().rowwise() /= u.weights.transpose().array();
      products.refresh(k, factor);
      products.advance(k);
    }
    const double change = (u.weights.cwiseAbs() - before.cwiseAbs()).cwiseAbs().maxCoeff();
    if (change <= options.tolerance * u.weights.cwiseAbs().maxCoeff()) break;
  }
  return true;
}

}  // namespace samara::pgd
