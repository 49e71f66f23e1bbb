#pragma once

#include <map>
#include <string>

#include <Eigen/Core>

/// The check problem of free motion: an ellipsoid 4:2:1 of density 2 in a fluid of density 1 (Kirchhoff's
/// equations, total inertia m E + K11 and I + K22), starting with u = w = (1, 1, 1) from the origin, R = 1.
inline Eigen::Matrix<double, 6, 6> ellipsoid_421_inertia() {
  constexpr double kFluidMass = 33.510321638291124;  // 4/3 pi 4 2 1
  Eigen::Matrix<double, 6, 1> diagonal;
  diagonal << 2.12657071758692307, 2.39817213373437774, 3.5180612775507823, 2.40619816083618723,
      10.1137263923705189, 8.58072194276019189;
  return (kFluidMass * diagonal).asDiagonal();
}

/// The same as parameters and start of the model immersed_body: no gravity, no quasi-steady forces.
inline std::map<std::string, double> ellipsoid_421_values() {
  return {{"a", 4.0},     {"b", 2.0},     {"c", 1.0},     {"density", 2.0}, {"fluid_density", 1.0},
          {"g", 0.0},     {"C_D0", 0.0},  {"C_D90", 0.0}, {"C_T", 0.0},     {"C_R", 0.0},
          {"C_w", 0.0},   {"ux(0)", 1.0}, {"uy(0)", 1.0}, {"uz(0)", 1.0},   {"wx(0)", 1.0},
          {"wy(0)", 1.0}, {"wz(0)", 1.0}};
}
