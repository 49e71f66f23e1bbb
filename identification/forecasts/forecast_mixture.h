#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/autoregression.h"
#include "samara/identification/forecasts/proper_scores.h"

/// Forecasts from several predictors, with the errors that they showed on training motions.
///
///     const Eigen::VectorXd shares = convex_shares(said, measured);
///     const Eigen::MatrixXd mixed = weighted(said, shares);
///     const auto errors = ErrorDistribution::fit(measured - mixed, {.level = {0, 1}});
///     const NormalMixture z = errors.around(2, predicted_z);
namespace samara::identification {

/// Shares of predictors, 0 or more and 1 together, with which the weighted mean of what they said was nearest
/// to what came: least squares, robust (Huber), of distances over all components.
/// @param said by each predictor, moments x components; moments of which one is silent (NaN) are left out
/// @returns one share each; all on the first if no moment is left
/// @throws ArgumentError for no predictor and shapes that differ
Eigen::VectorXd convex_shares(std::span<const Eigen::MatrixXd> said, const Eigen::MatrixXd& measured);

/// What predictors say together. Where one is silent the others take its share; NaN where all with a share are.
Eigen::MatrixXd weighted(std::span<const Eigen::MatrixXd> said, const Eigen::VectorXd& shares);

/// How far those predictors that speak lie apart in each moment: root of the mean squared distance from their
/// mean; 0 where none or one speaks.
Eigen::VectorXd disagreement(std::span<const Eigen::MatrixXd> said);

/// Errors of a predictor: a mean, and two normals about it (heavier tails than one). With a disagreement of
/// predictors, both deviations grow with a power of it, 0 to 1, found in training. Errors of one motion are alike, so
/// the size of errors is known from as many numbers as there are motions: with n of them deviations are as much wider
/// as Student's distribution with n - 1 degrees of freedom is at its 90 % band.
class ErrorDistribution {
 public:
  /// @param errors measured less predicted, moments x components; rows with NaN are left out
  /// @param components the level ones have one distribution about 0: no direction is preferred
  /// @param disagreements of the same moments; empty: not used
  /// @param clusters of the same moments, equal for those of motions that resemble each other; empty: all their own
  /// @throws ArgumentError for sizes that differ
  static ErrorDistribution fit(const Eigen::MatrixXd& errors, const Components& components,
                               const Eigen::VectorXd& disagreements = {},
                               const std::vector<int>& clusters = {});

  /// Fewer than 3 errors in training tell nothing.
  bool is_fitted() const { return !kinds_.empty(); }

  /// What is known of a component that is predicted so.
  NormalMixture around(Eigen::Index component, double predicted, double disagreement = 1.0) const;

 private:
  struct Kind {
    double mean = 0.0;
    Eigen::Vector2d weights = {1.0, 0.0}, deviations = {0.0, 0.0};
    double power = 0.0, middle = 0.0;  ///< of the disagreement, and the logarithm at which it does nothing
  };
  std::vector<Kind> kinds_ = {};
  std::vector<std::size_t> kind_of_ = {};  ///< of each component
};

}  // namespace samara::identification
