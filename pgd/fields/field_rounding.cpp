#include "samara/pgd/fields/field_rounding.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"
#include "samara/pgd/tensors/train_algebra.h"
#include "samara/pgd/tensors/train_points.h"

namespace samara::pgd {

namespace {

constexpr int kPoints = 2000;

/// Half of the points uniform, half with coordinates at the ends of their axes, each by the toss of a coin.
/// Where there are centres, as many again: those, and points near them in most coordinates.
Eigen::MatrixXd trial_points(const std::vector<Axis>& axes, const Eigen::MatrixXd& centres,
                             std::uint64_t seed) {
  constexpr double kNear = 0.1;
  constexpr double kAnywhere = 0.25;
  Random random(seed);
  Eigen::MatrixXd points(static_cast<Eigen::Index>(axes.size()), centres.cols() > 0 ? 2 * kPoints : kPoints);
  for (Eigen::Index j = kPoints; j < points.cols(); ++j) {
    const bool is_centre = j - kPoints < std::min<Eigen::Index>(centres.cols(), kPoints / 2);
    const Eigen::Index centre = is_centre ? j - kPoints : random.below(static_cast<int>(centres.cols()));
    points.col(j) = centres.col(centre);
    for (std::size_t k = 0; k < axes.size() && !is_centre; ++k) {
      const Axis& axis = axes[k];
      if (!axis.has_elements()) continue;
      double& x = points(static_cast<Eigen::Index>(k), j);
      const double way = axis.length() * kNear * random.normal();
      x = random.uniform() < kAnywhere ? axis.lower() + axis.length() * random.uniform()
                                       : std::clamp(x + way, axis.lower(), axis.upper());
    }
  }
  for (Eigen::Index j = 0; j < kPoints; ++j) {
    for (std::size_t k = 0; k < axes.size(); ++k) {
      const Axis& axis = axes[k];
      double x = axis.lower() + axis.length() * random.uniform();
      if (axis.is_list()) x = axis.nodes()[random.below(axis.size())];
      if (j % 2 == 1 && random.below(2) == 1) x = random.below(2) == 1 ? axis.upper() : axis.lower();
      points(static_cast<Eigen::Index>(k), j) = x;
    }
  }
  return points;
}

TensorTrain with_outputs_scaled(TensorTrain train, const Eigen::VectorXd& factors) {
  train.cores.front().left_unfolding() = factors.asDiagonal() * train.cores.front().left_unfolding();
  return train;
}

}  // namespace

RoundedField rounded(const TrainField& field, const Eigen::VectorXd& scale, double tolerance,
                     std::uint64_t seed, const Eigen::MatrixXd& centres) {
  if (scale.size() != field.output_count() || !(scale.minCoeff() > 0.0) || !scale.allFinite()) {
    throw ArgumentError(fmt::format("rounding of {} outputs by {} scales, expected as many positive ones",
                                    field.output_count(), scale.size()));
  }
  require(tolerance >= 0.0 && tolerance < 1.0, "tolerance", tolerance, "a number from 0 to 1", "rounded");
  if (centres.size() > 0 && centres.rows() != field.axis_count()) {
    throw ArgumentError(fmt::format("rounding with centres of {} coordinates, expected those of {} axes",
                                    centres.rows(), field.axis_count()));
  }
  const Eigen::MatrixXd points = trial_points(field.axes(), centres, seed);
  const Eigen::MatrixXd exact = many_values_at(field.train(), field.axes(), points);
  const TensorTrain train = with_outputs_scaled(field.train(), scale.cwiseInverse());
  const double entries = full_size(train);
  // Largest errors are some times the mean square: the first trial is generous, the next ones follow what was
  // seen.
  double mean_square = tolerance;
  constexpr int kTrials = 10;
  for (int trial = 0; trial < kTrials && mean_square > 0.0; ++trial) {
    TensorTrain cut = rounded(train, mean_square * std::sqrt(entries));
    TrainField candidate(field.axes(), field.outputs(), with_outputs_scaled(std::move(cut), scale));
    const Eigen::MatrixXd change =
        scale.cwiseInverse().asDiagonal() * (many_values_at(candidate.train(), field.axes(), points) - exact);
    const double error = change.cwiseAbs().maxCoeff();
    if (error <= tolerance) return {std::move(candidate), error};
    mean_square *= std::clamp(0.8 * tolerance / error, 0.05, 0.8);
  }
  return {field, 0.0};
}

}  // namespace samara::pgd
