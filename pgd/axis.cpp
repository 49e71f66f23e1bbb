#include "samara/pgd/axis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/pgd/quadrature.h"

namespace samara::pgd {

namespace {

constexpr std::array kBasisNames = {"p1", "chebyshev", "radau"};
constexpr std::array kRoleNames = {"time", "space", "parameter", "initial", "boundary"};

void check_borders(const std::string& name, const Eigen::VectorXd& borders) {
  if (borders.size() < 2) {
    throw ArgumentError(fmt::format("axis \"{}\" has {} nodes, expected at least 2", name, borders.size()));
  }
  if (!borders.allFinite())
    throw ArgumentError(fmt::format("axis \"{}\" has a node that is not finite", name));
  for (Eigen::Index i = 1; i < borders.size(); ++i) {
    if (!(borders[i] > borders[i - 1])) {
      throw ArgumentError(fmt::format("axis \"{}\" goes from {} to {}, expected increasing values", name,
                                      borders[i - 1], borders[i]));
    }
  }
}

Eigen::VectorXd equidistant(const std::string& name, double lower, double upper, int elements) {
  if (elements < 1) {
    throw ArgumentError(fmt::format("axis \"{}\" has {} elements, expected at least 1", name, elements));
  }
  check_borders(name, Eigen::Vector2d(lower, upper));
  return Eigen::VectorXd::LinSpaced(elements + 1, lower, upper);
}

/// Integrals over one reference element.
struct ElementMatrices {
  Eigen::MatrixXd mass, gradient, stiffness;
  Eigen::VectorXd weights;
};

ElementMatrices integrate_element(const LagrangeBasis& local) {
  const int n = local.size();
  const QuadratureRule rule = gauss_legendre(n);  // exact for products of two basis functions
  ElementMatrices m{Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n), Eigen::MatrixXd::Zero(n, n),
                    Eigen::VectorXd::Zero(n)};
  Eigen::VectorXd value(n);
  for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
    local.values(rule.nodes[q], value);
    const Eigen::VectorXd slope = local.differentiation().transpose() * value;
    m.mass += rule.weights[q] * value * value.transpose();
    m.gradient += rule.weights[q] * value * slope.transpose();
    m.stiffness += rule.weights[q] * slope * slope.transpose();
    m.weights += rule.weights[q] * value;
  }
  return m;
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void scatter(Triplets& triplets, Eigen::Index first, const Eigen::MatrixXd& local, double scale) {
  for (Eigen::Index i = 0; i < local.rows(); ++i) {
    for (Eigen::Index j = 0; j < local.cols(); ++j) {
      triplets.emplace_back(first + i, first + j, scale * local(i, j));
    }
  }
}

SparseMatrix assemble(Eigen::Index n, const Triplets& triplets) {
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();
  return matrix;
}

}  // namespace

Axis Axis::make(Label label, Basis basis, const Eigen::VectorXd& borders,
                const Eigen::VectorXd& reference_nodes) {
  check_borders(label.name, borders);
  auto tables = std::make_shared<Tables>(
      Tables{std::move(label), basis, borders, LagrangeBasis(reference_nodes), {}, {}, {}, {}, {}, {}});
  const LagrangeBasis& local = tables->local;
  const ElementMatrices element = integrate_element(local);
  const Eigen::Index degree = local.size() - 1;
  const Eigen::Index elements = borders.size() - 1;
  const Eigen::Index n = elements * degree + 1;
  tables->nodes.resize(n);
  tables->weights = Eigen::VectorXd::Zero(n);
  Triplets mass, gradient, stiffness, derivative;
  for (Eigen::Index e = 0; e < elements; ++e) {
    const double half = 0.5 * (borders[e + 1] - borders[e]);
    const double middle = 0.5 * (borders[e + 1] + borders[e]);
    const Eigen::Index first = e * degree;
    tables->nodes.segment(first, degree + 1) = (middle + half * reference_nodes.array()).matrix();
    // Exactly the borders, so that a point on a border is a node.
    tables->nodes[first] = borders[e];
    tables->nodes[first + degree] = borders[e + 1];
    tables->weights.segment(first, degree + 1) += half * element.weights;
    scatter(mass, first, element.mass, half);
    scatter(gradient, first, element.gradient, 1.0);
    scatter(stiffness, first, element.stiffness, 1.0 / half);
    // The first node of an element belongs to the element on its left, except on the very first.
    const Eigen::Index skip = e == 0 ? 0 : 1;
    for (Eigen::Index i = skip; i <= degree; ++i) {
      for (Eigen::Index j = 0; j <= degree; ++j) {
        derivative.emplace_back(first + i, first + j, local.differentiation()(i, j) / half);
      }
    }
  }
  tables->mass = assemble(n, mass);
  tables->gradient = assemble(n, gradient);
  tables->stiffness = assemble(n, stiffness);
  tables->derivative = assemble(n, derivative);
  return Axis(std::move(tables));
}

