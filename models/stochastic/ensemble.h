#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace samara::models {

class EnsembleSums;

enum class RealisationStatus {
  flying,      ///< still under way at the last time
  landed,      ///< came down to the ground
  left_flow,   ///< came to where the flow ends
  not_finite,  ///< a state is infinite or not a number
};

/// A realisation that has come down, where it crossed the ground (between two steps, by a straight line).
struct Landing {
  long realisation = 0;
  double t = 0.0;                                      ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world [m]; in a plane (x, 0, y)
};

/// A number that is estimated, with its standard error.
struct Estimated {
  double value = 0.0, error = 0.0;
};

/// Shares of steps that are longer than the air changes along the path.
struct StepShares {
  /// h > 0.1 of AirSeen::time_scale: more than 5 % of error where the energy has a gradient.
  double beyond_tenth = 0.0;
  double beyond_third = 0.0;  ///< h >= 0.3 of it
  double shortest = 0.0;      ///< the scale that one step in twenty stays below [s]
};

/// What many realisations of one motion have come to.
///
/// Statistics at a time are over those still flying then. Standard errors are those of the sampling: of a mean from
/// the scatter of realisations (of pairs where they are antithetic), of a covariance from the scatter between groups
/// of 32; NaN where there are too few to tell.
struct Ensemble {
  Eigen::VectorXd times;
  std::vector<std::string> states;                            ///< whose statistics are kept
  std::vector<std::string> units;                             ///< theirs
  Eigen::Matrix<long, Eigen::Dynamic, 1> flying;              ///< per time
  Eigen::MatrixXd mean, mean_error;                           ///< times x states
  std::vector<Eigen::MatrixXd> covariance, covariance_error;  ///< per time
  std::vector<Landing> landings;                              ///< in the order of realisations
  std::vector<RealisationStatus> status;                      ///< per realisation
  /// Per realisation, how often it turned over: half turns, by which side of it is up. Empty without an attitude.
  std::vector<int> half_turns;
  Estimated mean_half_turns;
  /// Of the first realisations, as many as asked for: times x all states; NaN after their end.
  std::vector<Eigen::MatrixXd> kept;
  StepShares steps;
  long first = 0;                     ///< number of the first realisation
  bool antithetic = false;            ///< realisations 2 i and 2 i + 1 are a pair
  double step = 0.0;                  ///< upper bound [s]
  std::optional<double> ground = {};  ///< [m]
  std::vector<double> values;         ///< initial values and parameters that were flown
  bool cancelled = false;             ///< by the progress callback; what is here is complete
  /// Of the mean displacement at the last time (or at the landing), see RealiseOptions.
  double relative_error = 0.0;

  long realisations() const { return static_cast<long>(status.size()); }
  long count(RealisationStatus which) const;
  double standard_deviation(Eigen::Index time, Eigen::Index state) const {
    return std::sqrt(covariance[static_cast<std::size_t>(time)](state, state));
  }

  /// What resume() needs to go on; null in one that was not made by realise().
  std::shared_ptr<const EnsembleSums> sums;
};

/// Where realisations have landed.
struct LandingStatistics {
  long landed = 0;
  Estimated t;                                                                           ///< [s]
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), mean_error = Eigen::Vector3d::Zero();  ///< [m]
  /// [m^2]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero(), covariance_error = Eigen::Matrix3d::Zero();
  /// Shares 0.05, 0.25, 0.5, 0.75, 0.95 land below these, by coordinate (columns).
  Eigen::Matrix<double, 5, 3> quantiles = Eigen::Matrix<double, 5, 3>::Zero();
  /// Ends of their 95 % intervals, from order statistics, whatever the distribution is; NaN where too few landed. Of
  /// antithetic pairs they are those of as many single realisations.
  Eigen::Matrix<double, 5, 3> quantiles_lower = Eigen::Matrix<double, 5, 3>::Zero(),
                              quantiles_upper = Eigen::Matrix<double, 5, 3>::Zero();
};

inline constexpr double kLandingShares[] = {0.05, 0.25, 0.5, 0.75, 0.95};

/// Numbers are NaN where nothing landed; errors where too few did.
LandingStatistics landing_statistics(const Ensemble& ensemble);

/// What to do about steps that are too long for the air, "--step 0.0003 would do"; where flights diverged no number is
/// known: their own scales are no longer those of the air.
/// @param option in front of the number
std::string better_step(const Ensemble& cloud, std::string_view option);

/// One sentence where more than 5 % of the steps are 0.3 of the time in which the air changes or longer; else empty.
std::string doubt_of_steps(const Ensemble& cloud, std::string_view option);

}  // namespace samara::models
