#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/identification/forecasts/forecast.h"

/// Proper scores of forecasts: a distribution that says what it does not know scores best by saying what is
/// so, neither wider nor narrower.
///
/// The continuous ranked probability score of a distribution F and a measured y,
///
///     CRPS(F, y) = integral (F(x) - [x >= y])^2 dx = E|X - y| - E|X - X'|/2,
///
/// is in the unit of y; that of a forecast without spread is |x - y|. For a mixture of normals it is in closed
/// form (Grimit, Gneiting, Berrocal and Johnson, Q. J. R. Meteorol. Soc. 132 (2006) 2925-2942, eq. 5):
///
///     sum_i w_i A(y - m_i, s_i^2) - 1/2 sum_ij w_i w_j A(m_i - m_j, s_i^2 + s_j^2),
///     A(m, s^2) = 2 s phi(m/s) + m (2 Phi(m/s) - 1).
///
/// "crps" of positions is the mean of that over their components: it needs no random numbers, as the energy
/// score of a mixture in space would. Coverage is the share of components that lie in the central interval.
namespace samara::identification {

/// Of one number.
struct NormalMixture {
  Eigen::VectorXd weights = {};  ///< 0 or more, 1 together
  Eigen::VectorXd means = {};
  Eigen::VectorXd deviations = {};  ///< 0 or more; 0: a number that is certain
};

/// All that follow throw ArgumentError for a mixture without members, of sizes that differ, with numbers that
/// are not finite, weights or deviations below 0, or weights that are not 1 together within 1e-6.

/// P(X <= x).
double probability_below(const NormalMixture& mixture, double x);
/// The number below which a part of the distribution lies, to 1e-12 of its spread.
/// @param part in (0, 1), else ArgumentError
double quantile(const NormalMixture& mixture, double part);
/// @throws ArgumentError for a measured value that is not finite
double crps(const NormalMixture& mixture, double measured);

/// The forecast of one output at one time. Components that say nothing there are left out, and the weights of
/// the others raised; none left: empty.
/// @throws ArgumentError for shapes that differ, and covariances that are not finite or have a diagonal below 0
NormalMixture marginal(const Forecast& forecast, Eigen::Index time, Eigen::Index output);

/// Scores of many numbers that were forecast.
class ProperScores {
 public:
  /// One more. @param measured NaN: missing, and not counted
  /// @param cluster of numbers that err alike, such as those of one motion
  void add(const NormalMixture& mixture, double measured, int cluster = 0);
  /// All times and outputs of a forecast. @param measured times x outputs, NaN where missing
  void add(const Forecast& forecast, const Eigen::MatrixXd& measured, int cluster = 0);

  int count() const { return static_cast<int>(crps_.size()); }
  /// NaN where nothing was counted.
  double mean_crps() const;
  /// Share of numbers in the central interval that holds a part of the distribution.
  /// @param part in (0, 1)
  double coverage(double part) const;
  /// Its standard error, clusters being drawn anew: sqrt(C/(C - 1) sum_c (i_c - p n_c)^2)/n, where cluster c has i_c
  /// of its n_c numbers inside, p is the coverage and n = sum_c n_c (W. G. Cochran, Sampling Techniques, 3rd ed.,
  /// Wiley 1977, section 3.12). NaN for fewer than two clusters.
  double coverage_error(double part) const;
  const std::vector<double>& each_crps() const { return crps_; }

 private:
  bool is_inside(std::size_t k, double part) const;

  /// Of each, and P(X <= measured); where the distribution steps at the measured value, what of the step is nearest
  /// to 1/2: a certain forecast that is right lies in every interval.
  std::vector<double> crps_ = {}, below_ = {};
  std::vector<int> clusters_ = {};  ///< of each
};

}  // namespace samara::identification
