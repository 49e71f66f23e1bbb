#include "samara/pgd/linear_problem.h"

#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/tensor_train.h"

namespace samara::pgd {

namespace {

void validate_mode(const LinearProblem& problem, std::size_t k) {
  const Eigen::Index rows = problem.rhs.factors[k].rows();
  const auto& first = problem.op.terms.front()[k];
  for (const auto& term : problem.op.terms) {
    if (term[k].rows() != first.rows() || term[k].cols() != first.cols()) {
      throw ArgumentError(
          fmt::format("the operator's parts on mode {} are {} x {} and {} x {}, expected one shape", k,
                      first.rows(), first.cols(), term[k].rows(), term[k].cols()));
    }
    if (!term[k].all_finite()) {
      throw ArgumentError(fmt::format("the operator has an entry on mode {} that is not finite", k));
    }
  }
  if (first.rows() != first.cols() || first.rows() != rows) {
    throw ArgumentError(
        fmt::format("the operator is {} x {} on mode {}, the right-hand side has {} rows there", first.rows(),
                    first.cols(), k, rows));
  }
  if (!problem.rhs.factors[k].allFinite()) {
    throw ArgumentError(fmt::format("the right-hand side has an entry on mode {} that is not finite", k));
  }
  if (k < problem.row_weights.size() && problem.row_weights[k].size() > 0) {
    const Eigen::VectorXd& w = problem.row_weights[k];
    if (w.size() != rows || !(w.minCoeff() > 0.0) || !w.allFinite()) {
      throw ArgumentError(fmt::format("mode {} has {} row weights from {}, expected {} positive ones", k,
                                      w.size(), w.size() > 0 ? w.minCoeff() : 0.0, rows));
    }
  }
}

Eigen::VectorXd weights_of(const LinearProblem& problem, std::size_t k) {
  return k < problem.row_weights.size() ? problem.row_weights[k] : Eigen::VectorXd();
}

std::vector<Eigen::VectorXd> root_weights(const LinearProblem& problem) {
  std::vector<Eigen::VectorXd> roots;
  for (const Eigen::VectorXd& w : problem.row_weights) roots.emplace_back(w.cwiseSqrt());
  return roots;
}

SeparatedTensor weighted_residual(const LinearProblem& problem, const SeparatedTensor& u) {
  SeparatedTensor residual = problem.rhs;
  residual.append(problem.op.apply(u), -1.0);
  return scaled_modes(std::move(residual), root_weights(problem));
}

template <class Norm>
double relative(const LinearProblem& problem, const SeparatedTensor& u, Norm norm_of) {
  const double size = norm_of(scaled_modes(problem.rhs, root_weights(problem)));
  if (size == 0.0) return u.rank() == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  return norm_of(weighted_residual(problem, u)) / size;
}

}  // namespace

void LinearProblem::validate() const {
  if (op.terms.empty() || rhs.factors.empty())
    throw ArgumentError("the linear problem has no operator or no right-hand side");
  for (const auto& term : op.terms) {
    if (static_cast<int>(term.size()) != rhs.modes()) {
      throw ArgumentError(fmt::format("the operator has a term of {} modes, the right-hand side has {}",
                                      term.size(), rhs.modes()));
    }
  }
  if (!rhs.weights.allFinite()) throw ArgumentError("the right-hand side has a weight that is not finite");
  for (std::size_t k = 0; k < rhs.factors.size(); ++k) validate_mode(*this, k);
}

ProjectedForm project(const LinearProblem& problem, Projection projection) {
  ProjectedForm form;
  const std::size_t modes = problem.rhs.factors.size();
  if (projection == Projection::galerkin) {
    for (const auto& term : problem.op.terms) {
      std::vector<ModeOperator> scaled;
      for (std::size_t k = 0; k < modes; ++k) scaled.push_back(term[k].row_scaled(weights_of(problem, k)));
      form.a.terms.push_back(std::move(scaled));
    }
    form.b = scaled_modes(problem.rhs, problem.row_weights);
    return form;
  }
  SeparatedOperator adjoint;  // D^T W
  for (const auto& left : problem.op.terms) {
    std::vector<ModeOperator> transposed;
    for (std::size_t k = 0; k < modes; ++k) {
      transposed.push_back(
          left[k].transposed_times(weights_of(problem, k), ModeOperator::identity(left[k].rows())));
    }
    for (const auto& right : problem.op.terms) {
      std::vector<ModeOperator> product;
      for (std::size_t k = 0; k < modes; ++k)
        product.push_back(left[k].transposed_times(weights_of(problem, k), right[k]));
      form.a.terms.push_back(std::move(product));
    }
    adjoint.terms.push_back(std::move(transposed));
  }
  form.b = adjoint.apply(problem.rhs);
  return form;
}

double fast_relative_residual(const LinearProblem& problem, const SeparatedTensor& u) {
  return relative(problem, u, [](const SeparatedTensor& t) { return fast_norm(t); });
}

double relative_residual(const LinearProblem& problem, const SeparatedTensor& u) {
  return relative(problem, u, [](const SeparatedTensor& t) { return norm(t); });
}

}  // namespace samara::pgd
