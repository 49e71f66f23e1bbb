#include "samara/pgd/fields/field.h"

#include <type_traits>
#include <utility>

#include "samara/pgd/fields/field_algebra.h"
#include "samara/pgd/fields/train_field_algebra.h"

namespace samara::pgd {

Field::Field(SeparatedField field) : field_(std::move(field)) {}
Field::Field(TrainField field) : field_(std::move(field)) {}

const std::vector<Axis>& Field::axes() const {
  return std::visit([](const auto& field) -> const std::vector<Axis>& { return field.axes(); }, field_);
}

const std::vector<OutputLabel>& Field::outputs() const {
  return std::visit([](const auto& field) -> const std::vector<OutputLabel>& { return field.outputs(); },
                    field_);
}

long Field::entries() const {
  if (const TrainField* field = train()) return field->entries();
  long entries = sum()->weights().size();
  for (const Eigen::MatrixXd& factor : sum()->factors()) entries += factor.size();
  return entries;
}

Field::Workspace Field::make_workspace() const {
  return std::visit([](const auto& field) { return Workspace(field.make_workspace()); }, field_);
}

void Field::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                     Workspace& workspace) const {
  std::visit(
      [&](const auto& field) {
        using Kind = std::decay_t<decltype(field)>;
        field.evaluate(x, values, std::get<typename Kind::Workspace>(workspace));
      },
      field_);
}

void Field::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                     Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const {
  std::visit(
      [&](const auto& field) {
        using Kind = std::decay_t<decltype(field)>;
        field.evaluate(x, values, gradient, std::get<typename Kind::Workspace>(workspace));
      },
      field_);
}

namespace {

template <class Operation>
Field map(const Field& f, const Operation& operation) {
  return f.train() != nullptr ? Field(operation(*f.train())) : Field(operation(*f.sum()));
}

}  // namespace

Field scaled(const Field& f, double factor) {
  return map(f, [&](const auto& field) { return scaled(field, factor); });
}

Field restricted(const Field& f, const std::string& axis, double x) {
  return map(f, [&](const auto& field) { return restricted(field, axis, x); });
}

Field integral(const Field& f, const std::string& axis) {
  return map(f, [&](const auto& field) { return integral(field, axis); });
}

Field mean(const Field& f, const std::string& axis) {
  return map(f, [&](const auto& field) { return mean(field, axis); });
}

Field derivative(const Field& f, const std::string& axis) {
  return map(f, [&](const auto& field) { return derivative(field, axis); });
}

}  // namespace samara::pgd
