#include "samara/pgd/axes/axis_elements.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/pgd/axes/axis_checks.h"
#include "samara/pgd/axes/quadrature.h"

namespace samara::pgd {

namespace {

void check_borders(const AxisLabel& label, const Eigen::VectorXd& borders) {
  check_increasing(label, borders, 2);
  if (in_domain(label.transform, borders[0])) return;
  throw ArgumentError(fmt::format("axis \"{}\" begins at {} with the transform \"{}\", expected {} 0",
                                  label.name, borders[0], to_string(label.transform),
                                  label.transform == Transform::square_root ? "at least" : "more than"));
}

/// Place of x in the element [left, right], mapped to [-1, 1] through the transform. Written so that both
/// ends map to -1 and 1 exactly.
double reference_place(Transform transform, double left, double right, double x) {
  return (transformed_distance(transform, left, x) - transformed_distance(transform, x, right)) /
         transformed_distance(transform, left, right);
}

/// The x at a place of [-1, 1], reckoned from the nearer end.
double place_in_element(Transform transform, double left, double right, double place) {
  const double half = 0.5 * transformed_distance(transform, left, right);
  return place <= 0.0 ? transformed_advance(transform, left, half * (1.0 + place))
                      : transformed_advance(transform, right, -half * (1.0 - place));
}

/// Integrals over one element.
struct ElementMatrices {
  explicit ElementMatrices(int n)
      : mass(Eigen::MatrixXd::Zero(n, n)),
        gradient(Eigen::MatrixXd::Zero(n, n)),
        stiffness(Eigen::MatrixXd::Zero(n, n)),
        weights(Eigen::VectorXd::Zero(n)) {}

