#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/require.h"
#include "samara/pgd/nonlinear/monomial_product.h"
#include "samara/pgd/nonlinear/piecewise_linear_system.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Points whose weight stays below this wherever it is looked at are left out on a slab.
constexpr double kNoWeight = 1e-6;
constexpr int kLookedAt = 200;
constexpr int kWeightCheckPoints = 50;

class PiecewiseLinear final : public Strategy {
 public:
  explicit PiecewiseLinear(const PiecewiseLinearOptions& options) : options_(options) {
    constexpr const char* kWhere = "piecewise_linear_strategy";
    require(options.points >= 1, "points", options.points, "1 or more", kWhere);
    require(options.samples >= 1, "samples", options.samples, "1 or more", kWhere);
    require(options.weight_tolerance >= 0.0, "weight_tolerance", options.weight_tolerance, "0 or more",
            kWhere);
  }

  std::string name() const override { return "piecewise-linear approximation"; }
  bool is_exact() const override { return false; }
  std::optional<StrategyDetail> detail() const override { return detail_; }
  StrategyCounts prepared() const override { return prepared_; }

  std::optional<Ending> prepare(const EvolutionProblem& problem, double tolerance) override {
    prepared_ = {};
    const TrainingStates training = train_along(problem, options_.samples, tolerance, prepared_.rhs);
    if (training.x.cols() < options_.points) {
      return Ending{
          Termination::not_finite,
          fmt::format("training trajectories end after {} states, {} points are to be picked from them",
                      training.x.cols(), options_.points)};
    }
    model_.emplace(*problem.system, training, options_.points);
    prepared_.rhs += model_->rhs_evaluations();
    prepared_.jacobian += model_->jacobian_evaluations();
    return std::nullopt;
  }

  std::optional<Ending> begin(const StrategySlab&) override {
    detail_ = {"weights", 0, 0.0};
    active_.clear();
    pivots_ = {};
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    const TensorTrain at_points = slab.at_points(iterate);
    const Outcome<TensorTrain> weights = separated_weights(slab, at_points);
    if (!weights) return weights.ending();
    const double tolerance = kSourceShare * slab.tolerance();
    const Eigen::VectorXd of_rates = slab.length() * slab.scales().cwiseInverse();
    const Eigen::VectorXd of_jacobians = (of_rates * slab.scales().transpose()).reshaped();
    TensorTrain source, jacobian;
    for (int k = 0; k <= static_cast<int>(slab.sizes().size()); ++k) {
      add(slab, *weights, of_rates.asDiagonal() * model_->source(k)(Eigen::all, active_), k, tolerance,
          source);
      add(slab, *weights, of_jacobians.asDiagonal() * model_->jacobian(k)(Eigen::all, active_), k, tolerance,
          jacobian);
    }
    if (source.cores.empty()) source = scaled(at_points, 0.0);
    if (jacobian.cores.empty()) return LinearSlab{{}, std::move(source)};
    return LinearSlab{std::move(jacobian), std::move(source)};
  }

 private:
  /// Weights of the active points, row a + (active points) i: that of point a at Radau point i.
  Outcome<TensorTrain> separated_weights(const StrategySlab& slab, const TensorTrain& at_points) {
    find_active(slab, at_points);
    const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      values = weights_at(slab, at_points, entries);
    };
    const double tolerance = options_.weight_tolerance > 0.0 ? options_.weight_tolerance : slab.tolerance();
    const int outputs = static_cast<int>(active_.size()) * slab.points();
    Outcome<TensorTrain> separated = slab.separate(function, outputs, tolerance, pivots_, "a weight");
    if (!separated) return separated;
    TensorTrain weights = slab.compressed(std::move(*separated), tolerance);
    const IndexBatch entries = slab.random_entries(kWeightCheckPoints);
    const double error =
        (values_at(weights, entries) - weights_at(slab, at_points, entries)).cwiseAbs().maxCoeff();
    const std::vector<int> ranks = weights.ranks();
    detail_.rank = std::max(detail_.rank, *std::max_element(ranks.begin(), ranks.end()));
    detail_.error = std::max(detail_.error, error);
    return weights;
  }

  Eigen::MatrixXd weights_at(const StrategySlab& slab, const TensorTrain& at_points,
                             const IndexBatch& entries) const {
    const Eigen::MatrixXd all = all_weights_at(slab, at_points, entries);
    const auto active = static_cast<Eigen::Index>(active_.size());
    return all(active_, Eigen::all).reshaped(active * slab.points(), entries.cols());
  }

  /// Points x (Radau points, then entries).
  Eigen::MatrixXd all_weights_at(const StrategySlab& slab, const TensorTrain& at_points,
                                 const IndexBatch& entries) const {
    const Eigen::Index n = slab.states();
    const Eigen::MatrixXd x = values_at(at_points, entries);
    return model_->weights(slab.scales().asDiagonal() * x.reshaped(n, slab.points() * entries.cols()));
  }

  /// Points that weigh anything on this slab; once found they stay, so that pivots keep their meaning.
  void find_active(const StrategySlab& slab, const TensorTrain& at_points) {
    const Eigen::VectorXd largest =
        all_weights_at(slab, at_points, slab.training_entries(kLookedAt)).rowwise().maxCoeff();
    for (int i = 0; i < model_->point_count(); ++i) {
      const bool known = std::find(active_.begin(), active_.end(), i) != active_.end();
      if (!known && largest[i] > kNoWeight) active_.push_back(i);
    }
  }

  /// Adds q_k sum_i w_i coefficients(., i), k = 0: without q.
  static void add(const StrategySlab& slab, const TensorTrain& weights, const Eigen::MatrixXd& coefficients,
                  int k, double tolerance, TensorTrain& total) {
    if (coefficients.cwiseAbs().maxCoeff() == 0.0) return;
    Eigen::MatrixXd matrix =
        Eigen::MatrixXd::Zero(coefficients.rows() * slab.points(), coefficients.cols() * slab.points());
    for (int i = 0; i < slab.points(); ++i) {
      matrix.block(coefficients.rows() * i, coefficients.cols() * i, coefficients.rows(),
                   coefficients.cols()) = coefficients;
    }
    TensorTrain term = applied(weights, 0, matrix);
    if (k > 0) {
      const Axis& axis = slab.problem().parameters[static_cast<std::size_t>(k) - 1];
      term = times_nodes(std::move(term), k, axis.nodes());
    }
    total = slab.compressed(total.cores.empty() ? std::move(term) : sum(total, term), tolerance);
  }

  PiecewiseLinearOptions options_;
  std::optional<PiecewiseLinearSystem> model_;
  StrategyCounts prepared_;
  std::vector<int> active_;
  CrossPivots pivots_;
  StrategyDetail detail_;
};

}  // namespace

std::unique_ptr<Strategy> piecewise_linear_strategy(const PiecewiseLinearOptions& options) {
  return std::make_unique<PiecewiseLinear>(options);
}

}  // namespace samara::pgd
