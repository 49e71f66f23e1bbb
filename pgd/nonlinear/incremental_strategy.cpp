#include <utility>

#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/monomial_product.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// f of an iterate, one monomial after the other, by products of the states' own trains.
class Products {
 public:
  Products(const StrategySlab& slab, const TensorTrain& iterate, double tolerance)
      : slab_(slab), at_points_(slab.at_points(iterate)), tolerance_(tolerance) {}

  TensorTrain sum_of(const std::vector<Monomial>& terms) const {
    TensorTrain total;
    for (const Monomial& monomial : terms) {
      if (monomial.coefficient == 0.0) continue;
      TensorTrain one = term(monomial);
      total = total.cores.empty()
                  ? std::move(one)
                  : slab_.compressed(sum(total, one), tolerance_ / static_cast<double>(terms.size()));
    }
    return total.cores.empty() ? scaled(at_points_, 0.0) : total;
  }

 private:
  /// One state alone, over its scale: its first mode the Radau points.
  TensorTrain state(int m) const {
    Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(slab_.points(), slab_.rows());
    for (int i = 0; i < slab_.points(); ++i) selection(i, m + slab_.states() * i) = 1.0;
    return applied(at_points_, 0, selection);
  }

  TensorTrain term(const Monomial& monomial) const {
    TensorTrain product = monomial_product(
        monomial, slab_, [this](int m) { return state(m); },
        [this](const TensorTrain& a, const TensorTrain& b) { return slab_.product(a, b, tolerance_); });
    Eigen::MatrixXd placed = Eigen::MatrixXd::Zero(slab_.rows(), slab_.points());
    for (int i = 0; i < slab_.points(); ++i) placed(monomial.state + slab_.states() * i, i) = 1.0;
    return applied(std::move(product), 0, placed);
  }

  const StrategySlab& slab_;
  TensorTrain at_points_;
  double tolerance_;
};

class Incremental final : public Strategy {
 public:
  std::string name() const override { return "incremental linearisation"; }

  std::optional<Ending> begin(const StrategySlab&) override {
    pivots_ = {};
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    if (const PolynomialSystem* polynomial = slab.problem().system->polynomial())
      return LinearSlab{{},
                        Products(slab, iterate, kSourceShare * slab.tolerance()).sum_of(polynomial->terms())};
    Outcome<TensorTrain> rates = separated_rates(slab, iterate, pivots_);
    if (!rates) return rates.ending();
    return LinearSlab{{}, std::move(*rates)};
  }

 private:
  CrossPivots pivots_;
};

}  // namespace

std::unique_ptr<Strategy> incremental_strategy() {
  return std::make_unique<Incremental>();
}

}  // namespace samara::pgd
