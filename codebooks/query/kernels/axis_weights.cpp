#include "samara/codebooks/query/kernels/axis_weights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::codebooks::kernels {

namespace {

/// Products of more differences may leave the range of doubles.
constexpr int kMostProducts = 64;

/// d2T/dx2
double transform_bend(pgd::Transform transform, double x) {
  switch (transform) {
    case pgd::Transform::logarithm:
      return -1.0 / (x * x);
    case pgd::Transform::reciprocal:
      return -2.0 / (x * x * x);
    case pgd::Transform::square_root:
      return -0.25 / (x * std::sqrt(x));
    case pgd::Transform::none:
      break;
  }
  return 0.0;
}

}  // namespace

AxisWeights::AxisWeights(pgd::Axis axis) : axis_(std::move(axis)), size_(axis_.stencil_size()) {
  has_elements_ = axis_.has_elements();
  transform_ = axis_.transform();
  by_products_ = has_elements_ && size_ <= kMostProducts;
  Eigen::MatrixXd slopes;
  if (axis_.has_elements()) {
    slopes = axis_.element_basis().differentiation();
    for (Eigen::Index e = 0; e + 1 < axis_.borders().size(); ++e) {
      left_.push_back(axis_.borders()[e]);
      right_.push_back(axis_.borders()[e + 1]);
      distance_.push_back(
          pgd::transformed_distance(axis_.transform(), axis_.borders()[e], axis_.borders()[e + 1]));
    }
  } else if (axis_.family() == pgd::AxisFamily::periodic) {
    slopes = Eigen::MatrixXd(axis_.derivative());
  }
  lead_ = padded<double>(size_);
  slopes_ = Buffer<double>(slopes.rows() * lead_);
  for (Eigen::Index i = 0; i < slopes.rows(); ++i)
    for (Eigen::Index j = 0; j < slopes.cols(); ++j) slopes_.data()[i * lead_ + j] = slopes(i, j);
  if (!by_products_) return;
  const Eigen::VectorXd& nodes = axis_.element_basis().nodes();
  nodes_.assign(nodes.begin(), nodes.end());
  for (std::size_t j = 0; j < nodes_.size(); ++j) {
    double product = 1.0;
    for (std::size_t k = 0; k < nodes_.size(); ++k)
      if (k != j) product /= 2.0 * (nodes_[j] - nodes_[k]);
    lambda_.push_back(product);
  }
  lambda_.resize(static_cast<std::size_t>(padded<double>(size_)), 0.0);
}

int AxisWeights::cell(double x) const {
  if (has_elements_) {
    // The element on the left at a border, as Axis::element_of.
    return static_cast<int>(std::lower_bound(left_.begin() + 1, left_.end(), x) - left_.begin()) - 1;
  }
  if (axis_.family() == pgd::AxisFamily::periodic) return 0;
  const Eigen::VectorXd& nodes = axis_.nodes();
  return static_cast<int>(std::lower_bound(nodes.begin(), nodes.end(), x) - nodes.begin());
}

AxisWeights::Workspace AxisWeights::make_workspace() const {
  Workspace workspace;
  workspace.stencil = axis_.make_stencil();
  for (Buffer<double>& weights : workspace.weights) weights = Buffer<double>(size_);
  workspace.places = Buffer<double>(kBlock<float>);
  return workspace;
}

double AxisWeights::place(int element, double x) const {
  const auto e = static_cast<std::size_t>(element);
  const double right = right_[e];
  if (transform_ == pgd::Transform::none) return ((x - left_[e]) - (right - x)) / distance_[e];
  return (pgd::transformed_distance(transform_, left_[e], x) -
          pgd::transformed_distance(transform_, x, right)) /
         distance_[e];
}

int AxisWeights::at(double x, int order, Workspace& workspace) const {
  double* const value = workspace.weights[0].data();
  double* const first = workspace.weights[1].data();
  double* const second = workspace.weights[2].data();
  const auto differentiate = [&](const double* from, double* to) {
    // Whole vectors: buffers have room for them.
    multiply<double, double>(slopes_.data(), lead_, lead_, size_, &from, 1, &to);
  };
  if (!has_elements_) {
    axis_.interpolate(x, workspace.stencil, order > 0);
    std::copy(workspace.stencil.value.begin(), workspace.stencil.value.end(), value);
    if (order > 0) std::copy(workspace.stencil.derivative.begin(), workspace.stencil.derivative.end(), first);
    if (order > 1 && axis_.family() == pgd::AxisFamily::periodic) {
      differentiate(first, second);
    } else if (order > 1) {
      std::fill_n(second, size_, std::numeric_limits<double>::quiet_NaN());
    }
    return workspace.stencil.first;
  }
  const int element = distance_.size() == 1 ? 0 : cell(x);
  const double at = place(element, x);
  if (by_products_) {
    lagrange(nodes_.data(), lambda_.data(), size_, at, value);
  } else {
    axis_.element_basis().values(at, workspace.stencil.value);
    std::copy(workspace.stencil.value.begin(), workspace.stencil.value.end(), value);
  }
  if (order > 0) {
    differentiate(value, first);
    const double per_s = 2.0 / distance_[static_cast<std::size_t>(element)];
    const double slope =
        transform_ == pgd::Transform::none ? per_s : per_s * pgd::transform_slope(transform_, x);
    if (order > 1) {
      differentiate(first, second);
      const double bend = per_s * transform_bend(transform_, x);
      for (int j = 0; j < size_; ++j) second[j] = slope * slope * second[j] + bend * first[j];
    }
    for (int j = 0; j < size_; ++j) first[j] *= slope;
  }
  return element * (size_ - 1);
}

template <class T>
int AxisWeights::block(int cell, const double* x, Workspace& workspace, T* weights) const {
  if (by_products_) {
    for (int p = 0; p < kBlock<T>; ++p) workspace.places.data()[p] = place(cell, x[p]);
    lagrange_block(nodes_.data(), lambda_.data(), size_, workspace.places.data(), weights);
    return cell * (size_ - 1);
  }
  int first = 0;
  for (int p = 0; p < kBlock<T>; ++p) {
    first = at(x[p], 0, workspace);
    for (int j = 0; j < size_; ++j)
      weights[j * kBlock<T> + p] = static_cast<T>(workspace.weights[0].data()[j]);
  }
  return first;
}

template int AxisWeights::block(int, const double*, Workspace&, double*) const;
template int AxisWeights::block(int, const double*, Workspace&, float*) const;

}  // namespace samara::codebooks::kernels
