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
  int nodes = 0;          ///< that this line needs for the tolerance; 0: more than were tried
};

/// In a sentence. @param outputs states of the rows, of which times follow the states
std::string described(const Front& front, const std::vector<pgd::Axis::Label>& coordinates,
                      const std::vector<pgd::OutputLabel>& outputs, const std::vector<double>& times,
                      const std::string& time_unit);

/// How many nodes the coordinates of a box need, by the decay of Chebyshev coefficients along lines through it.
class LineNodes {
 public:
  /// The values that are to be interpolated, over their scales: a column per point of the box.
  using Values = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& points)>;
  using AxisOf = std::function<pgd::Axis(Eigen::Index coordinate, int nodes)>;

  static constexpr int kMostLine = 129;    ///< nodes of a line
  static constexpr int kMostFront = 1025;  ///< nodes of a line with a front

  /// @param max_nodes at most kMostLine
  LineNodes(AxisOf axis_of, Values values, int max_nodes);

  /// To be called for the coordinates in their order. @param bases points that the lines go through, a multiple of 8
  /// @param bound which nodes have to be told apart: what is left behind the last ones
  /// @param tolerance a line that errs by more with as many nodes as are allowed is a front
  void look_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases, double bound, double tolerance);

  /// Per coordinate the fewest nodes behind which less than `bound` is left along all lines.
  std::vector<int> within(double bound) const;

  /// The worst, if there is one: no cross over such nodes can meet the tolerance.
  const std::optional<Front>& front() const { return front_; }

 private:
  Eigen::MatrixXd lines(Eigen::Index coordinate, const Eigen::MatrixXd& bases, int count) const;
  Eigen::VectorXd tail_along(Eigen::Index coordinate, const Eigen::MatrixXd& bases, int count) const;
  void find_front(Eigen::Index coordinate, const Eigen::MatrixXd& bases, double tolerance);

  AxisOf axis_of_;
  Values values_;
  int max_nodes_;
  /// Per coordinate, what the coefficients from each number on sum to: the error of so many nodes, along the worst of
  /// the lines.
  std::vector<Eigen::VectorXd> tails_;
  std::optional<Front> front_;
};

}  // namespace samara::codebooks
