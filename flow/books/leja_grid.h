#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"

namespace samara::flow {

/// Columns of numbers at the nodes of a grid in [-1, 1]^d, whose coordinates are Leja points (pgd/sampling/leja.h): it
/// grows by single points along a coordinate, and keeps what it has.
class LejaGrid {
 public:
  /// Number of the point 0 among Leja's, and the most points along a coordinate.
  static constexpr int kMiddle = 2, kMost = 33;

  /// Three points along each coordinate.
  explicit LejaGrid(std::size_t coordinates) : counts_(coordinates, 3) {}

  const std::vector<int>& counts() const { return counts_; }
  void set_counts(std::vector<int> counts) { counts_ = std::move(counts); }
  long size() const;

  /// A node is named by the numbers of its Leja points.
  std::vector<double> unit_of(const std::vector<int>& numbers) const;
  bool has(const std::vector<int>& numbers) const { return columns_.contains(numbers); }
  void put(const std::vector<int>& numbers, Eigen::VectorXd column) { columns_[numbers] = std::move(column); }
  const Eigen::VectorXd& column(const std::vector<int>& numbers) const { return columns_.at(numbers); }
  /// All that there are, also beyond the grid.
  const std::map<std::vector<int>, Eigen::VectorXd>& columns() const { return columns_; }

  /// The next node along a coordinate, in the middle of the others.
  std::vector<int> next_along(std::size_t coordinate) const;

  /// Nodes of a grid of that many points that have no column.
  long missing(const std::vector<int>& counts) const;
  void for_missing(const std::function<void(const std::vector<int>& numbers)>& act) const;

  /// The interpolating polynomial of the grid, whose columns are all there.
  Eigen::VectorXd at(const std::vector<double>& unit) const;
  /// The same on as many Chebyshev-Lobatto points along every coordinate, the first running fastest.
  Eigen::MatrixXd on_chebyshev_points() const;

 private:
  std::vector<int> counts_;
  std::map<std::vector<int>, Eigen::VectorXd> columns_;
};

/// Of a book's tolerance: what a flow that is foretold may differ by.
inline constexpr double kForetold = 0.5;

/// How a grid has grown.
struct GridGrowth {
  Termination status = Termination::converged;  ///< or max_calls, exhausted
  long solved = 0;                              ///< columns
  double worst = 0.0;  ///< of the last round, what the next nodes differ by from what the grid foretells

  /// Grid and growth in words. @param most columns that were allowed
  std::string text(const LejaGrid& grid, long most) const;
};

/// Solves columns on the grid, and makes it grow along each coordinate as long as the next node along it differs by
/// more than `allowed` from what the grid foretells.
/// @param solve the column at a place in [-1, 1]^d  @param apart how much two columns differ
/// @param most columns that may be solved: no grid is begun that needs more
GridGrowth grow(LejaGrid& grid, const std::function<Eigen::VectorXd(const std::vector<double>& unit)>& solve,
                const std::function<double(const Eigen::VectorXd&, const Eigen::VectorXd&)>& apart,
                double allowed, long most);

/// In an interval, from its place in [-1, 1].
double in_interval(double lower, double upper, double unit);

}  // namespace samara::flow
