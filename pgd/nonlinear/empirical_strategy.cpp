#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/nonlinear/strategy.h"
#include "samara/pgd/tensors/thin_svd.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

/// Entries at which f and its interpolant are compared, in every training.
constexpr int kCheckPoints = 24;
/// Random ones, besides corners and middle.
constexpr int kTrainingPoints = 16;
/// Per iteration.
constexpr int kMaxRetraining = 8;

/// Interpolation rows of the columns of a basis: one after the other, where the next column is interpolated
/// worst by those before (Chaturantabut and Sorensen 2010, algorithm 1).
std::vector<int> interpolation_rows(const Eigen::MatrixXd& basis) {
  std::vector<int> rows;
  for (Eigen::Index c = 0; c < basis.cols(); ++c) {
    Eigen::VectorXd rest = basis.col(c);
    if (c > 0) {
      const Eigen::MatrixXd known = basis.leftCols(c);
      const Eigen::VectorXd seen = rest(rows);
      rest -= known * Eigen::MatrixXd(known(rows, Eigen::all)).partialPivLu().solve(seen).eval();
    }
    Eigen::Index worst = 0;
    rest.cwiseAbs().maxCoeff(&worst);
    rows.push_back(static_cast<int>(worst));
  }
  return rows;
}

/// What interpolation in a basis needs.
struct Interpolation {
  Eigen::MatrixXd from_rows;  ///< f at all rows from f at the interpolation rows
  std::vector<int> rows;      ///< among the rows of the time nodes below
  std::vector<int> nodes;     ///< Radau points at which f is evaluated
  double amplification = 1.0;
};

class Empirical final : public Strategy {
 public:
  std::string name() const override { return "discrete empirical interpolation"; }
  std::optional<StrategyDetail> detail() const override { return detail_; }

  std::optional<Ending> begin(const StrategySlab& slab) override {
    training_ = slab.training_entries(kTrainingPoints);
    pivots_ = {};
    return std::nullopt;
  }

  Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                std::optional<double>) override {
    const TensorTrain at_points = slab.at_points(iterate);
    for (int training = 1;; ++training) {
      const Outcome<Interpolation> basis = trained(slab, at_points);
      if (!basis) return basis.ending();
      Outcome<TensorTrain> found = coefficients(slab, at_points, *basis);
      if (!found) return found.ending();
      TensorTrain source = applied(std::move(*found), 0, basis->from_rows);
      const IndexBatch entries = slab.random_entries(kCheckPoints);
      const Eigen::MatrixXd exact = slab.rates(values_at(at_points, entries), slab.parameters_at(entries));
      const Eigen::RowVectorXd errors = (values_at(source, entries) - exact).cwiseAbs().colwise().maxCoeff();
      detail_ = {"basis of f", static_cast<int>(basis->rows.size()), errors.maxCoeff()};
      const double wanted = 3.0 * kSourceShare * slab.tolerance();
      if (!(errors.maxCoeff() > wanted) || training >= kMaxRetraining)
        return LinearSlab{{}, slab.compressed(std::move(source), kSourceShare * slab.tolerance())};
      for (Eigen::Index j = 0; j < entries.cols(); ++j) {
        if (!(errors[j] > wanted)) continue;
        training_.conservativeResize(Eigen::NoChange, training_.cols() + 1);
        training_.rightCols(1) = entries.col(j);
      }
    }
  }

 private:
  Outcome<Interpolation> trained(const StrategySlab& slab, const TensorTrain& at_points) const {
    const Eigen::MatrixXd snapshots =
        slab.rates(values_at(at_points, training_), slab.parameters_at(training_));
    if (!snapshots.allFinite()) {
      Eigen::Index bad = 0;
      while (snapshots.col(bad).allFinite()) ++bad;
      const Eigen::VectorXd q = slab.parameters_at(training_.col(bad));
      const std::vector<double> at(q.begin(), q.end());
      return Ending{Termination::not_finite,
                    fmt::format("f is not finite between t = {:.6g} and {:.6g} at {}", slab.begin(),
                                slab.begin() + slab.length(), slab.described(at)),
                    at};
    }
    const ThinSvd svd = thin_svd(snapshots);
    const double cut = 0.1 * kSourceShare * slab.tolerance();
    Eigen::Index rank = 1;
    while (rank < svd.singular.size() && svd.singular[rank] > cut) ++rank;
    const Eigen::MatrixXd basis = svd.u.leftCols(rank);
    const std::vector<int> rows = interpolation_rows(basis);
    Interpolation result;
    result.from_rows = basis * basis(rows, Eigen::all).partialPivLu().inverse();
    result.amplification = std::max(1.0, result.from_rows.cwiseAbs().rowwise().sum().maxCoeff());
    for (const int row : rows) result.nodes.push_back(row / slab.states());
    std::sort(result.nodes.begin(), result.nodes.end());
    result.nodes.erase(std::unique(result.nodes.begin(), result.nodes.end()), result.nodes.end());
    for (const int row : rows) {
      const auto node = std::lower_bound(result.nodes.begin(), result.nodes.end(), row / slab.states());
      result.rows.push_back(static_cast<int>(node - result.nodes.begin()) * slab.states() +
                            row % slab.states());
    }
    return result;
  }

  /// f at the interpolation rows, over the parameters.
  Outcome<TensorTrain> coefficients(const StrategySlab& slab, const TensorTrain& at_points,
                                    const Interpolation& basis) {
    const Eigen::Index n = slab.states();
    const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
      const Eigen::MatrixXd x = values_at(at_points, entries);
      Eigen::MatrixXd x_at_nodes(n * static_cast<Eigen::Index>(basis.nodes.size()), x.cols());
      for (std::size_t i = 0; i < basis.nodes.size(); ++i)
        x_at_nodes.middleRows(n * static_cast<Eigen::Index>(i), n) = x.middleRows(n * basis.nodes[i], n);
      values = slab.rates(x_at_nodes, slab.parameters_at(entries), basis.nodes)(basis.rows, Eigen::all);
    };
    return slab.separate(function, static_cast<int>(basis.rows.size()),
                         kSourceShare * slab.tolerance() / basis.amplification, pivots_, "f");
  }

  StrategyDetail detail_;
  CrossPivots pivots_;
  IndexBatch training_;
};

}  // namespace

std::unique_ptr<Strategy> empirical_strategy() {
  return std::make_unique<Empirical>();
}

}  // namespace samara::pgd
