#include "samara/codebooks/query/place_query.h"

#include <algorithm>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/codebooks/book/argument_checks.h"

namespace samara::codebooks {

namespace {

const SpaceMesh& mesh_of(const Codebook& book) {
  if (book.mesh() == nullptr)
    throw ArgumentError("the codebook has no mesh, in which a point could be looked for");
  return *book.mesh();
}

std::vector<Coordinate> coordinates_in_space(const Codebook& book) {
  const SpaceMesh& mesh = mesh_of(book);
  std::vector<Coordinate> coordinates = book.coordinates();
  const auto node = coordinates.begin() + book.space().value();
  std::vector<Coordinate> directions;
  for (std::size_t k = 0; k < mesh.directions().size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    directions.push_back(
        {mesh.directions()[k], mesh.unit(), pgd::AxisRole::space, mesh.lower()[row], mesh.upper()[row]});
  }
  coordinates.insert(coordinates.erase(node), directions.begin(), directions.end());
  return coordinates;
}

}  // namespace

PlaceQuery::PlaceQuery(const Codebook& book)
    : mesh_(&mesh_of(book)),
      space_(static_cast<std::size_t>(book.space().value())),
      coordinates_(coordinates_in_space(book)),
      query_(book),
      point_(book.coordinates().size()),
      at_node_(book.output_count()),
      slopes_(book.output_count(), book.coordinate_count()) {}

void PlaceQuery::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values) {
  answer(x, values, nullptr);
}

void PlaceQuery::values(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                        Eigen::Ref<Eigen::MatrixXd> gradient) {
  require_size("derivatives", size_of(gradient), {at_node_.size(), std::ssize(coordinates_)});
  answer(x, values, &gradient);
}

void PlaceQuery::answer(std::span<const double> x, Eigen::Ref<Eigen::VectorXd> values,
                        Eigen::Ref<Eigen::MatrixXd>* gradient) {
  require_size("values", size_of(values), {at_node_.size(), 1});
  if (x.size() != coordinates_.size())
    throw ArgumentError(
        fmt::format("a point has {} coordinates, expected {}", x.size(), coordinates_.size()));
  require_inside(coordinates_, x);
  const std::size_t directions = mesh_->directions().size();
  const std::span<const double> place = x.subspan(space_, directions);
  const std::optional<SpaceMesh::Place> found = mesh_->find(place);
  if (!found) {
    throw OutsideBoxError(fmt::format("the point ({}) is in no cell of the mesh", fmt::join(place, ", ")));
  }
  std::copy(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(space_), point_.begin());
  std::copy(x.begin() + static_cast<std::ptrdiff_t>(space_ + directions), x.end(),
            point_.begin() + static_cast<std::ptrdiff_t>(space_) + 1);
  values.setZero();
  if (gradient != nullptr) gradient->setZero();
  const auto before = static_cast<Eigen::Index>(space_), along = static_cast<Eigen::Index>(directions);
  for (std::size_t i = 0; i < found->nodes.size(); ++i) {
    const auto corner = static_cast<Eigen::Index>(i);
    const double weight = found->weights[corner];
    point_[space_] = found->nodes[i];
    if (gradient == nullptr) {
      query_.values(point_, at_node_);
    } else {
      const Eigen::Index after = slopes_.cols() - before - 1;
      query_.values(point_, at_node_, slopes_);
      gradient->leftCols(before) += weight * slopes_.leftCols(before);
      gradient->middleCols(before, along) += at_node_ * found->slopes.row(corner);
      gradient->rightCols(after) += weight * slopes_.rightCols(after);
    }
    values += weight * at_node_;
  }
}

}  // namespace samara::codebooks
