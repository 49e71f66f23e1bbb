#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/sampling/sample_table.h"
#include "samara/pgd/tensors/random.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

/// Cross interpolation on a grid that grows: nodes and pivots are added, never taken away.
///
/// Modes are numbered 0 (the outputs), 1 .. d (the coordinates, on Leja nodes). Bond b lies between modes b
/// and b+1 and has as many rows (an output and nodes of coordinates 1 .. b) as columns (nodes of coordinates
/// b+1 .. d): its pivots. With T_k the values at (rows of bond k-1) x mode k x (columns of bond k) and P_b
/// those at rows x columns of bond b, the function is interpolated by T_0 P_0^-1 T_1 P_1^-1 .. T_d.
///
/// Of one coordinate, and of two where the crosses have called most nodes anyway, all nodes are called: then the
/// interpolant is exact at them, and no pivots are searched.
class GrowingCross {
 public:
  /// Starts with one pivot, the largest value of a few random nodes. @param nodes per coordinate, at least 1
  /// @throws SamplingStopped
  GrowingCross(SampleTable& table, std::vector<int> nodes, int max_rank, std::uint64_t seed);

  /// Adds pivots until the search finds no error above `tolerance` (over the scale of the outputs) at any
  /// bond, or the function has been called more often than `max_calls` in all. @throws SamplingStopped
  void grow(double tolerance, long max_calls);

  /// Makes a grid point (Leja numbers of all coordinates) a pivot of every bond that errs there by more than
  /// `tolerance`. @returns how many bonds took it. @throws SamplingStopped
  int add_pivot(const Eigen::VectorXi& point, double tolerance);

  bool has_whole_grid() const { return has_whole_grid_; }

  void set_nodes(int coordinate, int count) { nodes_[static_cast<std::size_t>(coordinate)] = count; }
  const std::vector<int>& nodes() const { return nodes_; }
  /// Of the crosses; of the whole grid, those of the last train.
  std::vector<int> ranks() const;
  bool ranks_are_exhausted() const { return exhausted_; }

  /// The interpolant on the outputs and the Leja nodes. @throws SamplingStopped
  TensorTrain train();

  /// Points of the pivots of all bonds, coordinates x points.
  Eigen::MatrixXd pivots() const;

 private:
  struct Bond {
    IndexBatch rows;  ///< output, then nodes of the coordinates before: (1 + b) x rank
    IndexBatch cols;  ///< nodes of the coordinates after: (d - b) x rank
  };
  /// Rows and columns of one bond between which values are wanted.
  struct Block {
    IndexBatch rows, cols;
  };
  /// A search for a pivot: the candidates of a bond, the interpolant there (left x right), where it is.
  struct Search {
    int bond = 0;
    IndexBatch rows, cols;
    Eigen::MatrixXd left = {}, right = {};
    Eigen::Index row = 0, col = 0;
    double error = 0.0;  ///< at row and column
  };
  int coordinates() const { return static_cast<int>(nodes_.size()); }
  int bonds() const { return coordinates(); }
  IndexBatch candidate_rows(int bond) const;
  IndexBatch candidate_cols(int bond) const;
  IndexBatch points_of(const Block& block) const;
  /// Rows x columns of every block, over the scale of the row's output: all that is missing in one batch.
  std::vector<Eigen::MatrixXd> values(const std::vector<Block>& blocks);
  /// All bonds are searched side by side, so that a batch has the points of all.
  std::vector<Search> searches();
  void look_along_rows(std::vector<Search>& searches);
  bool grow_once(double tolerance);
  bool has_called_most() const;
  IndexBatch all_nodes() const;
  TensorTrain train_of_grid();
  void append(Bond& bond, const Eigen::VectorXi& row, const Eigen::VectorXi& col);

  SampleTable& table_;
  std::vector<int> nodes_;
  int max_rank_;
  Random random_;
  std::vector<Bond> bonds_;
  bool exhausted_ = false;
  bool has_whole_grid_ = false;
  double tolerance_ = 0.0;       ///< of the last growth
  std::vector<int> grid_ranks_;  ///< of the last train of the whole grid
};

}  // namespace samara::pgd
