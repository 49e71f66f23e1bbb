#include "samara/pgd/fields/train_field.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/fields/field_check.h"

namespace samara::pgd {

namespace {

/// sum_i weight_i slice(first + i), left x right.
void interpolate_slices(const TrainCore& core, int first, const Eigen::VectorXd& weights,
                        Eigen::Ref<Eigen::MatrixXd> slice) {
  const Eigen::Index left = core.left;
  slice.setZero();
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const Eigen::Map<const Eigen::MatrixXd, 0, Eigen::OuterStride<>> at(
        core.data.data() + left * (first + i), left, core.right, Eigen::OuterStride<>(left * core.size));
    slice += weights[i] * at;
  }
}

void check_train(const std::vector<Axis>& axes, const std::vector<OutputLabel>& outputs,
                 const TensorTrain& train) {
  constexpr std::string_view kWhere = "a train of fields";
  require(!axes.empty(), "the number of axes", axes.size(), "at least 1", kWhere);
  require(!outputs.empty(), "the number of outputs", outputs.size(), "at least 1", kWhere);
  require(train.cores.size() == axes.size() + 1, "the number of cores", train.cores.size(),
          fmt::format("{}, one for the outputs and one per axis,", axes.size() + 1), kWhere);
  int left = 1;
  for (std::size_t k = 0; k < train.cores.size(); ++k) {
    const TrainCore& core = train.cores[k];
    const int size = k == 0 ? static_cast<int>(outputs.size()) : axes[k - 1].size();
    const auto entries = Eigen::Index{core.left} * core.size * core.right;
    if (core.left != left || core.size != size || core.data.size() != entries) {
      throw ArgumentError(fmt::format("core {} of a train is {} x {} x {} with {} entries, expected {} x {}",
                                      k, core.left, core.size, core.right, core.data.size(), left, size));
    }
    if (!core.data.allFinite()) throw ArgumentError(fmt::format("core {} of a train is not finite", k));
    left = core.right;
  }
  require(left == 1, "the last rank", left, "1", kWhere);
}

}  // namespace

TrainField::TrainField(std::vector<Axis> axes, std::vector<OutputLabel> outputs, TensorTrain train)
    : axes_(std::move(axes)), outputs_(std::move(outputs)), train_(std::move(train)) {
  check_train(axes_, outputs_, train_);
}

long TrainField::entries() const {
  return std::accumulate(train_.cores.begin(), train_.cores.end(), 0L,
                         [](long sum, const TrainCore& core) { return sum + core.data.size(); });
}

TrainField::Workspace TrainField::make_workspace() const {
  Workspace workspace;
  Eigen::Index widest = 1;
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const TrainCore& core = train_.cores[k + 1];
    workspace.stencils.push_back(axes_[k].make_stencil());
    workspace.slices.emplace_back(core.left, core.right);
    workspace.derivatives.emplace_back(core.left, core.right);
    workspace.after.emplace_back(core.left);
    widest = std::max<Eigen::Index>({widest, core.left, core.right});
  }
  workspace.before.resize(widest, output_count());
  workspace.next.resize(widest, output_count());
  workspace.through.resize(widest);
  return workspace;
}

void TrainField::slice(int axis, double x, InterpolationStencil& stencil,
                       Eigen::Ref<Eigen::MatrixXd> slice) const {
  const auto k = static_cast<std::size_t>(axis);
  axes_[k].interpolate(x, stencil, false);
  interpolate_slices(train_.cores[k + 1], stencil.first, stencil.value, slice);
}

void TrainField::slice(int axis, double x, InterpolationStencil& stencil, Eigen::Ref<Eigen::MatrixXd> slice,
                       Eigen::Ref<Eigen::MatrixXd> derivative) const {
  const auto k = static_cast<std::size_t>(axis);
  axes_[k].interpolate(x, stencil, true);
  interpolate_slices(train_.cores[k + 1], stencil.first, stencil.value, slice);
  interpolate_slices(train_.cores[k + 1], stencil.first, stencil.derivative, derivative);
}

void TrainField::load(std::span<const double> x, bool with_derivatives, Workspace& workspace) const {
  require_inside(axes_, x);
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const auto axis = static_cast<int>(k);
    if (with_derivatives) {
      slice(axis, x[k], workspace.stencils[k], workspace.slices[k], workspace.derivatives[k]);
    } else {
      slice(axis, x[k], workspace.stencils[k], workspace.slices[k]);
    }
  }
  // after[k] = G_k+1 .. G_d, a column: the last rank is 1.
  const std::size_t last = axes_.size() - 1;
  workspace.after[last] = workspace.slices[last].col(0);
  for (std::size_t k = last; k-- > 0;) {
    workspace.after[k].noalias() = workspace.slices[k] * workspace.after[k + 1];
  }
}

void TrainField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Workspace& workspace) const {
  load(x, false, workspace);
  values.noalias() = train_.cores[0].left_unfolding() * workspace.after[0];
}

void TrainField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const {
  load(x, true, workspace);
  values.noalias() = train_.cores[0].left_unfolding() * workspace.after[0];
  // `before` grows from the left; the derivative of one core stands between it and what is after. Columns
  // one by one: a product of large matrices would take scratch memory.
  Eigen::Index width = train_.cores[0].right;
  workspace.before.topRows(width) = train_.cores[0].left_unfolding().transpose();
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const auto before = workspace.before.topRows(width);
    auto through = workspace.through.head(width);
    if (k + 1 < axes_.size()) {
      through.noalias() = workspace.derivatives[k] * workspace.after[k + 1];
    } else {
      through = workspace.derivatives[k].col(0);
    }
    gradient.col(static_cast<Eigen::Index>(k)).noalias() = before.transpose() * through;
    if (k + 1 == axes_.size()) break;
    const Eigen::MatrixXd& slice = workspace.slices[k];
    for (Eigen::Index m = 0; m < before.cols(); ++m) {
      workspace.next.col(m).head(slice.cols()).noalias() = slice.transpose() * before.col(m);
    }
    width = slice.cols();
    workspace.before.swap(workspace.next);
  }
}

Eigen::VectorXd TrainField::operator()(std::span<const double> x) const {
  Workspace workspace = make_workspace();
  Eigen::VectorXd values(output_count());
  evaluate(x, values, workspace);
  return values;
}

}  // namespace samara::pgd
