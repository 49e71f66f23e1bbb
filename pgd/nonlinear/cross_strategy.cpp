#include <utility>

#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Accuracy of the separated Jacobian, per slab: it bounds the contraction, not the error.
constexpr double kJacobianTolerance = 1e-3;
/// Once corrections are this small, the last Jacobian is as good as a new one.
constexpr double kSettled = 1e-2;

class CrossStrategy final : public Strategy {
 public:
  explicit CrossStrategy(const CrossStrategyOptions& options) : options_(options) {}

  std::string name() const override {
    return options_.newton ? "Newton's iteration with cross interpolation"
                           : "Picard's iteration with cross interpolation";
  }

  std::optional<Ending> begin(const StrategySlab&) override {
    jacobian_.reset();
    jacobian_pivots_ = source_pivots_ = {};
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double> correction) override {
    if (!options_.newton) return picard(slab, iterate);
    if (!jacobian_ || !correction || *correction > kSettled) {
      Outcome<TensorTrain> jacobian = separated_jacobian(slab, iterate, kJacobianTolerance, jacobian_pivots_);
      if (!jacobian) return jacobian.ending();
      jacobian_ = std::move(*jacobian);
    }
    // The source goes with the separated Jacobian, whose errors then do not enter the solution.
    const TensorTrain at_points = slab.at_points(iterate);
    const EntryFunction source = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd x = values_at(at_points, entries);
      values = source_at(slab, slab.rates(x, slab.parameters_at(entries)), x, values_at(*jacobian_, entries));
    };
    const double tolerance = kSourceShare * slab.tolerance();
    Outcome<TensorTrain> b = slab.separate(source, slab.rows(), tolerance, source_pivots_, "f");
    if (!b) return b.ending();
    return LinearSlab{jacobian_, slab.compressed(std::move(*b), tolerance)};
  }

 private:
  Outcome<LinearSlab> picard(const StrategySlab& slab, const TensorTrain& iterate) {
    Outcome<TensorTrain> rates = separated_rates(slab, iterate, source_pivots_);
    if (!rates) return rates.ending();
    return LinearSlab{{}, std::move(*rates)};
  }

  CrossStrategyOptions options_;
  std::optional<TensorTrain> jacobian_;
  CrossPivots jacobian_pivots_, source_pivots_;
};

}  // namespace

std::unique_ptr<Strategy> cross_strategy(const CrossStrategyOptions& options) {
  return std::make_unique<CrossStrategy>(options);
}

}  // namespace samara::pgd
