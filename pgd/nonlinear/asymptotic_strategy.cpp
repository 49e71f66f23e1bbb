#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Of the series.
constexpr int kMaxOrder = 12;

/// The weights w with which sum_k w_k g(lambda_k) is the Taylor coefficient of g of order `order`, for
/// polynomials g of as many coefficients as there are nodes. By Chebyshev's polynomials, whose coefficients
/// are well conditioned, and their own Taylor coefficients, integers.
Eigen::RowVectorXd taylor_weights(const Eigen::VectorXd& nodes, int order) {
  const Eigen::Index count = nodes.size();
  Eigen::RowVectorXd weights = Eigen::RowVectorXd::Zero(count);
  Eigen::MatrixXd powers = Eigen::MatrixXd::Zero(count, count);  // column d: T_d by powers
  powers(0, 0) = 1.0;
  if (count > 1) powers(1, 1) = 1.0;
  for (Eigen::Index d = 2; d < count; ++d) {
    powers.col(d).tail(count - 1) = 2.0 * powers.col(d - 1).head(count - 1);
    powers.col(d) -= powers.col(d - 2);
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    const double angle = std::acos(nodes[k]);
    for (Eigen::Index d = 0; d < count; ++d) {
      const double factor = (d == 0 ? 1.0 : 2.0) / static_cast<double>(count);
      weights[k] += factor * std::cos(static_cast<double>(d) * angle) * powers(order, d);
    }
  }
  return weights;
}

/// Roots of the Chebyshev polynomial of degree `count`.
Eigen::VectorXd chebyshev_roots(int count) {
  Eigen::VectorXd roots(count);
  for (int k = 0; k < count; ++k) roots[k] = std::cos(std::numbers::pi * (k + 0.5) / count);
  return roots;
}

class Asymptotic final : public Strategy {
 public:
  std::string name() const override { return "the asymptotic numerical method"; }
  int max_iterations() const override { return kMaxOrder + 1; }
  int patience() const override { return 2; }
  std::string on_divergence(double ratio) const override {
    return fmt::format(
        "the series in the path parameter has a radius of convergence of about {:.3g}, below "
        "one: its terms grow,",
        1.0 / ratio);
  }

  std::optional<Ending> begin(const StrategySlab& slab) override {
    jacobian_pivots_ = linear_pivots_ = source_pivots_ = {};
    terms_.clear();
    source_.reset();
    Outcome<TensorTrain> separated = separated_jacobian_at(slab, slab.start_at_points(),
                                                           kSourceShare * slab.tolerance(), jacobian_pivots_);
    if (!separated) return separated.ending();
    jacobian_ = std::move(*separated);
    return std::nullopt;
  }

  /// With the sum X_0 + .. + X_m as the iterate, the problem for the sum of one more.
  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    const double tolerance = kSourceShare * slab.tolerance();
    if (!source_) {
      Outcome<TensorTrain> linear = linear_part(slab);
      if (!linear) return linear.ending();
      source_ = slab.compressed(std::move(*linear), tolerance);
      return LinearSlab{jacobian_, *source_};
    }
    const TensorTrain term = terms_.empty() ? iterate : sum(iterate, iterate_, -1.0);
    terms_.push_back(slab.compressed(slab.at_points(term), 0.1 * tolerance));
    iterate_ = iterate;
    const Outcome<TensorTrain> next = coefficient(slab);
    if (!next) return next.ending();
    source_ = slab.compressed(sum(*source_, *next), tolerance);
    return LinearSlab{jacobian_, *source_};
  }

 private:
  /// f - A x at the start: the equations for lambda = 0.
  Outcome<TensorTrain> linear_part(const StrategySlab& slab) {
    const TensorTrain centre = slab.start_at_points();
    const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd x = values_at(centre, entries);
      values = source_at(slab, slab.rates(x, slab.parameters_at(entries)), x, values_at(jacobian_, entries));
    };
    return slab.separate(function, slab.rows(), kSourceShare * slab.tolerance(), linear_pivots_,
                         "the linear part of f");
  }

  /// Taylor coefficient of the remainder f - (its linear part) at X_0 + lambda X_1 + .., of the order of the
  /// last term.
  Outcome<TensorTrain> coefficient(const StrategySlab& slab) {
    const auto order = static_cast<int>(terms_.size()) - 1;
    const Eigen::VectorXd nodes = chebyshev_roots(2 * order + 5);
    const Eigen::RowVectorXd weights = taylor_weights(nodes, order);
    const TensorTrain centre = slab.start_at_points();
    const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd q = slab.parameters_at(entries);
      std::vector<Eigen::MatrixXd> terms;
      for (const TensorTrain& term : terms_) terms.push_back(values_at(term, entries));
      values = Eigen::MatrixXd::Zero(slab.rows(), entries.cols());
      for (Eigen::Index k = 0; k < nodes.size(); ++k) {
        Eigen::MatrixXd x = terms.back();
        for (std::size_t j = terms.size() - 1; j-- > 0;) x = nodes[k] * x + terms[j];
        values += weights[k] * slab.rates(x, q);
      }
      const Eigen::MatrixXd jacobians = values_at(jacobian_, entries);
      if (order == 0) {
        const Eigen::MatrixXd x = values_at(centre, entries);
        values = source_at(slab, values - slab.rates(x, q), terms[0] - x, jacobians);
      } else {
        values = source_at(slab, values, terms.back(), jacobians);
      }
    };
    return slab.separate(function, slab.rows(), kSourceShare * slab.tolerance(), source_pivots_,
                         "a term of the series of f");
  }

  TensorTrain jacobian_;
  std::vector<TensorTrain> terms_;
  std::optional<TensorTrain> source_;
  TensorTrain iterate_;  ///< the last one
  CrossPivots jacobian_pivots_, linear_pivots_, source_pivots_;
};

}  // namespace

std::unique_ptr<Strategy> asymptotic_strategy() {
  return std::make_unique<Asymptotic>();
}

}  // namespace samara::pgd
