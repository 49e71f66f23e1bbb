#pragma once

#include <array>

#include <Eigen/Core>

/// Integrals of 1/r and its derivative over a plane triangle, exact at every point, near or far, in the plane
/// of the triangle or out of it.
namespace samara::models::added_mass {

/// A triangle of a closed surface with what its integrals need.
struct Panel {
  Panel(const Eigen::Vector3d& p0, const Eigen::Vector3d& p1, const Eigen::Vector3d& p2);

  std::array<Eigen::Vector3d, 3> corner;
  Eigen::Vector3d normal;  ///< unit, outward for corners counter-clockwise seen from outside
  Eigen::Vector3d centroid;
  double area = 0.0;
  double radius = 0.0;                     ///< of the ball about the centroid that holds it
  std::array<double, 3> side;              ///< lengths, side k from corner k to corner k+1
  std::array<Eigen::Vector3d, 3> tangent;  ///< unit, along side k
  std::array<Eigen::Vector3d, 3> outward;  ///< unit, in the plane, across side k
  /// Gradient of the linear function that is 1 at corner k and 0 at the others, and normal x gradient.
  std::array<Eigen::Vector3d, 3> gradient, curl;
  Eigen::Matrix3d second_moment;  ///< Int (y-centroid)(y-centroid)^T dS / area
};

/// Over a panel seen from x, with r = |x-y|, d the height of x above its plane, x' the foot of x in it:
struct PanelIntegrals {
  double source = 0.0;             ///< Int 1/r dS
  Eigen::Vector3d source_moment;   ///< Int y/r dS
  double solid_angle = 0.0;        ///< Int d/r^3 dS, in (-2 pi, 2 pi)
  std::array<double, 3> dipole{};  ///< Int psi_k d/r^3 dS with the linear function psi_k of corner k
};

/// Edge by edge after D. R. Wilton et al., Potential integrals for uniform and linear source distributions on
/// polygonal and polyhedral domains, IEEE Trans. Antennas Propag. 32 (1984) 276-281; the solid angle after A.
/// van Oosterom and J. Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125-126.
PanelIntegrals integrate_panel(const Panel& panel, const Eigen::Vector3d& x);

}  // namespace samara::models::added_mass