Axis Axis::p1(Label label, const Eigen::VectorXd& nodes) {
  return make(std::move(label), Basis::p1, nodes, Eigen::Vector2d(-1.0, 1.0));
}

Axis Axis::p1(Label label, double lower, double upper, int count) {
  const Eigen::VectorXd nodes = equidistant(label.name, lower, upper, count - 1);
  return p1(std::move(label), nodes);
}

Axis Axis::chebyshev(Label label, double lower, double upper, int count) {
  if (count < 2) {
    throw ArgumentError(fmt::format("axis \"{}\" has {} nodes, expected at least 2", label.name, count));
  }
  return make(std::move(label), Basis::chebyshev, Eigen::Vector2d(lower, upper),
              chebyshev_lobatto_nodes(count));
}

Axis Axis::radau(Label label, const Eigen::VectorXd& borders, int points) {
  if (points < 1) {
    throw ArgumentError(
        fmt::format("axis \"{}\" has {} points per element, expected at least 1", label.name, points));
  }
  Eigen::VectorXd reference(points + 1);
  reference << -1.0, gauss_radau_right(points).nodes;
  return make(std::move(label), Basis::radau, borders, reference);
}

Axis Axis::radau(Label label, double lower, double upper, int elements, int points) {
  const Eigen::VectorXd borders = equidistant(label.name, lower, upper, elements);
  return radau(std::move(label), borders, points);
}

InterpolationStencil Axis::make_stencil() const {
  return {0, Eigen::VectorXd::Zero(stencil_size()), Eigen::VectorXd::Zero(stencil_size())};
}

int Axis::element_of(double x) const {
  const Eigen::VectorXd& borders = tables_->borders;
  const double* begin = borders.data() + 1;
  const double* end = borders.data() + borders.size() - 1;
  return static_cast<int>(std::lower_bound(begin, end, x) - begin);
}

void Axis::interpolate(double x, InterpolationStencil& stencil, bool with_derivative) const {
  const int e = element_of(x);
  const double left = tables_->borders[e];
  const double right = tables_->borders[e + 1];
  // Written so that both ends map to -1 and 1 exactly.
  const double xi = ((x - left) - (right - x)) / (right - left);
  stencil.first = e * degree();
  tables_->local.values(xi, stencil.value);
  if (with_derivative) {
    stencil.derivative.noalias() = tables_->local.differentiation().transpose() * stencil.value;
    stencil.derivative *= 2.0 / (right - left);
  }
}

std::string to_string(Basis basis) {
  return kBasisNames.at(static_cast<std::size_t>(basis));
}
std::string to_string(AxisRole role) {
  return kRoleNames.at(static_cast<std::size_t>(role));
}

namespace {
template <typename Enum, std::size_t N>
Enum from_name(const std::string& what, const std::string& name, const std::array<const char*, N>& names) {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) {
    const std::vector<std::string> known(names.begin(), names.end());
    throw ArgumentError(fmt::format("{} is \"{}\"{}", what, name, suggestion(name, known)));
  }
  return static_cast<Enum>(it - names.begin());
}
}  // namespace

Basis basis_from_string(const std::string& name) {
  return from_name<Basis>("basis", name, kBasisNames);
}
AxisRole role_from_string(const std::string& name) {
  return from_name<AxisRole>("role", name, kRoleNames);
}

}  // namespace samara::pgd
