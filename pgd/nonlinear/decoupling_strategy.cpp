#include <algorithm>
#include <utility>
#include <vector>

#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/monomial_product.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Of the last correction, what the next source may be wrong by.
constexpr double kInexact = 0.02;

/// The rows of one unknown among those of all, at so many times: times x (states times).
Eigen::MatrixXd rows_of_unknown(int unknown, int states, int times) {
  Eigen::MatrixXd selection = Eigen::MatrixXd::Zero(times, states * times);
  for (int i = 0; i < times; ++i) selection(i, unknown + states * i) = 1.0;
  return selection;
}

class Decoupling final : public Strategy {
 public:
  std::string name() const override { return "decoupling"; }

  std::optional<Ending> begin(const StrategySlab& slab) override {
    pivots_.assign(static_cast<std::size_t>(slab.states()), {});
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double> correction) override {
    const TensorTrain at_points = slab.at_points(iterate);
    const TensorTrain start = slab.start_at_points();
    unknowns_.clear();
    for (int m = 0; m < slab.states(); ++m)
      unknowns_.push_back(applied(at_points, 0, rows_of_unknown(m, slab.states(), slab.points())));
    // While corrections are large, their size is all that products must be good to.
    const double enough = kSourceShare * slab.tolerance();
    const double tolerance = std::max(enough, kInexact * correction.value_or(1.0));
    TensorTrain all;
    for (int m = 0; m < slab.states(); ++m) {
      Outcome<TensorTrain> source = source_of(slab, m, tolerance);
      if (!source) return source.ending();
      const Eigen::MatrixXd rows = rows_of_unknown(m, slab.states(), slab.points());
      unknowns_[static_cast<std::size_t>(m)] =
          slab.compressed(sum(applied(start, 0, rows), applied(*source, 0, slab.integration())), tolerance);
      TensorTrain placed = applied(std::move(*source), 0, Eigen::MatrixXd(rows.transpose()));
      all = all.cores.empty() ? std::move(placed) : sum(all, placed);
    }
    return LinearSlab{{}, slab.compressed(std::move(all), tolerance), tolerance > enough};
  }

 private:
  /// The rate of one unknown at the Radau points, of the last known fields.
  Outcome<TensorTrain> source_of(const StrategySlab& slab, int m, double tolerance) {
    if (const PolynomialSystem* polynomial = slab.problem().system->polynomial())
      return products(slab, polynomial->terms(), m, tolerance);
    const EntryFunction rates = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      Eigen::MatrixXd x(slab.rows(), entries.cols());
      for (int k = 0; k < slab.states(); ++k) {
        x(Eigen::seqN(k, slab.points(), slab.states()), Eigen::all) =
            values_at(unknowns_[static_cast<std::size_t>(k)], entries);
      }
      values = slab.rates(x, slab.parameters_at(entries))(Eigen::seqN(m, slab.points(), slab.states()),
                                                          Eigen::all);
    };
    Outcome<TensorTrain> separated = slab.separate(
        rates, slab.points(), tolerance, pivots_[static_cast<std::size_t>(m)], "the rate of an unknown");
    if (!separated) return separated;
    return slab.compressed(std::move(*separated), tolerance);
  }

  TensorTrain products(const StrategySlab& slab, const std::vector<Monomial>& terms, int m,
                       double tolerance) const {
    const auto state = [&](int k) { return unknowns_[static_cast<std::size_t>(k)]; };
    const auto product = [&](const TensorTrain& a, const TensorTrain& b) {
      return slab.product(a, b, tolerance);
    };
    TensorTrain total = scaled(unknowns_[static_cast<std::size_t>(m)], 0.0);
    for (const Monomial& term : terms) {
      if (term.state != m || term.coefficient == 0.0) continue;
      const TensorTrain one = monomial_product(term, slab, state, product);
      total = slab.compressed(sum(total, one), tolerance / static_cast<double>(terms.size()));
    }
    return total;
  }

  std::vector<TensorTrain> unknowns_;  ///< at the Radau points, over their scales
  std::vector<CrossPivots> pivots_;
};

}  // namespace

std::unique_ptr<Strategy> decoupling_strategy() {
  return std::make_unique<Decoupling>();
}

}  // namespace samara::pgd
