#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

/// Profile likelihood of one coefficient: how much the cost must rise when the coefficient is held elsewhere
/// and everything else is minimised again.
///
/// With the cost 1/2 sum rho, its least value C and the profile cost C(v), the deviance
///
///     D(v) = 2 (C(v) - C)/dispersion
///
/// is compared with the quantile of chi2 with one degree of freedom (of F with 1 and nu, if the dispersion is
/// an estimate that rests on nu degrees of freedom): the interval is where D stays below. Unlike a standard
/// error it follows bends, and it shows when there is no upper or no lower limit at all.
///
/// Dispersion. 1 where residuals are divided by their true noise. 2 C/(n - p) where the noise is estimated
/// by the fit. For robust losses, or errors from the scatter between clusters: V h, with V the variance
/// claimed for the coefficient and h the curvature of C(v) at its minimum (one over the coefficient's entry
/// of the inverse information); near the minimum the interval is then the one V gives.
///
/// Assumed: C(v) is continuous, and what is found by `solve` is the least cost near the warm start. Steps
/// stop at the first crossing on each side: a second valley beyond is not seen.
///
/// Reference: Raue et al., Bioinformatics 25 (2009) 1923, section 2 (profiles, and the words for their
/// shapes).
///
///     const Profile p = profile({.name = "C_D", .best = 1.17, .best_cost = 12.5, .scale = 0.02,
///                                .lower = 0.5, .upper = 2.0}, warm_start, solve);
///     if (p.shape == ProfileShape::identified) use(*p.interval_lower, *p.interval_upper);
namespace samara::identification {

enum class ProfileShape {
  identified,       ///< the threshold is crossed on both sides
  lower_limit,      ///< one-sided: crossed below the optimum only, so the data give a lower limit
  upper_limit,      ///< one-sided: crossed above the optimum only
  flat,             ///< crossed on neither side
  better_elsewhere  ///< a lower cost was met on the way: the optimum was none, and there is no interval
};

/// "identified", "lower limit only", "upper limit only", "flat", "better elsewhere".
std::string to_string(ProfileShape shape);

/// Why the steps to one side ended.
enum class ProfileEnd {
  crossed,  ///< the threshold
  box,      ///< the end of the box, before the threshold
  flat,     ///< the steps were spent, before the threshold
  failed    ///< nothing could be solved farther out
};

/// "crossed", "box", "flat", "failed".
std::string to_string(ProfileEnd end);

/// What is profiled. Values in the unit of the coefficient.
struct ProfileTarget {
  std::string name = {};
  double best = 0.0;       ///< where the cost is least
  double best_cost = 0.0;  ///< there: 1/2 sum rho
  /// About a standard error, for the first step. Where there is none: not positive or not finite.
  double scale = std::numeric_limits<double>::quiet_NaN();
  double lower = -std::numeric_limits<double>::infinity();  ///< of its box
  double upper = std::numeric_limits<double>::infinity();
};

/// Everything else minimised at one value.
struct ProfileSolution {
  double cost = 0.0;
  Eigen::VectorXd point = {};  ///< of everything else, in whatever order the solver likes
};

/// Minimises over everything else with the coefficient held at `value`, starting from `warm_start` (the point
/// of the nearest solution). Empty if it fails.
using ProfileSolver =
    std::function<std::optional<ProfileSolution>(double value, const Eigen::VectorXd& warm_start)>;

struct ProfileOptions {
  double confidence = 0.95;  ///< of the interval, between 0 and 1
  double dispersion = 1.0;   ///< see above
  /// Of the dispersion: clusters - 1, or residuals - unknowns; infinite if it is known.
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  /// Solutions on each side, those that close in on the crossing included.
  int max_points = 30;
};

struct Profile {
  std::string name = {};
  ProfileShape shape = ProfileShape::flat;
  double best = 0.0;
  double best_cost = 0.0;
  double confidence = 0.95;
  double dispersion = 1.0;
  double degrees_of_freedom = std::numeric_limits<double>::infinity();
  double threshold = 0.0;  ///< the cost at which the interval ends
  /// Ends of the interval; empty where the threshold was not crossed, or for a better optimum elsewhere.
  std::optional<double> interval_lower = {};
  std::optional<double> interval_upper = {};
  ProfileEnd lower_end = ProfileEnd::flat;
  ProfileEnd upper_end = ProfileEnd::flat;
  /// The profile, ascending, the optimum included.
  std::vector<double> values = {};
  std::vector<double> costs = {};
  /// If better_elsewhere: where the least cost was met.
  std::optional<double> better_value = {};
  std::optional<double> better_cost = {};
  int solves = 0;  ///< failed ones included

  double deviance(double cost) const { return 2.0 * (cost - best_cost) / dispersion; }
};

/// @param warm_start the point of everything else at the optimum
/// @throws ArgumentError if the target is not finite or outside its box, or an option is outside its meaning;
///   and what `solve` throws.
Profile profile(const ProfileTarget& target, const Eigen::VectorXd& warm_start, const ProfileSolver& solve,
                const ProfileOptions& options = {});

/// What the profile says of its coefficient, in words: "0.512 to 0.531 (95 %)", "at least 0.83 (95 %)",
/// "not determined: anything from 0.1 to 4 fits (95 %)", each with "not explored beyond" where steps ended
/// before the threshold and the box; "better optimum at 0.7: cost 11.2 instead of 12.5".
std::string describe(const Profile& profile);

}  // namespace samara::identification
