#include "samara/pgd/axes/axis_forms.h"

#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/pgd/axes/axis_elements.h"
#include "samara/pgd/axes/quadrature.h"

namespace samara::pgd {

namespace {

double checked_value(const Axis& axis, const AxisFunction& f, double x) {
  const double value = f(x);
  if (!std::isfinite(value)) {
    throw ArgumentError(
        fmt::format("the coefficient is {} at {} = {}, expected a finite number", value, axis.name(), x));
  }
  return value;
}

/// Calls visit(weight * f(x), stencil) at all quadrature points.
template <class Visit>
void integrate(const Axis& axis, const AxisFunction& f, bool with_derivative, Visit visit) {
  // Exact for two basis functions and a coefficient of their degree; the slope of a transform, which is no
  // polynomial, takes twelve points more in every panel.
  const int more = axis.transform() == Transform::none ? 3 : 15;
  const QuadratureRule rule = gauss_legendre(3 * axis.degree() / 2 + more);
  InterpolationStencil stencil = axis.make_stencil();
  const Transform transform = axis.transform();
  for (Eigen::Index e = 0; e + 1 < axis.borders().size(); ++e) {
    // Where the basis is polynomial in s = T(x), the rule is one in s: dx = ds / (dT/dx).
    const std::vector<double> panels = panel_borders(transform, axis.borders()[e], axis.borders()[e + 1]);
    for (std::size_t p = 1; p < panels.size(); ++p) {
      const double half = 0.5 * transformed_distance(transform, panels[p - 1], panels[p]);
      for (Eigen::Index q = 0; q < rule.nodes.size(); ++q) {
        const double x = transformed_advance(transform, panels[p - 1], half * (1.0 + rule.nodes[q]));
        axis.interpolate(x, stencil, with_derivative);
        visit(half * rule.weights[q] / transform_slope(transform, x) * checked_value(axis, f, x), stencil);
      }
    }
  }
}

using Rows = Eigen::VectorXd InterpolationStencil::*;

SparseMatrix bilinear_form(const Axis& axis, const AxisFunction& f, Rows test, Rows trial) {
  if (test == trial && test == &InterpolationStencil::derivative)
    static_cast<void>(axis.stiffness());  // throws if it diverges
  std::vector<Eigen::Triplet<double>> triplets;
  const bool with_derivative =
      test == &InterpolationStencil::derivative || trial == &InterpolationStencil::derivative;
  integrate(axis, f, with_derivative, [&](double weight, const InterpolationStencil& stencil) {
    const Eigen::VectorXd& rows = stencil.*test;
    const Eigen::VectorXd& cols = stencil.*trial;
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
      for (Eigen::Index j = 0; j < cols.size(); ++j) {
        triplets.emplace_back(stencil.first + i, stencil.first + j, weight * rows[i] * cols[j]);
      }
    }
  });
  SparseMatrix form(axis.size(), axis.size());
  form.setFromTriplets(triplets.begin(), triplets.end());
  return form;
}

}  // namespace

SparseMatrix weighted_mass(const Axis& axis, const AxisFunction& f) {
  return bilinear_form(axis, f, &InterpolationStencil::value, &InterpolationStencil::value);
}

SparseMatrix weighted_mass(const Axis& axis, const Eigen::VectorXd& values) {
  return weighted_mass(axis, interpolated(axis, values));
}

SparseMatrix weighted_gradient(const Axis& axis, const AxisFunction& f) {
  return bilinear_form(axis, f, &InterpolationStencil::value, &InterpolationStencil::derivative);
}

SparseMatrix weighted_gradient(const Axis& axis, const Eigen::VectorXd& values) {
  return weighted_gradient(axis, interpolated(axis, values));
}

SparseMatrix weighted_stiffness(const Axis& axis, const AxisFunction& f) {
  return bilinear_form(axis, f, &InterpolationStencil::derivative, &InterpolationStencil::derivative);
}

SparseMatrix weighted_stiffness(const Axis& axis, const Eigen::VectorXd& values) {
  return weighted_stiffness(axis, interpolated(axis, values));
}

Eigen::VectorXd load_vector(const Axis& axis, const AxisFunction& f) {
  Eigen::VectorXd load = Eigen::VectorXd::Zero(axis.size());
  integrate(axis, f, false, [&](double weight, const InterpolationStencil& stencil) {
    load.segment(stencil.first, stencil.value.size()) += weight * stencil.value;
  });
  return load;
}

Eigen::VectorXd point_load(const Axis& axis, double x) {
  if (!axis.contains(x)) {
    throw ArgumentError(
        fmt::format("the point {} = {} is not in [{}, {}]", axis.name(), x, axis.lower(), axis.upper()));
  }
  Eigen::VectorXd load = Eigen::VectorXd::Zero(axis.size());
  InterpolationStencil stencil = axis.make_stencil();
  axis.interpolate(x, stencil, false);
  load.segment(stencil.first, stencil.value.size()) = stencil.value;
  return load;
}

Eigen::VectorXd nodal_values(const Axis& axis, const AxisFunction& f) {
  return axis.nodes().unaryExpr([&](double x) { return checked_value(axis, f, x); });
}

AxisFunction interpolated(const Axis& axis, const Eigen::VectorXd& values) {
  if (values.size() != axis.size()) {
    throw ArgumentError(
        fmt::format("{} nodal values on axis \"{}\" of {} nodes", values.size(), axis.name(), axis.size()));
  }
  return [axis, values](double x) {
    InterpolationStencil stencil = axis.make_stencil();
    axis.interpolate(x, stencil, false);
    return stencil.value.dot(values.segment(stencil.first, stencil.value.size()));
  };
}

}  // namespace samara::pgd
