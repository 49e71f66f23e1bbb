#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/compression.h"
#include "samara/pgd/tensors/separation.h"
#include "samara/pgd/tensors/tensor_algebra.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Accuracy of the Jacobian, per slab, as a sum of products: it bounds the contraction, not the error.
constexpr double kSumOfJacobian = 0.05;
/// Of the last correction, what a linear problem may leave.
constexpr double kOfCorrection = 0.1;
constexpr int kMostTerms = 300;
constexpr int kMostJacobianTerms = 200;

/// (S x I) times the block diagonal matrix of a Jacobian's products: row (m + n k) + n^2 i of `jacobian` is
/// entry (m, k) at Radau point i.
Eigen::MatrixXd integrated(const Eigen::MatrixXd& integration, const Eigen::VectorXd& jacobian, int n) {
  const Eigen::Index s = integration.rows();
  Eigen::MatrixXd matrix(n * s, n * s);
  for (Eigen::Index j = 0; j < s; ++j) {
    const Eigen::MatrixXd block =
        jacobian.segment(Eigen::Index{n} * n * j, Eigen::Index{n} * n).reshaped(n, n);
    for (Eigen::Index i = 0; i < s; ++i) matrix.block(i * n, j * n, n, n) = integration(i, j) * block;
  }
  return matrix;
}

/// Newton's iteration in W = X - x0: W' = A W + f(X) - A (X - x0), A = J(X).
class Enrichment final : public Strategy {
 public:
  std::string name() const override { return "Newton's iteration by enrichment"; }

  std::optional<Ending> begin(const StrategySlab& slab) override {
    jacobian_pivots_ = source_pivots_ = {};
    std::vector<int> sizes = {slab.rows()};
    sizes.insert(sizes.end(), slab.sizes().begin(), slab.sizes().end());
    increment_ = SeparatedTensor::zero(sizes);
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    const Outcome<TensorTrain> found = separated_jacobian(slab, iterate, kSumOfJacobian, jacobian_pivots_);
    if (!found) return found.ending();
    const Separation products =
        separate(*found, 0.1 * kSumOfJacobian * std::sqrt(full_size(*found)), kMostJacobianTerms);
    if (products.status != Termination::converged)
      return out_of_terms(slab, "the Jacobian takes more products than are allowed");
    jacobian_ = products.tensor;
    // The source is of the very A that the linear problem has: what A lacks then costs iterations, no accuracy.
    const TensorTrain jacobian = to_train(jacobian_);
    const TensorTrain at_points = slab.at_points(iterate);
    const TensorTrain start = slab.start_at_points();
    const EntryFunction source = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd x = values_at(at_points, entries);
      values = source_at(slab, slab.rates(x, slab.parameters_at(entries)), x - values_at(start, entries),
                         values_at(jacobian, entries));
    };
    const double tolerance = kSourceShare * slab.tolerance();
    Outcome<TensorTrain> b = slab.separate(source, slab.rows(), tolerance, source_pivots_, "f");
    if (!b) return b.ending();
    return LinearSlab{jacobian, slab.compressed(std::move(*b), tolerance)};
  }

  Outcome<TensorTrain> solution(const StrategySlab& slab, const LinearSlab& linear,
                                std::optional<double> correction, CrossPivots&) override {
    const double entries = std::sqrt(full_size(linear.source));
    const double finest = kSourceShare * slab.tolerance();
    const TensorTrain integrals =
        applied(linear.source, 0, for_all_states(slab.integration(), slab.states()));
    const Separation rhs = separate(integrals, 0.1 * finest * entries, kMostTerms);
    if (rhs.status != Termination::converged)
      return out_of_terms(slab, "the source takes more products than are allowed");
    const LinearProblem problem{operator_of(slab, jacobian_), rhs.tensor, {}, {}};
    const double size = norm(problem.rhs) / entries;
    if (size == 0.0) return slab.constant();
    // A solution that moves by less than it may be wrong says nothing of how far the iteration is.
    double accuracy = std::max(finest, kOfCorrection * std::min(correction.value_or(size), size));
    for (;; accuracy = std::max(finest, kOfCorrection * accuracy)) {
      const SeparatedTensor last = increment_;
      if (std::optional<Ending> failure = improve(slab, problem, accuracy, size, entries)) return *failure;
      if (accuracy == finest || norm(sum(increment_, last, -1.0)) / entries > accuracy) break;
    }
    Eigen::MatrixXd after_start = Eigen::MatrixXd::Zero(slab.states() + slab.rows(), slab.rows());
    after_start.bottomRows(slab.rows()).setIdentity();
    return slab.compressed(sum(slab.constant(), applied(to_train(increment_), 0, after_start)),
                           0.1 * slab.tolerance());
  }

 private:
  /// Solves for the increment until the residual's root mean square over so many entries is below `accuracy`.
  /// @param size that of the right-hand side @param entries square root of their number
  std::optional<Ending> improve(const StrategySlab& slab, const LinearProblem& problem, double accuracy,
                                double size, double entries) {
    EnrichOptions options;
    options.projection = Projection::galerkin;
    options.residual_tolerance = std::min(0.9, accuracy / size);
    options.residual = ResidualKind::fast;
    options.max_rank = kMostTerms;
    options.seed = slab.random().bits();
    const EnrichResult solved = enrich(problem, options, increment_.rank() > 0 ? &increment_ : nullptr);
    if (solved.termination != Termination::converged && solved.residual * size > 10.0 * accuracy)
      return out_of_terms(slab, solved.message);
    increment_ = compress(solved.solution, 0.1 * accuracy * entries).tensor;
    return std::nullopt;
  }

  static Ending out_of_terms(const StrategySlab& slab, const std::string& why) {
    return {Termination::rank_limit, fmt::format("between t = {:.6g} and {:.6g}: {}", slab.begin(),
                                                 slab.begin() + slab.length(), why)};
  }

  /// I - S A.
  static SeparatedOperator operator_of(const StrategySlab& slab, const SeparatedTensor& jacobian) {
    SeparatedOperator op;
    std::vector<ModeOperator> identity = {ModeOperator::identity(slab.rows())};
    for (const int size : slab.sizes()) identity.push_back(ModeOperator::identity(size));
    op.terms.push_back(std::move(identity));
    for (Eigen::Index r = 0; r < jacobian.rank(); ++r) {
      std::vector<ModeOperator> term = {ModeOperator::dense(
          integrated(slab.integration(), -jacobian.weights[r] * jacobian.factors[0].col(r), slab.states()))};
      for (std::size_t k = 1; k < jacobian.factors.size(); ++k)
        term.push_back(ModeOperator::diagonal(jacobian.factors[k].col(r)));
      op.terms.push_back(std::move(term));
    }
    return op;
  }

  SeparatedTensor jacobian_;   ///< A of the present linear problem
  SeparatedTensor increment_;  ///< W, the terms that the next linear problem starts from
  CrossPivots jacobian_pivots_, source_pivots_;
};

}  // namespace

std::unique_ptr<Strategy> enrichment_strategy() {
  return std::make_unique<Enrichment>();
}

}  // namespace samara::pgd
