#include "samara/codebooks/trajectory_part.h"

namespace samara::codebooks {

SumAtTimes::SumAtTimes(const pgd::SeparatedField& field, const std::vector<double>& times,
                       const std::vector<int>& outputs)
    : field_(field),
      time_factors_(static_cast<Eigen::Index>(times.size()), field.rank()),
      weights_(field.weights()(outputs, Eigen::all).transpose()),
      factor_values_(field.rank(), field.axis_count() - 1),
      factor_derivatives_(field.rank(), field.axis_count() - 1),
      product_(field.rank()),
      scaled_weights_(weights_.rows(), weights_.cols()) {
  pgd::InterpolationStencil stencil = field.axes().front().make_stencil();
  Eigen::VectorXd factor(field.rank());
  for (std::size_t i = 0; i < times.size(); ++i) {
    field.factor_values(0, times[i], stencil, factor);
    time_factors_.row(static_cast<Eigen::Index>(i)) = factor.transpose();
  }
  for (std::size_t k = 1; k < field.axes().size(); ++k) stencils_.push_back(field.axes()[k].make_stencil());
}

void SumAtTimes::load(std::span<const double> q, bool with_derivatives) {
  for (std::size_t j = 0; j < q.size(); ++j) {
    const auto k = static_cast<Eigen::Index>(j);
    const int axis = static_cast<int>(j) + 1;
    if (with_derivatives) {
      field_.factor_values(axis, q[j], stencils_[j], factor_values_.col(k), factor_derivatives_.col(k));
    } else {
      field_.factor_values(axis, q[j], stencils_[j], factor_values_.col(k));
    }
  }
}

void SumAtTimes::values(Eigen::Ref<Eigen::MatrixXd> result) {
  product_.setOnes();
  for (Eigen::Index k = 0; k < factor_values_.cols(); ++k) product_.array() *= factor_values_.col(k).array();
  sum_terms(result);
}

void SumAtTimes::derivative(Eigen::Index k, Eigen::Ref<Eigen::MatrixXd> result) {
  product_ = factor_derivatives_.col(k);
  for (Eigen::Index other = 0; other < factor_values_.cols(); ++other) {
    if (other != k) product_.array() *= factor_values_.col(other).array();
  }
  sum_terms(result);
}

void SumAtTimes::sum_terms(Eigen::Ref<Eigen::MatrixXd> result) {
  scaled_weights_ = weights_.array().colwise() * product_.array();
  // Output by output: the product of two matrices would take scratch memory when it is large, and is not
  // faster for the few outputs there are.
  for (Eigen::Index o = 0; o < result.cols(); ++o)
    result.col(o).noalias() = time_factors_ * scaled_weights_.col(o);
}

TrainAtTimes::TrainAtTimes(const pgd::TrainField& field, const std::vector<double>& times,
                           const std::vector<int>& outputs)
    : field_(field), times_(static_cast<Eigen::Index>(times.size())) {
  const std::vector<pgd::TrainCore>& cores = field.train().cores;
  const auto count = static_cast<Eigen::Index>(outputs.size());
  const Eigen::MatrixXd chosen = cores[0].left_unfolding()(outputs, Eigen::all);
  rows_.resize(times_ * count, cores[1].right);
  pgd::InterpolationStencil stencil = field.axes().front().make_stencil();
  Eigen::MatrixXd slice(cores[1].left, cores[1].right);
  for (Eigen::Index i = 0; i < times_; ++i) {
    field.slice(0, times[static_cast<std::size_t>(i)], stencil, slice);
    const Eigen::MatrixXd at_time = chosen * slice;
    for (Eigen::Index o = 0; o < count; ++o) rows_.row(i + times_ * o) = at_time.row(o);
  }
  for (std::size_t k = 1; k < field.axes().size(); ++k) {
    const pgd::TrainCore& core = cores[k + 1];
    stencils_.push_back(field.axes()[k].make_stencil());
    slices_.emplace_back(core.left, core.right);
    derivatives_.emplace_back(core.left, core.right);
    behind_.emplace_back(core.left);
  }
  behind_.push_back(Eigen::VectorXd::Ones(1));
  changed_ = behind_;
}

void TrainAtTimes::load(std::span<const double> q, bool with_derivatives) {
  for (std::size_t j = 0; j < q.size(); ++j) {
    const int axis = static_cast<int>(j) + 1;
    if (with_derivatives) {
      field_.slice(axis, q[j], stencils_[j], slices_[j], derivatives_[j]);
    } else {
      field_.slice(axis, q[j], stencils_[j], slices_[j]);
    }
  }
  for (std::size_t j = q.size(); j-- > 0;) behind_[j].noalias() = slices_[j] * behind_[j + 1];
}

void TrainAtTimes::values(Eigen::Ref<Eigen::MatrixXd> result) {
  contract(behind_.front(), result);
}

void TrainAtTimes::derivative(Eigen::Index k, Eigen::Ref<Eigen::MatrixXd> result) {
  auto j = static_cast<std::size_t>(k);
  changed_[j].noalias() = derivatives_[j] * behind_[j + 1];
  for (; j > 0; --j) changed_[j - 1].noalias() = slices_[j - 1] * changed_[j];
  contract(changed_.front(), result);
}

void TrainAtTimes::contract(const Eigen::VectorXd& behind, Eigen::Ref<Eigen::MatrixXd> result) const {
  for (Eigen::Index o = 0; o < result.cols(); ++o)
    result.col(o).noalias() = rows_.middleRows(times_ * o, times_) * behind;
}

}  // namespace samara::codebooks
