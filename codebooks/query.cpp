#include "samara/codebooks/query.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/box.h"

namespace samara::codebooks {

Query::Query(const Codebook& book) : book_(book) {
  for (const Piece& piece : book.pieces()) {
    std::vector<Group> groups;
    int next = 0;
    for (const FieldGroup& field : piece.groups) {
      Group group{&field,
                  field.make_workspace(),
                  {},
                  Eigen::VectorXd(field.output_count()),
                  Eigen::MatrixXd(field.output_count(), field.axis_count())};
      for (int o = 0; o < field.output_count(); ++o) group.outputs.push_back(next++);
      groups.push_back(std::move(group));
    }
    pieces_.push_back(std::move(groups));
  }
}

std::vector<Query::Group>& Query::groups_at(std::span<const double> x) {
  require_inside(book_.coordinates(), x);
  for (std::vector<Group>& groups : pieces_) {
    if (contains(groups.front().field->axes(), x)) return groups;
  }
  throw OutsideBoxError(
      "the point lies in a gap between the pieces of the codebook or the values of a discrete axis");
}

void Query::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values) {
  require_size("values", size_of(values), {book_.output_count(), 1});
  for (Group& group : groups_at(x)) {
    group.field->evaluate(x, group.values, group.workspace);
    for (std::size_t o = 0; o < group.outputs.size(); ++o) {
      values[group.outputs[o]] = group.values[static_cast<Eigen::Index>(o)];
    }
  }
}

void Query::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                   Eigen::Ref<Eigen::MatrixXd> gradient) {
  require_size("values", size_of(values), {book_.output_count(), 1});
  require_size("derivatives", size_of(gradient), {book_.output_count(), book_.coordinate_count()});
  for (Group& group : groups_at(x)) {
    group.field->evaluate(x, group.values, group.gradient, group.workspace);
    for (std::size_t o = 0; o < group.outputs.size(); ++o) {
      const auto row = static_cast<Eigen::Index>(o);
      values[group.outputs[o]] = group.values[row];
      gradient.row(group.outputs[o]) = group.gradient.row(row);
    }
  }
}

}  // namespace samara::codebooks
