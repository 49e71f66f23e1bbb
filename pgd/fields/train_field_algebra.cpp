#include "samara/pgd/fields/train_field_algebra.h"

#include <utility>

#include "samara/base/unit_labels.h"
#include "samara/pgd/fields/field_check.h"
#include "samara/pgd/tensors/train_algebra.h"

namespace samara::pgd {

namespace {

/// The field without an axis over which it was summed with these weights of its nodes.
TrainField summed_over(const TrainField& f, int axis, const Eigen::VectorXd& weights,
                       std::vector<OutputLabel> outputs) {
  require_another_axis(f.axes());
  std::vector<Axis> axes = f.axes();
  axes.erase(axes.begin() + axis);
  return {std::move(axes), std::move(outputs), contracted(f.train(), axis + 1, weights)};
}

}  // namespace

TrainField sum(const TrainField& f, const TrainField& g, double scale_g) {
  require_same_axes("sum", f.axes(), g.axes());
  require_same_outputs("sum", f.outputs(), g.outputs());
  return {f.axes(), f.outputs(), sum(f.train(), g.train(), scale_g)};
}

TrainField scaled(const TrainField& f, double factor) {
  return {f.axes(), f.outputs(), scaled(f.train(), factor)};
}

TrainField restricted(const TrainField& f, const std::string& axis, double x) {
  const int k = axis_index(f.axes(), axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  require_on_axis(gone, x);
  InterpolationStencil stencil = gone.make_stencil();
  gone.interpolate(x, stencil, false);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(gone.size());
  weights.segment(stencil.first, stencil.value.size()) = stencil.value;
  return summed_over(f, k, weights, f.outputs());
}

TrainField integral(const TrainField& f, const std::string& axis) {
  const int k = axis_index(f.axes(), axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  std::vector<OutputLabel> outputs = f.outputs();
  for (OutputLabel& output : outputs) output.unit = unit_product(output.unit, gone.unit());
  return summed_over(f, k, gone.weights(), std::move(outputs));
}

TrainField mean(const TrainField& f, const std::string& axis) {
  const int k = axis_index(f.axes(), axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  return summed_over(f, k, gone.weights() / gone.measure(), f.outputs());
}

TrainField derivative(const TrainField& f, const std::string& axis) {
  const int k = axis_index(f.axes(), axis);
  const Axis& by = f.axes()[static_cast<std::size_t>(k)];
  std::vector<OutputLabel> outputs = f.outputs();
  for (OutputLabel& output : outputs) output.unit = unit_quotient(output.unit, by.unit());
  return {f.axes(), std::move(outputs), applied(f.train(), k + 1, by.derivative())};
}

}  // namespace samara::pgd
