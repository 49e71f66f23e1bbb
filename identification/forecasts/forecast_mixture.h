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
/// @param said by each predictor, moments x components; moments in which one gives none (NaN) are left out
/// @returns one share each; all on the first if no moment is left
/// @throws ArgumentError for no predictor and shapes that differ
Eigen::VectorXd convex_shares(std::span<const Eigen::MatrixXd> said, const Eigen::MatrixXd& measured);

/// What predictors say together. Where one gives no forecast the others take its share; NaN where none with a share
/// gives one.
Eigen::MatrixXd weighted(std::span<const Eigen::MatrixXd> said, const Eigen::VectorXd& shares);

/// How far those predictors that give a forecast lie apart in each moment: root of the mean squared distance from
/// their mean; 0 where none or one gives it.
Eigen::VectorXd disagreement(std::span<const Eigen::MatrixXd> said);

/// Errors of a predictor: a mean, and two normals about it (heavier tails than one). Both deviations vary with signs
/// of how hard a moment is, numbers s_j such as logarithms of a speed: they are multiplied by
///
///     exp(sum_j b_j (s_j - m_j)/d_j),
///
/// where s_j counts within the middle 90 % of the training's, those beyond as its ends, and m_j and d_j are mean and
/// deviation of what counts. b, of each kind of component, is a regression of the logarithm of an error's size, as if
/// four clusters more showed no growth. Errors of one motion are alike, so the size of errors is known from as many
/// numbers as there are motions: with n of them deviations are as much wider as Student's distribution with n - 1
/// degrees of freedom is at its 90 % band.
class ErrorDistribution {
 public:
  /// @param errors measured less predicted, moments x components; rows with NaN are left out
  /// @param components the level ones have one distribution about 0: no direction is preferred
  /// @param signs of the same moments, a row each, NaN where unknown; no columns: deviations do not vary
  /// @param clusters of the same moments, equal for those of motions that resemble each other; empty: all their own
  /// @throws ArgumentError for sizes that differ
  static ErrorDistribution fit(const Eigen::MatrixXd& errors, const Components& components,
                               const Eigen::MatrixXd& signs = {}, const std::vector<int>& clusters = {});

  /// Fewer than 3 errors in training tell nothing.
  bool is_fitted() const { return !kinds_.empty(); }

  /// What is known of a component that is predicted so.
  /// @param signs as many as in training, NaN where unknown: as in the mean of the training; empty: all unknown
  /// @throws ArgumentError for another number of signs, and a component that there is not
  NormalMixture around(Eigen::Index component, double predicted, const Eigen::RowVectorXd& signs = {}) const;

 private:
  struct Kind {
    double mean = 0.0;
    Eigen::Vector2d weights = {1.0, 0.0}, deviations = {0.0, 0.0};
    Eigen::VectorXd growth = {};  ///< b, of each sign
  };
  struct Sign {
    double lower = 0.0, upper = 0.0;  ///< within which it counts
    double mean = 0.0, deviation = 0.0;
  };
  static Sign sign_of(const Eigen::VectorXd& values);
  /// In units of their deviations from the mean.
  Eigen::RowVectorXd standardised(const Eigen::RowVectorXd& signs) const;

  std::vector<Sign> signs_ = {};
  std::vector<Kind> kinds_ = {};
  std::vector<std::size_t> kind_of_ = {};  ///< of each component
};

}  // namespace samara::identification
