#include "samara/pgd/fields/field_algebra.h"

#include <cmath>
#include <utility>

#include <Eigen/SparseCholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/unit_labels.h"
#include "samara/pgd/fields/field_check.h"
#include "samara/pgd/tensors/compression.h"
#include "samara/pgd/tensors/tensor_algebra.h"
#include "samara/pgd/tensors/tensor_train.h"

namespace samara::pgd {

namespace {

double volume(const SeparatedField& f) {
  double product = 1.0;
  for (const Axis& axis : f.axes()) product *= axis.measure();
  return product;
}

/// L^T of the axis' mass matrix L L^T: Euclidean lengths after it are lengths in L2.
class RootMass {
 public:
  explicit RootMass(const Axis& axis) : cholesky_(axis.mass()) {}
  Eigen::MatrixXd apply(const Eigen::MatrixXd& factor) const { return cholesky_.matrixU() * factor; }
  Eigen::MatrixXd undo(const Eigen::MatrixXd& factor) const { return cholesky_.matrixU().solve(factor); }

 private:
  Eigen::SimplicialLLT<SparseMatrix, Eigen::Lower, Eigen::NaturalOrdering<int>> cholesky_;
};

/// Nodal values with Euclidean lengths that are those in L2; mode 0 is left as it is.
SeparatedTensor in_l2(SeparatedTensor values, const std::vector<Axis>& axes) {
  for (std::size_t k = 0; k < axes.size(); ++k) {
    values.factors[k + 1] = RootMass(axes[k]).apply(values.factors[k + 1]);
  }
  return values;
}

/// Norm of one output of a tensor as in_l2() gives it.
double output_norm(const SeparatedTensor& tensor, int output) {
  return norm(restricted(tensor, 0, output));
}

/// The field without an axis whose factors were reduced to one number per term.
SeparatedField without_axis(const SeparatedField& f, int axis, const Eigen::VectorXd& values,
                            std::vector<OutputLabel> outputs) {
  require_another_axis(f.axes());
  std::vector<Axis> axes = f.axes();
  std::vector<Eigen::MatrixXd> factors = f.factors();
  axes.erase(axes.begin() + axis);
  factors.erase(factors.begin() + axis);
  return {std::move(axes), std::move(outputs), std::move(factors), f.weights() * values.asDiagonal()};
}

}  // namespace

int axis_index(const SeparatedField& field, const std::string& axis) {
  return axis_index(field.axes(), axis);
}

SeparatedTensor nodal_values(const SeparatedField& field) {
  SeparatedTensor values;
  values.weights = Eigen::VectorXd::Ones(field.rank());
  values.factors.push_back(field.weights());
  for (const Eigen::MatrixXd& factor : field.factors()) values.factors.push_back(factor);
  return values;
}

SeparatedField field_from_nodal_values(std::vector<Axis> axes, std::vector<OutputLabel> outputs,
                                       const SeparatedTensor& values) {
  if (values.modes() < 1) throw ArgumentError("nodal values without modes, expected outputs and axes");
  std::vector<Eigen::MatrixXd> factors(values.factors.begin() + 1, values.factors.end());
  return {std::move(axes), std::move(outputs), std::move(factors),
          values.factors.front() * values.weights.asDiagonal()};
}

SeparatedField sum(const SeparatedField& f, const SeparatedField& g, double scale_g) {
  require_same_axes("sum", f.axes(), g.axes());
  require_same_outputs("sum", f.outputs(), g.outputs());
  return field_from_nodal_values(f.axes(), f.outputs(), sum(nodal_values(f), nodal_values(g), scale_g));
}

SeparatedField scaled(const SeparatedField& f, double factor) {
  return {f.axes(), f.outputs(), f.factors(), factor * f.weights()};
}

Eigen::VectorXd l2_inner(const SeparatedField& f, const SeparatedField& g) {
  require_same_axes("inner product", f.axes(), g.axes());
  require_same_outputs("inner product", f.outputs(), g.outputs());
  Eigen::MatrixXd products = Eigen::MatrixXd::Ones(f.rank(), g.rank());
  for (std::size_t k = 0; k < f.axes().size(); ++k) {
    products.array() *= (f.factors()[k].transpose() * (f.axes()[k].mass() * g.factors()[k])).array();
  }
  return (f.weights() * products).cwiseProduct(g.weights()).rowwise().sum();
}

Eigen::VectorXd l2_norm(const SeparatedField& f) {
  const SeparatedTensor tensor = in_l2(nodal_values(f), f.axes());
  return Eigen::VectorXd::NullaryExpr(
      f.output_count(), [&](Eigen::Index m) { return output_norm(tensor, static_cast<int>(m)); });
}

Eigen::VectorXd root_mean_square(const SeparatedField& f) {
  return l2_norm(f) / std::sqrt(volume(f));
}

SeparatedField restricted(const SeparatedField& f, const std::string& axis, double x) {
  const int k = axis_index(f, axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  require_on_axis(gone, x);
  InterpolationStencil stencil = gone.make_stencil();
  Eigen::VectorXd values(f.rank());
  f.factor_values(k, x, stencil, values);
  return without_axis(f, k, values, f.outputs());
}

SeparatedField integral(const SeparatedField& f, const std::string& axis) {
  const int k = axis_index(f, axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  std::vector<OutputLabel> outputs = f.outputs();
  for (OutputLabel& output : outputs) output.unit = unit_product(output.unit, gone.unit());
  return without_axis(f, k, f.factors()[static_cast<std::size_t>(k)].transpose() * gone.weights(),
                      std::move(outputs));
}

SeparatedField mean(const SeparatedField& f, const std::string& axis) {
  const int k = axis_index(f, axis);
  const Axis& gone = f.axes()[static_cast<std::size_t>(k)];
  return without_axis(f, k,
                      f.factors()[static_cast<std::size_t>(k)].transpose() * gone.weights() / gone.measure(),
                      f.outputs());
}

SeparatedField derivative(const SeparatedField& f, const std::string& axis) {
  const auto k = static_cast<std::size_t>(axis_index(f, axis));
  std::vector<OutputLabel> outputs = f.outputs();
  for (OutputLabel& output : outputs) output.unit = unit_quotient(output.unit, f.axes()[k].unit());
  std::vector<Eigen::MatrixXd> factors = f.factors();
  factors[k] = f.axes()[k].derivative() * f.factors()[k];
  return {f.axes(), std::move(outputs), std::move(factors), f.weights()};
}

FieldCompression compress(const SeparatedField& f, double tolerance) {
  require(tolerance > 0.0, "tolerance", tolerance, "more than 0", "compress");
  // Every output divided by its norm: the error of all together bounds that of each one.
  const Eigen::VectorXd sizes = l2_norm(f);
  const Eigen::VectorXd divisors = (sizes.array() > 0.0).select(sizes, 1.0);
  SeparatedTensor target = in_l2(nodal_values(f), f.axes());
  target.factors[0] = divisors.cwiseInverse().asDiagonal() * target.factors[0];
  SeparatedTensor shorter = compress(target, tolerance).tensor;
  const SeparatedTensor difference = sum(shorter, target, -1.0);
  const Eigen::VectorXd error = Eigen::VectorXd::NullaryExpr(
      f.output_count(), [&](Eigen::Index m) { return output_norm(difference, static_cast<int>(m)); });
  // An output that is zero stays zero, whatever round-off the fit left there.
  shorter.factors[0] = sizes.asDiagonal() * shorter.factors[0];
  for (std::size_t k = 0; k < f.axes().size(); ++k) {
    shorter.factors[k + 1] = RootMass(f.axes()[k]).undo(shorter.factors[k + 1]);
  }
  return {field_from_nodal_values(f.axes(), f.outputs(), shorter), error, error.maxCoeff() <= tolerance};
}

}  // namespace samara::pgd
