#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/identification/statistics/determined_inverse.h"

/// Internal to identification/: what the captures say of the shared unknowns, each capture's own eliminated.
namespace samara::identification {

/// Influence on the residuals over the whole box, relative to the spread of the measurements, squared: below
/// it there is none.
constexpr double kNoInfluence = 1e-14;

/// Which unknowns of a segment lie at a bound.
std::vector<char> own_at_bounds(const FitProblem& problem, const Eigen::VectorXd& own);

/// Directions of all segments of a motion whose unknowns are not at bounds.
std::vector<int> free_directions(const FitProblem& problem, const Motion& motion, const FitPoint& point);

/// Directions of all segments of a motion, and the information that their boxes give of those at a bound: as
/// if they were free, with the deviation of a uniform distribution over the box.
struct BoundedDirections {
  std::vector<int> all;
  Eigen::VectorXd information;
  bool any = false;  ///< at a bound
};
BoundedDirections bounded_directions(const FitProblem& problem, const Motion& motion, const FitPoint& point);

/// Indices of what is not at a bound.
std::vector<int> free_indices(const std::vector<char>& at_bound);

/// Sum of squares of what was measured, less the mean of each output, over the loss scales.
/// A compared attitude counts as a turn by one rad.
double spread(const FitProblem& problem, const Motion& motion);

/// Smallest diagonal of J^T J that counts as influence, per coordinate; none of what has no box.
Eigen::VectorXd influence_floor(const std::vector<models::FamilyCoordinate>& coordinates,
                                const std::vector<int>& free, double total_spread);

/// All residuals at a point, with derivatives.
/// @returns false where one or its derivative is not finite, as without a trajectory: failure_of() says which
bool evaluate_all(std::vector<SegmentResidual>& residuals, const FitPoint& point);

/// The equations of all segments of a motion, one below the other; own unknowns by the directions in which
/// they can move, segment after segment.
struct MotionEquations {
  Eigen::MatrixXd by_shared, by_own;
  Eigen::VectorXd residual;
  Eigen::VectorXd psi, dpsi;   ///< of priors and joins: the residual, and one
  Eigen::MatrixXd own_priors;  ///< J^T J of the priors' rows
  Eigen::VectorXd is_data;     ///< one for data, zero for priors and joins
  double psi_squares = 0.0;    ///< of data alone
  double dpsi_sum = 0.0;
};

/// @param residuals evaluated at `point`, with derivatives
MotionEquations motion_equations(const FitProblem& problem, const Motion& motion,
                                 const std::vector<SegmentResidual>& residuals, const FitPoint& point);

/// What one motion says, its own unknowns eliminated.
struct MotionTerms {
  std::vector<int> own_free;               ///< directions, over all segments
  DeterminedInverse own_inverse;           ///< of J_o^T J_o, what was known beforehand weighed by 1/slope
  Eigen::MatrixXd own_priors;              ///< of that, what was known: by priors, or from the box at a bound
  Eigen::MatrixXd projection;              ///< own_inverse J_o^T J_s
  Eigen::VectorXd shared_diagonal_before;  ///< of J_s^T J_s
  Eigen::MatrixXd normal;                  ///< J_s^T J_s without what the own unknowns explain
  Eigen::MatrixXd prior_part;              ///< of that, what own_priors add
  Eigen::MatrixXd hessian;                 ///< the same weighed by psi'
  Eigen::VectorXd score;                   ///< gradient of the cost
  bool hessian_usable = true;
  double psi_squares = 0.0;
  double own_unknowns = 0.0;  ///< how many the data determine: what priors and joins determine counts less
};

/// Of the mean of psi': below it all residuals are outliers, and there are no errors.
inline constexpr double kLeastSlope = 1e-12;

/// mean(psi') of data, their weight beside priors.
/// @param residuals evaluated
double mean_slope(const FitProblem& problem, const std::vector<SegmentResidual>& residuals);

/// What priors of shared unknowns, single ones and combinations, add to the cost, its gradient and its
/// Hessian.
struct PriorTerms {
  double cost = 0.0;
  Eigen::VectorXd gradient;
  Eigen::MatrixXd information;
};
PriorTerms prior_terms(const FitProblem& problem, const FitPoint& point);

/// @param residuals evaluated at `point`, with derivatives
/// @param slope mean_slope() of all of them
/// @param own free directions
/// @param own_information what else is known of them, on the diagonal of their information
MotionTerms motion_terms(const FitProblem& problem, const Motion& motion,
                         const std::vector<SegmentResidual>& residuals, const FitPoint& point, double slope,
                         const std::vector<int>& own, const Eigen::VectorXd& own_information = {});

}  // namespace samara::identification
