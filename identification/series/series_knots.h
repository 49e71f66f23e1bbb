#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/problem/fit_options.h"
#include "samara/models/interface/model.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Coefficients that change in time as unknowns of a fit; internal to identification/.
namespace samara::identification {

/// Instants between which coefficients are straight lines.
struct SeriesKnots {
  Eigen::VectorXd instants;               ///< s, of the captures' times, increasing
  std::vector<std::string> coefficients;  ///< parameters of the model that follow them

  int count() const { return static_cast<int>(instants.size()); }
  /// "C_R@0.125": the coefficient at an instant, as a coordinate of the fit.
  std::string name(std::size_t coefficient, int knot) const;
};

/// The weights (row by row) of differences of neighbouring values, scaled such that they do not depend on how
/// instants are spaced, where the spacing is `unit`: for equal spacing c_(k+1) - c_k, or c_(k+1) - 2 c_k +
/// c_(k-1).
/// @param order 1 or 2
Eigen::MatrixXd difference_rows(const Eigen::VectorXd& instants, int order, double unit);

/// The trajectories of a model whose coefficients follow the knots: each has a coordinate for each instant,
/// with the box of the coefficient.
/// @param fixed, box as reference_trajectories(), the coefficients in the box
/// @param step as SolverOptions::step
std::unique_ptr<models::TrajectoryFamily> knot_trajectories(
    std::shared_ptr<const models::Model> model, const std::map<std::string, double>& fixed,
    const std::map<std::string, models::Interval>& box, std::optional<double> step, const SeriesKnots& knots);

}  // namespace samara::identification
