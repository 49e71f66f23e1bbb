#pragma once

#include <span>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/separated_field.h"
#include "samara/pgd/train_field.h"

namespace samara::codebooks {

/// Chosen outputs of a sum of products at fixed times. Does not allocate after construction; one per thread.
class SumAtTimes {
 public:
  /// @param outputs places in the field, which must outlive this
  SumAtTimes(const pgd::SeparatedField& field, const std::vector<double>& times,
             const std::vector<int>& outputs);

  /// @param q the coordinates behind time
  void load(std::span<const double> q, bool with_derivatives);
  /// times x outputs at what was loaded; and its derivative by coordinate k behind time.
  void values(Eigen::Ref<Eigen::MatrixXd> result);
  void derivative(Eigen::Index k, Eigen::Ref<Eigen::MatrixXd> result);

 private:
  void sum_terms(Eigen::Ref<Eigen::MatrixXd> result);

  const pgd::SeparatedField& field_;
  Eigen::MatrixXd time_factors_;  ///< times x rank
  Eigen::MatrixXd weights_;       ///< rank x outputs
  std::vector<pgd::InterpolationStencil> stencils_;
  Eigen::MatrixXd factor_values_, factor_derivatives_;  ///< rank x parameters
  Eigen::VectorXd product_;
  Eigen::MatrixXd scaled_weights_;  ///< rank x outputs
};

/// The same of a train: output core and time core are contracted once, to a row per output and time.
class TrainAtTimes {
 public:
  TrainAtTimes(const pgd::TrainField& field, const std::vector<double>& times,
               const std::vector<int>& outputs);

  void load(std::span<const double> q, bool with_derivatives);
  void values(Eigen::Ref<Eigen::MatrixXd> result);
  void derivative(Eigen::Index k, Eigen::Ref<Eigen::MatrixXd> result);

 private:
  void contract(const Eigen::VectorXd& behind, Eigen::Ref<Eigen::MatrixXd> result) const;

  const pgd::TrainField& field_;
  Eigen::Index times_ = 0;
  Eigen::MatrixXd rows_;  ///< (times, outputs) x rank behind time
  std::vector<pgd::InterpolationStencil> stencils_;
  std::vector<Eigen::MatrixXd> slices_, derivatives_;  ///< per parameter
  /// behind_[j] = the product of the slices of parameters j, j + 1, ..; the last is 1.
  std::vector<Eigen::VectorXd> behind_;
  std::vector<Eigen::VectorXd> changed_;  ///< the same with one slice's derivative
};

using GroupAtTimes = std::variant<SumAtTimes, TrainAtTimes>;

}  // namespace samara::codebooks
