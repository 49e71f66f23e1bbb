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

  void begin(const StrategySlab&) override { jacobian_.reset(); }

  LinearSlab linearise(const StrategySlab& slab, const TensorTrain& iterate,
                       std::optional<double> correction) override {
    if (!options_.newton) return {{}, separated_rates(slab, iterate, source_pivots_)};
    if (!jacobian_ || !correction || *correction > kSettled)
      jacobian_ = separated_jacobian(slab, iterate, kJacobianTolerance, jacobian_pivots_);
    // The source goes with the separated Jacobian, whose errors then do not enter the solution.
    const TensorTrain at_points = slab.at_points(iterate);
    const EntryFunction source = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd x = values_at(at_points, entries);
      values = source_at(slab, slab.rates(x, slab.parameters_at(entries)), x, values_at(*jacobian_, entries));
    };
    const double tolerance = kSourceShare * slab.tolerance();
    TensorTrain b = slab.separate(source, slab.rows(), tolerance, source_pivots_, "f");
    return {jacobian_, slab.compressed(std::move(b), tolerance)};
  }

 private:
  CrossStrategyOptions options_;
  std::optional<TensorTrain> jacobian_;
  CrossPivots jacobian_pivots_, source_pivots_;
};

}  // namespace

std::unique_ptr<Strategy> cross_strategy(const CrossStrategyOptions& options) {
  return std::make_unique<CrossStrategy>(options);
}

}  // namespace samara::pgd
