#pragma once

#include <Eigen/Core>

#include "samara/pgd/axes/axis.h"

namespace samara::pgd {

/// Value or derivative of the nodal values `u` at x.
inline double evaluate(const Axis& axis, const Eigen::VectorXd& u, double x, bool derivative = false) {
  InterpolationStencil stencil = axis.make_stencil();
  axis.interpolate(x, stencil, true);
  const Eigen::VectorXd& weights = derivative ? stencil.derivative : stencil.value;
  return weights.dot(u.segment(stencil.first, axis.stencil_size()));
}

}  // namespace samara::pgd
