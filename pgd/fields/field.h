#pragma once

#include <concepts>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/fields/train_field.h"

namespace samara::pgd {

/// What a sum of products and a train have in common: several outputs over axes that can be evaluated, with
/// derivatives, without allocation. Code that is the same for both is a template on it.
template <class F>
concept AnyField = requires(const F& field, std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                            Eigen::Ref<Eigen::MatrixXd> gradient, typename F::Workspace& workspace) {
  { field.axes() } -> std::same_as<const std::vector<Axis>&>;
  { field.outputs() } -> std::same_as<const std::vector<OutputLabel>&>;
  { field.axis_count() } -> std::same_as<int>;
  { field.output_count() } -> std::same_as<int>;
  { field.make_workspace() } -> std::same_as<typename F::Workspace>;
  field.evaluate(x, values, workspace);
  field.evaluate(x, values, gradient, workspace);
};
static_assert(AnyField<SeparatedField> && AnyField<TrainField>);

/// Either of them: what a build gives and a codebook holds. Restriction, integrals, means, derivatives
/// (below) and statistics (statistics.h) take it, and give the kind they were given. Immutable, safe to share
/// between threads.
class Field {
 public:
  /// Scratch space of one thread.
  using Workspace = std::variant<SeparatedField::Workspace, TrainField::Workspace>;

  // Implicit: whoever takes a field takes either kind.
  Field(SeparatedField field);  // NOLINT(google-explicit-constructor)
  Field(TrainField field);      // NOLINT(google-explicit-constructor)

  const std::vector<Axis>& axes() const;
  const std::vector<OutputLabel>& outputs() const;
  int axis_count() const { return static_cast<int>(axes().size()); }
  int output_count() const { return static_cast<int>(outputs().size()); }
  /// Numbers stored, those of the axes aside.
  long entries() const;

  /// The field if it is a sum of products, else null.
  const SeparatedField* sum() const { return std::get_if<SeparatedField>(&field_); }
  /// The field if it is a train, else null.
  const TrainField* train() const { return std::get_if<TrainField>(&field_); }

  Workspace make_workspace() const;

  /// All outputs at one point, as SeparatedField::evaluate and TrainField::evaluate.
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values, Workspace& workspace) const;
  void evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const;

 private:
  std::variant<SeparatedField, TrainField> field_;
};
static_assert(AnyField<Field>);

/// As those of field_algebra.h and train_field_algebra.h.
Field scaled(const Field& f, double factor);
Field restricted(const Field& f, const std::string& axis, double x);
Field integral(const Field& f, const std::string& axis);
Field mean(const Field& f, const std::string& axis);
Field derivative(const Field& f, const std::string& axis);

}  // namespace samara::pgd
