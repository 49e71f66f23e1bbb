#include "samara/models/added_mass/ellipsoid.h"

#include <array>
#include <numbers>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/added_mass/ellipsoid_integrals.h"

namespace samara::models {

namespace {

void require_semi_axes(const Eigen::Vector3d& semi_axes, const char* where) {
  require_positive(semi_axes[0], "semi-axis a [m]", where);
  require_positive(semi_axes[1], "semi-axis b [m]", where);
  require_positive(semi_axes[2], "semi-axis c [m]", where);
}

}  // namespace

Eigen::Matrix<double, 6, 6> DiagonalAddedMass::matrix() const {
  Eigen::Matrix<double, 6, 6> K = Eigen::Matrix<double, 6, 6>::Zero();
  K.diagonal() << mass, inertia;
  return K;
}

Eigen::Vector3d ellipsoid_shape_integrals(const Eigen::Vector3d& semi_axes) {
  require_semi_axes(semi_axes, "ellipsoid_shape_integrals");
  // In units of the longest axis, so that no product over- or underflows.
  const Eigen::Vector3d s = semi_axes / semi_axes.maxCoeff();
  Eigen::Vector3d ABC;
  added_mass::ellipsoid_shape_integrals(s[0], s[1], s[2], ABC.data());
  return ABC;
}

DiagonalAddedMass ellipsoid_added_mass(const Eigen::Vector3d& semi_axes, double fluid_density) {
  require_semi_axes(semi_axes, "ellipsoid_added_mass");
  require_positive(fluid_density, "fluid density [kg/m^3]", "ellipsoid_added_mass");
  const double length = semi_axes.maxCoeff();
  const Eigen::Vector3d s = semi_axes / length;
  DiagonalAddedMass result;
  added_mass::ellipsoid_added_mass(s[0], s[1], s[2], result.mass.data(), result.inertia.data());
  const double m_f = 4.0 / 3.0 * std::numbers::pi * fluid_density * semi_axes.prod();
  result.mass *= m_f;
  result.inertia *= m_f * length * length;
  if (!result.mass.allFinite() || !result.inertia.allFinite()) {
    throw ArgumentError(
        fmt::format("ellipsoid_added_mass: semi-axes of {} x {} x {} m in a fluid of {} kg/m^3 "
                    "leave the range of doubles",
                    semi_axes[0], semi_axes[1], semi_axes[2], fluid_density));
  }
  return result;
}

}  // namespace samara::models
