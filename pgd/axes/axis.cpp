#include "samara/pgd/axes/axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis_checks.h"
#include "samara/pgd/axes/enum_names.h"

namespace samara::pgd {

namespace {
constexpr std::array kBasisNames = {"p1",       "chebyshev", "radau",    "p2",
                                    "legendre", "fourier",   "discrete", "imported"};
constexpr std::array kRoleNames = {"time", "space", "parameter", "initial", "boundary"};
}  // namespace

void check_increasing(const Axis::Label& label, const Eigen::VectorXd& values, int least) {
  if (values.size() < least) {
    throw ArgumentError(
        fmt::format("axis \"{}\" has {} nodes, expected at least {}", label.name, values.size(), least));
  }
  if (!values.allFinite())
    throw ArgumentError(fmt::format("axis \"{}\" has a node that is not finite", label.name));
  for (Eigen::Index i = 1; i < values.size(); ++i) {
    if (!(values[i] > values[i - 1])) {
      throw ArgumentError(fmt::format("axis \"{}\" goes from {} to {}, expected increasing values",
                                      label.name, values[i - 1], values[i]));
    }
  }
}

void check_no_transform(const Axis::Label& label, const char* kind) {
  if (label.transform == Transform::none) return;
  throw ArgumentError(fmt::format("axis \"{}\" has the transform \"{}\", which a {} axis cannot have",
                                  label.name, to_string(label.transform), kind));
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
    interpolate_element(x, stencil, with_derivative);
  } else if (is_list()) {
    stencil.first = nearest_node(x);
    stencil.value[0] = 1.0;
    if (with_derivative) stencil.derivative[0] = std::nan("");
  } else {
    interpolate_fourier(x, stencil, with_derivative);
  }
}

bool Axis::contains(double x) const {
  const bool inside = x >= lower() && x <= upper();
  return inside && (!is_list() || nodes()[nearest_node(x)] == x);
}

std::string to_string(Basis basis) {
  return kBasisNames.at(static_cast<std::size_t>(basis));
}
std::string to_string(AxisRole role) {
  return kRoleNames.at(static_cast<std::size_t>(role));
}
Basis basis_from_string(const std::string& name) {
  return from_name<Basis>("basis", name, kBasisNames);
}
AxisRole role_from_string(const std::string& name) {
  return from_name<AxisRole>("role", name, kRoleNames);
}

}  // namespace samara::pgd
