#include "samara/codebooks/book/field_group.h"

#include <type_traits>
#include <utility>

namespace samara::codebooks {

FieldGroup::FieldGroup(pgd::SeparatedField field) : field_(std::move(field)) {}
FieldGroup::FieldGroup(pgd::TrainField field) : field_(std::move(field)) {}

const std::vector<pgd::Axis>& FieldGroup::axes() const {
  return std::visit([](const auto& field) -> const std::vector<pgd::Axis>& { return field.axes(); }, field_);
}

const std::vector<pgd::OutputLabel>& FieldGroup::outputs() const {
  return std::visit([](const auto& field) -> const std::vector<pgd::OutputLabel>& { return field.outputs(); },
                    field_);
}

long FieldGroup::entries() const {
  if (const pgd::TrainField* field = train()) return field->entries();
  long entries = sum()->weights().size();
  for (const Eigen::MatrixXd& factor : sum()->factors()) entries += factor.size();
  return entries;
}

GroupOutline FieldGroup::outline() const {
  const bool is_train = train() != nullptr;
  return {outputs(), is_train, is_train ? train()->train().ranks() : std::vector{sum()->rank()}, entries()};
}

FieldGroup::Workspace FieldGroup::make_workspace() const {
  return std::visit([](const auto& field) { return Workspace(field.make_workspace()); }, field_);
}

void FieldGroup::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Workspace& workspace) const {
  std::visit(
      [&](const auto& field) {
        using Field = std::decay_t<decltype(field)>;
        field.evaluate(x, values, std::get<typename Field::Workspace>(workspace));
      },
      field_);
}

void FieldGroup::evaluate(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                          Eigen::Ref<Eigen::MatrixXd> gradient, Workspace& workspace) const {
  std::visit(
      [&](const auto& field) {
        using Field = std::decay_t<decltype(field)>;
        field.evaluate(x, values, gradient, std::get<typename Field::Workspace>(workspace));
      },
      field_);
}

}  // namespace samara::codebooks
