#pragma once

#include <vector>

#include "samara/codebooks/query/kernels/axis_weights.h"
#include "samara/codebooks/query/kernels/row_form.h"

namespace samara::codebooks::kernels {

/// A RowForm laid out for the kernels, in doubles or single floats. Immutable, safe to share between threads.
///
/// A core lies node by node, each node's matrix column by column, on borders of vectors: a point blends the
/// matrices of the nodes it touches in one pass, and multiplies them from the last to the first. Derivatives
/// are carried along as further columns, so that cores are read once.
template <class T>
class PackedField {
 public:
  explicit PackedField(const RowForm& form);

  int rows() const { return rows_; }
  int axis_count() const { return static_cast<int>(axes_.size()); }
  /// Ranks or terms between the rows and the first axis.
  int inner_size() const { return has_front_ ? front_rank_ : cores_.front().right; }
  const AxisWeights& axis(int k) const { return axes_[static_cast<std::size_t>(k)]; }

  /// Scratch space of one thread.
  struct Workspace {
    std::vector<AxisWeights::Workspace> axes;
    Buffer<T> weights[3];
    std::vector<Buffer<T>> blends;  ///< axis by axis: the value and its derivatives
    Buffer<T> columns[2];
    Buffer<T> block_weights, block_columns[2];
    std::vector<const T*> current;  ///< columns carried so far, see column_of_*
    std::vector<const T*> in;
    std::vector<T*> out;
    std::vector<double*> results;
  };
  Workspace make_workspace() const;

  /// Results of a point, in this order: values; for order 1 derivatives by each axis k; for order 2 second
  /// derivatives by axes j <= k, at column_of_second(j, k).
  /// @param columns of rows() numbers each
  void point(const double* x, int order, Workspace& workspace, double* const* columns) const;

  static int column_count(int axes, int order) {
    return 1 + (order > 0 ? axes : 0) + (order > 1 ? axes * (axes + 1) / 2 : 0);
  }
  static int column_of_first(int k) { return 1 + k; }
  int column_of_second(int j, int k) const { return 1 + axis_count() + k * (k + 1) / 2 + j; }

  /// Values of kBlock<T> points, all in one element of every axis.
  /// @param x axis by axis, the points running fastest  @param columns per point, rows() numbers each; null
  /// ones are left out
  void block(const double* x, Workspace& workspace, double* const* columns) const;

 private:
  /// Matrices of the nodes of an axis; of a sum, columns of its factors: left = rank, right = 1.
  struct Core {
    int left = 0;
    int right = 0;
    std::ptrdiff_t stride = 0;
    Buffer<T> data;
  };
  void add_core(int left, int right, int nodes, const auto& entry);
  void blend_axis(std::size_t k, double x, int order, Workspace& workspace) const;
  void value(const double* x, Workspace& workspace, double* values) const;
  void step(std::size_t k, int order, Workspace& workspace, double* const* results) const;

  int rows_ = 0;
  bool is_train_ = false;
  std::vector<AxisWeights> axes_;
  std::vector<Core> cores_;
  bool has_front_ = false;  ///< whether rows stand in front of the first core, or are its left side
  int front_rank_ = 0;
  std::ptrdiff_t front_lead_ = 0;
  Buffer<T> front_;
  int widest_ = 0;  ///< largest rank
  int most_nodes_ = 0;
};

extern template class PackedField<double>;
extern template class PackedField<float>;

}  // namespace samara::codebooks::kernels
