#include "samara/pgd/fields/separated_field.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/fields/field_check.h"

namespace samara::pgd {

SeparatedField::SeparatedField(std::vector<Axis> axes, std::vector<OutputLabel> outputs,
                               std::vector<Eigen::MatrixXd> factors, Eigen::MatrixXd weights)
    : axes_(std::move(axes)),
      outputs_(std::move(outputs)),
      factors_(std::move(factors)),
      weights_(std::move(weights)) {
  constexpr std::string_view kWhere = "a separated field";
  require(!axes_.empty(), "the number of axes", axes_.size(), "at least 1", kWhere);
  require(!outputs_.empty(), "the number of outputs", outputs_.size(), "at least 1", kWhere);
  require(factors_.size() == axes_.size(), "the number of factor matrices", factors_.size(),
          fmt::format("{}, one per axis,", axes_.size()), kWhere);
  require(weights_.rows() == static_cast<Eigen::Index>(outputs_.size()), "the number of rows of weights",
          weights_.rows(), fmt::format("{}, one per output,", outputs_.size()), kWhere);
  if (!weights_.allFinite()) throw ArgumentError("a weight of a separated field is not finite");
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const Eigen::MatrixXd& factor = factors_[k];
    if (factor.rows() != axes_[k].size() || factor.cols() != weights_.cols()) {
      throw ArgumentError(fmt::format("the factors of axis \"{}\" are {} x {}, expected {} x {}",
                                      axes_[k].name(), factor.rows(), factor.cols(), axes_[k].size(),
                                      weights_.cols()));
    }
    if (!factor.allFinite()) {
      throw ArgumentError(fmt::format("a factor of axis \"{}\" is not finite", axes_[k].name()));
    }
    const auto length_of = [&axis = axes_[k]](const Eigen::VectorXd& column) {
      return std::sqrt(column.dot(axis.mass() * column) / axis.measure());
    };
    for (Eigen::Index r = 0; r < factor.cols(); ++r) {
      double length = length_of(factor.col(r));
      if (!std::isfinite(length)) {  // squares of 1e154 and more
        const double largest = factor.col(r).cwiseAbs().maxCoeff();
        length = largest * length_of(factor.col(r) / largest);
      }
      // Factors that are normalised already stay as they are, to the last bit: fields survive a file
      // unchanged.
      if (length == 0.0 || std::abs(length - 1.0) < 1e-12) continue;
      factors_[k].col(r) /= length;
      weights_.col(r) *= length;
    }
  }
  if (!weights_.allFinite()) throw ArgumentError("a term of a separated field is not finite");
}

SeparatedField::Workspace SeparatedField::make_workspace() const {
  Workspace workspace;
  for (const Axis& axis : axes_) workspace.stencils.push_back(axis.make_stencil());
  workspace.values.resize(rank(), axis_count());
  workspace.derivatives.resize(rank(), axis_count());
  workspace.product.resize(rank());
  workspace.suffix.resize(rank());
  return workspace;
}

void SeparatedField::factor_values(int axis, double x, InterpolationStencil& stencil,
                                   Eigen::Ref<Eigen::VectorXd> values) const {
  const auto k = static_cast<std::size_t>(axis);
  axes_[k].interpolate(x, stencil, false);
  values.noalias() = factors_[k].middleRows(stencil.first, stencil.value.size()).transpose() * stencil.value;
}

void SeparatedField::factor_values(int axis, double x, InterpolationStencil& stencil,
                                   Eigen::Ref<Eigen::VectorXd> values,
                                   Eigen::Ref<Eigen::VectorXd> derivatives) const {
  const auto k = static_cast<std::size_t>(axis);
  axes_[k].interpolate(x, stencil, true);
  const auto rows = factors_[k].middleRows(stencil.first, stencil.value.size());
  values.noalias() = rows.transpose() * stencil.value;
  derivatives.noalias() = rows.transpose() * stencil.derivative;
}

void SeparatedField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                              Workspace& workspace) const {
  require_inside(axes_, x);
  workspace.product.setOnes();
  for (int k = 0; k < axis_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    factor_values(k, x[i], workspace.stencils[i], workspace.values.col(k));
    workspace.product.array() *= workspace.values.col(k).array();
  }
  values.noalias() = weights_ * workspace.product;
}

void SeparatedField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                              Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const {
  require_inside(axes_, x);
  for (int k = 0; k < axis_count(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    factor_values(k, x[i], workspace.stencils[i], workspace.values.col(k), workspace.derivatives.col(k));
  }
  // Products of all axes but k: those before k accumulate from the left in `derivatives`, those after from
  // the right.
  workspace.product.setOnes();
  for (int k = 0; k < axis_count(); ++k) {
    workspace.derivatives.col(k).array() *= workspace.product.array();
    workspace.product.array() *= workspace.values.col(k).array();
  }
  workspace.suffix.setOnes();
  for (int k = axis_count() - 1; k >= 0; --k) {
    workspace.derivatives.col(k).array() *= workspace.suffix.array();
    workspace.suffix.array() *= workspace.values.col(k).array();
  }
  values.noalias() = weights_ * workspace.product;
  gradient.noalias() = weights_ * workspace.derivatives;
}

Eigen::VectorXd SeparatedField::operator()(std::span<const double> x) const {
  Workspace workspace = make_workspace();
  Eigen::VectorXd values(output_count());
  evaluate(x, values, workspace);
  return values;
}

}  // namespace samara::pgd
