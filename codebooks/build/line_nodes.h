#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/separated_field.h"

namespace samara::codebooks {

/// Where a line through the box needs more nodes than are allowed.
struct Front {
  Eigen::Index coordinate = 0;
  Eigen::VectorXd point;  ///< of the box, in the middle of the steepest change
  Eigen::Index row = 0;   ///< which of the values changes there
  double width = 0.0;     ///< of the coordinate: the range of the value over the line, by the steepest slope
  int allowed = 0;        ///< nodes
  double error = 0.0;     ///< of the interpolation by these, along the worst of the lines
  int nodes = 0;          ///< that the value needs on this line; 0: more than were tried
};

/// In a sentence. @param outputs states of the rows, of which times follow the states
std::string described(const Front& front, const std::vector<pgd::Axis::Label>& coordinates,
                      const std::vector<pgd::OutputLabel>& outputs, const std::vector<double>& times,
                      const std::string& time_unit);

/// From values at `count` Chebyshev-Lobatto points, cos(pi j / (count - 1)), to coefficients: rows are coefficients.
Eigen::MatrixXd chebyshev_transform(int count);

/// How many nodes the coordinates of a box need, by the decay of Chebyshev coefficients along lines through it.
class LineNodes {
 public:
  /// The values that are to be interpolated, over their scales: a column per point of the box.
  using Values = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& points)>;
  using AxisOf = std::function<pgd::Axis(Eigen::Index coordinate, int nodes)>;

  static constexpr int kMostLine = 129;             ///< nodes of a line
  static constexpr int kMostNodes = kMostLine - 1;  ///< of a polynomial: lines must show that it takes more
  static constexpr int kMostFront = 1025;           ///< nodes of a line with a front

  /// @param max_nodes at most kMostNodes
  LineNodes(Eigen::Index coordinates, AxisOf axis_of, Values values, int max_nodes);

  /// May be called again: what all looks have seen counts.
  /// @param bases points that the lines go through, a multiple of 8
  /// @param bound which nodes have to be told apart: what is left after the last ones
  /// @param tolerance a line that errs by more with as many nodes as are allowed is a front
  void look_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases, double bound, double tolerance);

  /// Per coordinate the fewest nodes after which less than `bound` is left along all lines; of one in elements, all of
  /// its nodes.
  std::vector<int> within(double bound) const;
  /// Whether as many as are allowed leave more.
  bool needs_more(Eigen::Index coordinate, double bound) const;

  /// Has a coordinate in elements instead (line_elements.h), which follow its fronts; or in more of them, halves of
  /// those before. One that has elements need not be looked along.
  void set_elements(Eigen::Index coordinate, pgd::Axis axis);
  /// The last that were set; null where one polynomial is to do.
  const pgd::Axis* elements(Eigen::Index coordinate) const;
  bool has_elements() const;
  /// Elements that were set and have so many nodes, or else a polynomial.
  pgd::Axis axis(Eigen::Index coordinate, int nodes) const;

  /// The worst, of coordinates that are not in elements; null if there is none: no cross over such nodes can meet the
  /// tolerance.
  const Front* front() const;

 private:
  Eigen::VectorXd nodes_of(Eigen::Index coordinate, int count) const;
  Eigen::MatrixXd lines(Eigen::Index coordinate, const Eigen::MatrixXd& bases, int count) const;
  Eigen::VectorXd tail_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases, int count) const;
  std::optional<Front> front_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases,
                                   double tolerance) const;

  AxisOf axis_of_;
  Values values_;
  int max_nodes_;
  /// Per coordinate, what the coefficients from each number on sum to: the error of so many nodes, along the worst of
  /// the lines.
  std::vector<Eigen::VectorXd> tails_;
  std::vector<std::optional<Front>> fronts_;
  std::vector<std::vector<pgd::Axis>> elements_;  ///< per coordinate, fewest first
};

}  // namespace samara::codebooks
