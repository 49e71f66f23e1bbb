#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/field_group.h"

namespace samara::codebooks::kernels {

/// What a query asks of a group.
struct RowChoice {
  std::vector<int> outputs;  ///< places in the group, in the order wanted
  /// Times at which all answers are wanted, of the first axis; none: time is a coordinate like others.
  std::optional<std::vector<double>> times = {};
  std::vector<std::optional<double>> fixed = {};  ///< per axis, where it is held; times go before
};

/// A group reduced to what is asked: rows, which are outputs, or outputs at times (times running fastest), as
/// functions of the axes that are left.
struct RowForm {
  std::vector<pgd::Axis> axes;
  bool is_train = false;
  Eigen::MatrixXd rows;                  ///< rows x rank in front of the first axis
  std::vector<pgd::TrainCore> cores;     ///< of a tensor train, per axis
  std::vector<Eigen::MatrixXd> factors;  ///< of a sum, per axis: nodes x terms
};

/// @throws ArgumentError if no axis is left
RowForm row_form(const FieldGroup& group, const RowChoice& choice);

}  // namespace samara::codebooks::kernels
