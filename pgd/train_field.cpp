#include "samara/pgd/train_field.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/field_check.h"

namespace samara::pgd {

namespace {

/// sum_i weight_i slice(first + i), left x right.
void interpolate_slices(const TrainCore& core, int first, const Eigen::VectorXd& weights,
                        Eigen::MatrixXd& slice) {
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
  if (axes.empty() || outputs.empty()) {
    throw ArgumentError("a train of fields needs at least one axis and one output");
  }
  if (train.cores.size() != axes.size() + 1) {
    throw ArgumentError(fmt::format("a train of fields has {} axes and {} cores, expected one more",
                                    axes.size(), train.cores.size()));
  }
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
  if (left != 1) throw ArgumentError(fmt::format("the last rank of a train is {}, expected 1", left));
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
    workspace.behind.emplace_back(core.left);
    widest = std::max<Eigen::Index>({widest, core.left, core.right});
  }
  workspace.before.resize(output_count(), widest);
  workspace.next.resize(output_count(), widest);
  return workspace;
}

void TrainField::load(std::span<const double> x, bool with_derivatives, Workspace& workspace) const {
  require_inside(axes_, x);
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    InterpolationStencil& stencil = workspace.stencils[k];
    axes_[k].interpolate(x[k], stencil, with_derivatives);
    const TrainCore& core = train_.cores[k + 1];
    interpolate_slices(core, stencil.first, stencil.value, workspace.slices[k]);
    if (with_derivatives) {
      interpolate_slices(core, stencil.first, stencil.derivative, workspace.derivatives[k]);
    }
  }
  // behind[k] = G_k+1 .. G_d, a column: the last rank is 1.
  const std::size_t last = axes_.size() - 1;
  workspace.behind[last] = workspace.slices[last].col(0);
  for (std::size_t k = last; k-- > 0;) {
    workspace.behind[k].noalias() = workspace.slices[k] * workspace.behind[k + 1];
  }
}

void TrainField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Workspace& workspace) const {
  load(x, false, workspace);
  values.noalias() = train_.cores[0].left_unfolding() * workspace.behind[0];
}

void TrainField::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const {
  load(x, true, workspace);
  values.noalias() = train_.cores[0].left_unfolding() * workspace.behind[0];
  // `before` grows from the left; the derivative of one core stands between it and what is behind.
  Eigen::Index width = train_.cores[0].right;
  workspace.before.leftCols(width) = train_.cores[0].left_unfolding();
  for (std::size_t k = 0; k < axes_.size(); ++k) {
    const Eigen::MatrixXd& slice = workspace.slices[k];
    const auto before = workspace.before.leftCols(width);
    const auto column = static_cast<Eigen::Index>(k);
    auto passed = workspace.next.leftCols(slice.cols());
    passed.noalias() = before * workspace.derivatives[k];
    if (k + 1 < axes_.size()) {
      gradient.col(column).noalias() = passed * workspace.behind[k + 1];
    } else {
      gradient.col(column) = passed;
    }
    passed.noalias() = before * slice;
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
