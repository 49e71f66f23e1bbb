#include "samara/pgd/axes/axis.h"

#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/axes/axis_checks.h"
#include "samara/pgd/axes/axis_elements.h"
#include "samara/pgd/axes/axis_fourier.h"
#include "samara/pgd/axes/axis_list.h"

namespace samara::pgd {

Axis::Axis(AxisTables tables) {
  tables.family = basis_traits(tables.basis).family;
  tables_ = std::make_shared<const AxisTables>(std::move(tables));
}

Axis Axis::of_elements(Label label, Basis basis, const Eigen::VectorXd& borders, int degree) {
  const BasisTraits& traits = basis_traits(basis);
  if (traits.element_nodes == nullptr)
    throw ArgumentError(
        fmt::format("{} is {}; a basis with elements was expected", axis_text(label), traits.name));
  require(degree >= 1, "the degree of its elements", degree, "at least 1", axis_text(label));
  return Axis(element_tables(std::move(label), basis, borders, traits.element_nodes(degree)));
}

Axis Axis::p1(Label label, const Eigen::VectorXd& nodes) {
  return of_elements(std::move(label), Basis::p1, nodes, 1);
}

Axis Axis::p1(Label label, double lower, double upper, int count) {
  const Eigen::VectorXd nodes = equal_elements(label, lower, upper, count - 1);
  return p1(std::move(label), nodes);
}

Axis Axis::p2(Label label, const Eigen::VectorXd& borders) {
  return of_elements(std::move(label), Basis::p2, borders, 2);
}

Axis Axis::p2(Label label, double lower, double upper, int elements) {
  const Eigen::VectorXd borders = equal_elements(label, lower, upper, elements);
  return p2(std::move(label), borders);
}

Axis Axis::chebyshev(Label label, double lower, double upper, int count) {
  require(count >= 2, "the number of nodes", count, "at least 2", axis_text(label));
  return chebyshev(std::move(label), Eigen::Vector2d(lower, upper), count - 1);
}

Axis Axis::chebyshev(Label label, const Eigen::VectorXd& borders, int degree) {
  return of_elements(std::move(label), Basis::chebyshev, borders, degree);
}

Axis Axis::legendre(Label label, double lower, double upper, int count) {
  require(count >= 2, "the number of nodes", count, "at least 2", axis_text(label));
  return legendre(std::move(label), Eigen::Vector2d(lower, upper), count - 1);
}

Axis Axis::legendre(Label label, const Eigen::VectorXd& borders, int degree) {
  return of_elements(std::move(label), Basis::legendre, borders, degree);
}

Axis Axis::radau(Label label, const Eigen::VectorXd& borders, int points) {
  return of_elements(std::move(label), Basis::radau, borders, points);
}

Axis Axis::radau(Label label, double lower, double upper, int elements, int points) {
  const Eigen::VectorXd borders = equal_elements(label, lower, upper, elements);
  return radau(std::move(label), borders, points);
}

Axis Axis::fourier(Label label, double lower, double upper, int count) {
  return Axis(fourier_tables(std::move(label), lower, upper, count));
}

Axis Axis::discrete(Label label, const Eigen::VectorXd& values) {
  return Axis(discrete_tables(std::move(label), values));
}

Axis Axis::imported(Label label, const SparseMatrix& mass) {
  return Axis(imported_tables(std::move(label), mass));
}

const LagrangeBasis& Axis::element_basis() const {
  if (has_elements()) return *tables_->local;
  throw ArgumentError(fmt::format("axis \"{}\" is {} and has no elements", name(), to_string(basis())));
}

const SparseMatrix& Axis::existing(const std::optional<SparseMatrix>& matrix, const char* what) const {
  if (matrix) return *matrix;
  if (is_list()) {
    throw ArgumentError(fmt::format("axis \"{}\" is {}: functions on it have no derivative, and it has no {}",
                                    name(), to_string(basis()), what));
  }
  throw ArgumentError(fmt::format(
      "axis \"{}\" begins at 0 with the transform \"{}\", where derivatives are infinite: it has no {}",
      name(), to_string(transform()), what));
}

int Axis::stencil_size() const {
  return has_elements() ? tables_->local->size() : is_list() ? 1 : size();
}

InterpolationStencil Axis::make_stencil() const {
  return {0, Eigen::VectorXd::Zero(stencil_size()), Eigen::VectorXd::Zero(stencil_size())};
}

void Axis::interpolate(double x, InterpolationStencil& stencil, bool with_derivative) const {
  if (has_elements()) {
    interpolate_element(*tables_, x, stencil, with_derivative);
  } else if (is_list()) {
    stencil.first = nearest_node(*tables_, x);
    stencil.value[0] = 1.0;
    if (with_derivative) stencil.derivative[0] = std::nan("");
  } else {
    interpolate_fourier(*tables_, x, stencil, with_derivative);
  }
}

int Axis::element_of(double x) const {
  return has_elements() ? pgd::element_of(*tables_, x) : 0;
}

bool Axis::contains(double x) const {
  const bool inside = x >= lower() && x <= upper();
  return inside && (!is_list() || nodes()[nearest_node(*tables_, x)] == x);
}

}  // namespace samara::pgd