  Eigen::MatrixXd mass, gradient, stiffness;
  Eigen::VectorXd weights;
};

ElementMatrices integrate_reference(const LagrangeBasis& local) {
  const int n = local.size();
  const QuadratureRule rule = gauss_legendre(n);  // exact for products of two basis functions
  ElementMatrices m(n);
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

/// An element without transform is the reference, scaled.
ElementMatrices scaled(const ElementMatrices& reference, double half) {
  ElementMatrices m = reference;
  m.mass *= half;
  m.stiffness *= 1.0 / half;
  m.weights *= half;
  return m;
}

ElementMatrices integrate_transformed(const LagrangeBasis& local, const ElementMatrices& reference,
                                      Transform transform, double left, double right) {
  const int n = local.size();
  const QuadratureRule rule = gauss_legendre(n + 12);
  ElementMatrices m(n);
  m.gradient = reference.gradient;  // N_i dN_j needs no measure
  const std::vector<double> panels = panel_borders(transform, left, right);
  const double per_place = 0.5 * transformed_distance(transform, left, right);  // ds per reference length
  Eigen::VectorXd value(n);
  for (std::size_t p = 1; p < panels.size(); ++p) {
    const double from = panels[p - 1], to = panels[p];
    const double half = 0.5 * transformed_distance(transform, from, to);
    for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
      const double x = place_in_element(transform, from, to, rule.nodes[q]);
      local.values(reference_place(transform, left, right, x), value);
      const Eigen::VectorXd slope = local.differentiation().transpose() * value / per_place;
      const double ds_dx = transform_slope(transform, x);
      const double ds = half * rule.weights[q];
      m.mass += (ds / ds_dx) * value * value.transpose();
      m.stiffness += (ds * ds_dx) * slope * slope.transpose();
      m.weights += (ds / ds_dx) * value;
    }
  }
  return m;
}

using Triplets = std::vector<Eigen::Triplet<double>>;

void scatter(Triplets& triplets, Eigen::Index first, const Eigen::MatrixXd& local) {
  for (Eigen::Index i = 0; i < local.rows(); ++i) {
    for (Eigen::Index j = 0; j < local.cols(); ++j) triplets.emplace_back(first + i, first + j, local(i, j));
  }
}

SparseMatrix assemble(Eigen::Index n, const Triplets& triplets) {
  SparseMatrix matrix(n, n);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();
  return matrix;
}

/// Nodes of all elements, with exactly the borders among them, so that a point on a border is a node.
Eigen::VectorXd place_nodes(Transform transform, const Eigen::VectorXd& borders,
                            const Eigen::VectorXd& reference_nodes) {
  const Eigen::Index degree = reference_nodes.size() - 1;
  Eigen::VectorXd nodes((borders.size() - 1) * degree + 1);
  for (Eigen::Index e = 0; e + 1 < borders.size(); ++e) {
    const double half = 0.5 * (borders[e + 1] - borders[e]);
    const double middle = 0.5 * (borders[e + 1] + borders[e]);
    for (Eigen::Index i = 1; i < degree; ++i) {
      nodes[e * degree + i] =
          transform == Transform::none
              ? middle + half * reference_nodes[i]
              : place_in_element(transform, borders[e], borders[e + 1], reference_nodes[i]);
    }
    nodes[e * degree] = borders[e];
  }
  nodes[nodes.size() - 1] = borders[borders.size() - 1];
  return nodes;
}

}  // namespace

std::vector<double> panel_borders(Transform transform, double left, double right) {
  // From 0, only the square root, whose dx/ds = 2 s is a polynomial.
  const bool has_pole = transform != Transform::none && left > 0.0;
  const int panels = has_pole ? std::max(1, static_cast<int>(std::ceil(std::log2(right / left)))) : 1;
  std::vector<double> borders = {left};
  for (int p = 1; p < panels; ++p)
    borders.push_back(left * std::pow(right / left, static_cast<double>(p) / panels));
  borders.push_back(right);
  return borders;
}

AxisTables element_tables(AxisLabel label, Basis basis, const Eigen::VectorXd& borders,
                          const Eigen::VectorXd& reference_nodes) {
  check_borders(label, borders);
  AxisTables tables;
  tables.label = std::move(label);
  tables.basis = basis;
  tables.borders = borders;
  tables.lower = borders[0];
  tables.upper = borders[borders.size() - 1];
  tables.measure = tables.upper - tables.lower;
  tables.local.emplace(reference_nodes);
  const Transform transform = tables.label.transform;
  tables.nodes = place_nodes(transform, borders, reference_nodes);
  const LagrangeBasis& local = *tables.local;
  const ElementMatrices reference = integrate_reference(local);
  const Eigen::Index degree = local.size() - 1;
  const Eigen::Index n = tables.nodes.size();
  tables.weights = Eigen::VectorXd::Zero(n);
  Triplets mass, gradient, stiffness, derivative;
  for (Eigen::Index e = 0; e + 1 < borders.size(); ++e) {
    const double half = 0.5 * transformed_distance(transform, borders[e], borders[e + 1]);
    const ElementMatrices element =
        transform == Transform::none
            ? scaled(reference, half)
            : integrate_transformed(local, reference, transform, borders[e], borders[e + 1]);
    const Eigen::Index first = e * degree;
    tables.weights.segment(first, degree + 1) += element.weights;
    scatter(mass, first, element.mass);
    scatter(gradient, first, element.gradient);
    scatter(stiffness, first, element.stiffness);
    // The first node of an element belongs to the element on its left, except on the very first.
    for (Eigen::Index i = e == 0 ? 0 : 1; i <= degree; ++i) {
      const double ds_dx = transform_slope(transform, tables.nodes[first + i]);
      for (Eigen::Index j = 0; j <= degree; ++j) {
        derivative.emplace_back(first + i, first + j, local.differentiation()(i, j) / half * ds_dx);
      }
    }
  }
  tables.mass = assemble(n, mass);
  tables.gradient = assemble(n, gradient);
  // Under the square root from 0, du/dx = u'(s) / (2 s) is neither finite nor square integrable.
  if (transform != Transform::square_root || tables.lower > 0.0) {
    tables.stiffness = assemble(n, stiffness);
    tables.derivative = assemble(n, derivative);
  }
  return tables;
}

Eigen::VectorXd equal_elements(const AxisLabel& label, double lower, double upper, int elements) {
  require(elements >= 1, "the number of elements", elements, "at least 1", axis_text(label));
  check_borders(label, Eigen::Vector2d(lower, upper));
  Eigen::VectorXd borders = Eigen::VectorXd::LinSpaced(elements + 1, lower, upper);
  if (label.transform == Transform::none) return borders;
  for (int e = 1; e < elements; ++e) {
    borders[e] = place_in_element(label.transform, lower, upper, (2.0 * e - elements) / elements);
  }
  return borders;
}

int element_of(const AxisTables& tables, double x) {
  const Eigen::VectorXd& borders = tables.borders;
  const double* begin = borders.data() + 1;
  const double* end = borders.data() + borders.size() - 1;
  return static_cast<int>(std::lower_bound(begin, end, x) - begin);
}

void interpolate_element(const AxisTables& tables, double x, InterpolationStencil& stencil,
                         bool with_derivative) {
  const int e = element_of(tables, x);
  const Transform transform = tables.label.transform;
  const double left = tables.borders[e];
  const double right = tables.borders[e + 1];
  const LagrangeBasis& local = *tables.local;
  stencil.first = e * (local.size() - 1);
  local.values(reference_place(transform, left, right, x), stencil.value);
  if (with_derivative) {
    stencil.derivative.noalias() = local.differentiation().transpose() * stencil.value;
    stencil.derivative *= 2.0 / transformed_distance(transform, left, right) * transform_slope(transform, x);
  }
}

}  // namespace samara::pgd
