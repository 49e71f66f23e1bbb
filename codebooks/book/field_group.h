#pragma once

#include <span>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/fields/train_field.h"

namespace samara::codebooks {

/// What a field group is, without its numbers.
struct GroupOutline {
  std::vector<pgd::OutputLabel> outputs;
  bool is_train = false;
  std::vector<int> ranks;  ///< of a train, between outputs, first axis, second, ..; of a sum its terms
  long entries = 0;        ///< numbers stored, those of the axes aside
};

/// Several outputs over the axes of a piece: a sum of products or a train. Immutable, safe to share between
/// threads.
class FieldGroup {
 public:
  /// Scratch space of one thread.
  using Workspace = std::variant<pgd::SeparatedField::Workspace, pgd::TrainField::Workspace>;

  // Fields are groups: no words are needed to make one of them.
  FieldGroup(pgd::SeparatedField field);  // NOLINT(google-explicit-constructor)
  FieldGroup(pgd::TrainField field);      // NOLINT(google-explicit-constructor)

  const std::vector<pgd::Axis>& axes() const;
  const std::vector<pgd::OutputLabel>& outputs() const;
  int axis_count() const { return static_cast<int>(axes().size()); }
  int output_count() const { return static_cast<int>(outputs().size()); }
  /// Numbers stored, those of the axes aside.
  long entries() const;
  GroupOutline outline() const;

  /// The field of a group that is a sum of products, else null.
  const pgd::SeparatedField* sum() const { return std::get_if<pgd::SeparatedField>(&field_); }
  /// The field of a group that is a train, else null.
  const pgd::TrainField* train() const { return std::get_if<pgd::TrainField>(&field_); }

  Workspace make_workspace() const;

  /// All outputs at one point, as SeparatedField::evaluate and TrainField::evaluate.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values, Workspace& workspace) const;
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const;

 private:
  std::variant<pgd::SeparatedField, pgd::TrainField> field_;
};

}  // namespace samara::codebooks
