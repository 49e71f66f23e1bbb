#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Step of the differences of the Jacobian, in scales: the formula's error is of its fourth power.
constexpr double kDifferenceStep = 1e-3;

class Polynomial final : public Strategy {
 public:
  explicit Polynomial(const PolynomialOptions& options) : options_(options) {
    require(options.order == 1 || options.order == 2, "order", options.order, "1 or 2",
            "polynomial_strategy");
  }

  std::string name() const override { return "polynomial linearisation"; }
  bool is_exact() const override { return false; }
  /// The first order does not depend on the iterate: the second iteration only confirms it.
  int max_iterations() const override { return options_.order == 1 ? 2 : 1000; }

  std::optional<Ending> prepare(const EvolutionProblem& problem, double) override {
    if (!options_.state || options_.state->size() == problem.system->state_count()) return std::nullopt;
    throw ArgumentError(fmt::format("polynomial_strategy: a state of {} numbers, expected {}",
                                    options_.state->size(), problem.system->state_count()));
  }

  std::optional<Ending> begin(const StrategySlab& slab) override {
    jacobian_pivots_ = source_pivots_ = {};
    centre_ = slab.start_at_points();
    if (options_.state) {
      centre_.cores[0] = TrainCore(1, slab.rows(), 1);
      centre_.cores[0].data = options_.state->cwiseQuotient(slab.scales()).replicate(slab.points(), 1);
      for (std::size_t k = 0; k < slab.sizes().size(); ++k) {
        centre_.cores[k + 1] = TrainCore(1, slab.sizes()[k], 1);
        centre_.cores[k + 1].data.setOnes();
      }
    }
    Outcome<TensorTrain> separated =
        separated_jacobian_at(slab, centre_, kSourceShare * slab.tolerance(), jacobian_pivots_);
    if (!separated) return separated.ending();
    jacobian_ = std::move(*separated);
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    const TensorTrain at_points = slab.at_points(iterate);
    const EntryFunction source = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd centre = values_at(centre_, entries);
      const Eigen::MatrixXd q = slab.parameters_at(entries);
      values = source_at(slab, slab.rates(centre, q), centre, values_at(jacobian_, entries));
      if (options_.order == 2) values += quadratic(slab, centre, values_at(at_points, entries) - centre, q);
    };
    const double tolerance = kSourceShare * slab.tolerance();
    Outcome<TensorTrain> b =
        slab.separate(source, slab.rows(), tolerance, source_pivots_, "the expansion of f");
    if (!b) return b.ending();
    return LinearSlab{jacobian_, slab.compressed(std::move(*b), tolerance)};
  }

 private:
  /// H(d, d) / 2 at every point, from differences of the Jacobian along d: J(x + h d) d - J(x - h d) d is
  /// 2 h H(d, d) up to h^3, of which the step 2 h takes the next power away.
  static Eigen::MatrixXd quadratic(const StrategySlab& slab, const Eigen::MatrixXd& centre,
                                   const Eigen::MatrixXd& difference, const Eigen::MatrixXd& q) {
    // One unit direction per entry; H is quadratic in it.
    const Eigen::RowVectorXd size = difference.cwiseAbs().colwise().maxCoeff().cwiseMax(1e-300);
    const Eigen::MatrixXd direction = difference * size.cwiseInverse().asDiagonal();
    const auto along = [&](double step) {
      const Eigen::MatrixXd jacobians = slab.jacobians(centre + step * direction, q);
      return Eigen::MatrixXd(
          -source_at(slab, Eigen::MatrixXd::Zero(centre.rows(), centre.cols()), direction, jacobians));
    };
    const Eigen::MatrixXd hessian = (8.0 * (along(kDifferenceStep) - along(-kDifferenceStep)) -
                                     (along(2.0 * kDifferenceStep) - along(-2.0 * kDifferenceStep))) /
                                    (12.0 * kDifferenceStep);
    return 0.5 * hessian * size.cwiseAbs2().asDiagonal();
  }

  PolynomialOptions options_;
  TensorTrain centre_, jacobian_;
  CrossPivots jacobian_pivots_, source_pivots_;
};

}  // namespace

std::unique_ptr<Strategy> polynomial_strategy(const PolynomialOptions& options) {
  return std::make_unique<Polynomial>(options);
}

}  // namespace samara::pgd
