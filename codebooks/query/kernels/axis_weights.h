#pragma once

#include <vector>

#include "samara/codebooks/query/kernels/buffer.h"
#include "samara/pgd/axes/axis.h"

namespace samara::codebooks::kernels {

/// Interpolation on one axis, as pgd::Axis defines it, ready for kernels: weights at a point with first and
/// second derivatives, and weights at a block of points. Immutable, safe to share between threads.
class AxisWeights {
 public:
  explicit AxisWeights(pgd::Axis axis);

  const pgd::Axis& axis() const { return axis_; }
  /// Nodes that a point touches.
  int size() const { return size_; }

  /// Number of the element that holds x, or, on a list of values, of the node: points with one number touch
  /// the same nodes.
  int cell(double x) const;

  /// Scratch space of one thread.
  struct Workspace {
    pgd::InterpolationStencil stencil;
    Buffer<double> weights[3];  ///< of the value, of its first and second derivative
    Buffer<double> places;
  };
  Workspace make_workspace() const;

  /// Fills `order` + 1 lists of weights. @param order 0 to 2  @returns the first node they are for
  int at(double x, int order, Workspace& workspace) const;

  /// Weights of kBlock<T> points of one element.
  /// @param weights size() x kBlock<T>, the points running fastest  @returns the first node
  template <class T>
  int block(int cell, const double* x, Workspace& workspace, T* weights) const;

 private:
  double place(int element, double x) const;

  pgd::Axis axis_;
  int size_ = 0;
  /// By products of differences: elements of not too many nodes. Other axes interpolate by themselves.
  bool by_products_ = false;
  bool has_elements_ = false;
  pgd::Transform transform_ = pgd::Transform::none;
  std::vector<double> nodes_, lambda_;           ///< of the element on [-1, 1]
  std::vector<double> left_, right_, distance_;  ///< per element: its borders, and its length in s
  std::ptrdiff_t lead_ = 0;
  Buffer<double> slopes_;  ///< transposed differentiation matrix, leading dimension lead_; where there is one
};

}  // namespace samara::codebooks::kernels
