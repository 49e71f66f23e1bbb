#include "samara/codebooks/query/kernels/row_form.h"

#include <utility>

#include "samara/base/errors.h"

namespace samara::codebooks::kernels {

namespace {

/// The chosen outputs in front of all axes.
RowForm rows_of(const pgd::SeparatedField& field, const RowChoice& choice) {
  RowForm form;
  form.axes = field.axes();
  form.factors = field.factors();
  form.rows = field.weights()(choice.outputs, Eigen::all);
  return form;
}

RowForm rows_of(const pgd::TrainField& field, const RowChoice& choice) {
  RowForm form;
  form.axes = field.axes();
  form.is_train = true;
  form.cores.assign(field.train().cores.begin() + 1, field.train().cores.end());
  form.rows = field.train().cores[0].left_unfolding()(choice.outputs, Eigen::all);
  return form;
}

/// Of a train: the core of an axis at a point, left rank x right rank.
Eigen::MatrixXd slice_at(const RowForm& form, std::size_t axis, double x) {
  const pgd::TrainCore& core = form.cores[axis];
  pgd::InterpolationStencil stencil = form.axes[axis].make_stencil();
  form.axes[axis].interpolate(x, stencil, false);
  Eigen::MatrixXd slice = Eigen::MatrixXd::Zero(core.left, core.right);
  for (Eigen::Index i = 0; i < stencil.value.size(); ++i)
    slice += stencil.value[i] * core.slice(stencil.first + static_cast<int>(i));
  return slice;
}

/// Of a sum: the factors of an axis at a point.
Eigen::RowVectorXd factors_at(const RowForm& form, std::size_t axis, double x) {
  pgd::InterpolationStencil stencil = form.axes[axis].make_stencil();
  form.axes[axis].interpolate(x, stencil, false);
  return stencil.value.transpose() * form.factors[axis].middleRows(stencil.first, stencil.value.size());
}

void drop_axis(RowForm& form, std::size_t axis) {
  const auto at = static_cast<std::ptrdiff_t>(axis);
  form.axes.erase(form.axes.begin() + at);
  if (form.is_train) {
    form.cores.erase(form.cores.begin() + at);
  } else {
    form.factors.erase(form.factors.begin() + at);
  }
}

/// The axis of time goes into the rows: outputs at times, times running fastest.
void spread_over_times(RowForm& form, const std::vector<double>& times) {
  const auto count = static_cast<Eigen::Index>(times.size());
  const Eigen::Index right = form.is_train ? form.cores[0].right : form.rows.cols();
  Eigen::MatrixXd rows(count * form.rows.rows(), right);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = times[static_cast<std::size_t>(i)];
    const Eigen::MatrixXd at_time = form.is_train
                                        ? Eigen::MatrixXd(form.rows * slice_at(form, 0, t))
                                        : Eigen::MatrixXd(form.rows * factors_at(form, 0, t).asDiagonal());
    for (Eigen::Index o = 0; o < form.rows.rows(); ++o) rows.row(i + count * o) = at_time.row(o);
  }
  form.rows = std::move(rows);
  drop_axis(form, 0);
}

/// Multiplies what an axis is at x into what stands before it.
void hold_axis(RowForm& form, std::size_t axis, double x) {
  if (!form.is_train) {
    form.rows *= factors_at(form, axis, x).asDiagonal();
  } else if (axis == 0) {
    form.rows *= slice_at(form, axis, x);
  } else {
    const Eigen::MatrixXd slice = slice_at(form, axis, x);
    const pgd::TrainCore& before = form.cores[axis - 1];
    pgd::TrainCore merged(before.left, before.size, static_cast<int>(slice.cols()));
    merged.left_unfolding() = before.left_unfolding() * slice;
    form.cores[axis - 1] = std::move(merged);
  }
  drop_axis(form, axis);
}

}  // namespace

RowForm row_form(const FieldGroup& group, const RowChoice& choice) {
  RowForm form = group.train() != nullptr ? rows_of(*group.train(), choice) : rows_of(*group.sum(), choice);
  // From the last axis on, so that the places of those before stay what they are.
  for (std::size_t k = choice.fixed.size(); k-- > 0;) {
    if (choice.fixed[k] && !(k == 0 && choice.times)) hold_axis(form, k, *choice.fixed[k]);
  }
  if (choice.times) spread_over_times(form, *choice.times);
  if (form.axes.empty())
    throw ArgumentError("a query holds all coordinates of the codebook, expected one that is free");
  return form;
}

}  // namespace samara::codebooks::kernels
