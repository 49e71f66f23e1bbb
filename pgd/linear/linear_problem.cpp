#include "samara/pgd/linear/linear_problem.h"

#include <algorithm>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"

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

void validate_norm(const LinearProblem& problem, std::size_t k) {
  if (k >= problem.row_norms.size() || problem.row_norms[k].size() == 0) return;
  const SparseMatrix& norm = problem.row_norms[k];
  const Eigen::Index rows = problem.rhs.factors[k].rows();
  if (norm.rows() != rows || norm.cols() != rows) {
    throw ArgumentError(fmt::format("the norm of mode {} is {} x {}, expected {} x {}", k, norm.rows(),
                                    norm.cols(), rows, rows));
  }
  // The factorisation below reads one half only.
  const SparseMatrix difference = norm - SparseMatrix(norm.transpose());
  const ModeOperator whole = ModeOperator::sparse(norm);
  const bool symmetric =
      whole.all_finite() && ModeOperator::sparse(difference).largest() <= 1e-12 * whole.largest();
  const Eigen::SimplicialLDLT<SparseMatrix> factor(norm);
  if (!symmetric || factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 0.0))
    throw ArgumentError(fmt::format("the norm of mode {} is not symmetric and positive", k));
}

void validate_shape(const LinearProblem& problem) {
  const std::size_t modes = problem.rhs.factors.size();
  for (const auto& term : problem.op.terms) {
    if (term.size() != modes) {
      throw ArgumentError(
          fmt::format("the operator has a term of {} modes, the right-hand side has {}", term.size(), modes));
    }
  }
  problem.rhs.validate("right-hand side");
  if (problem.row_weights.size() > modes || problem.row_norms.size() > modes) {
    throw ArgumentError(fmt::format("there are {} row weights and {} row norms for {} modes",
                                    problem.row_weights.size(), problem.row_norms.size(), modes));
  }
}

/// Squares of numbers beyond these limits leave the range of doubles.
void validate_scale(const char* what, std::size_t k, double largest) {
  constexpr double kLargest = 1e100;
  if (largest == 0.0 || (largest >= 1.0 / kLargest && largest <= kLargest)) return;
  throw ArgumentError(fmt::format(
      "the {} is of size {:.3g} on mode {}, expected 1e-100 to 1e100: choose other units", what, largest, k));
}

}  // namespace

void LinearProblem::validate() const {
  if (op.terms.empty() || rhs.factors.empty())
    throw ArgumentError("the linear problem has no operator or no right-hand side");
  validate_shape(*this);
  for (std::size_t k = 0; k < rhs.factors.size(); ++k) {
    validate_mode(*this, k);
    validate_norm(*this, k);
    double largest = 0.0;
    for (const auto& term : op.terms) largest = std::max(largest, term[k].largest());
    validate_scale("operator", k, largest);
    if (rhs.rank() > 0) validate_scale("right-hand side", k, rhs.factors[k].cwiseAbs().maxCoeff());
  }
}

}  // namespace samara::pgd
