#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace samara::codebooks {

/// States at times, between which those of all others are interpolated, over any point of the box.
struct Skeleton {
  std::vector<int> rows;             ///< of a trajectory: states fastest, then times
  Eigen::MatrixXd coefficients;      ///< (states x times) x rows
  std::vector<double> times;         ///< those that occur
  std::vector<Eigen::Index> places;  ///< of the rows in trajectories at these times
  Eigen::VectorXd scale;             ///< of the rows
};

/// Chosen by volume from some trajectories, more of them while many of their columns are independent.
/// @param some so many trajectories at the times, a column each, states fastest, over their scales
/// @param scale per state  @param fewest trajectories
/// @param bound what interpolation may leave of a state at a time, of these trajectories
Skeleton find_skeleton(const std::function<Eigen::MatrixXd(int count)>& some,
                       const std::vector<double>& times, const Eigen::VectorXd& scale, int fewest,
                       int max_rows, double bound);

}  // namespace samara::codebooks
