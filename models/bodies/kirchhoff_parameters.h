#pragma once

#include <map>
#include <string>

#include <Eigen/Core>

/// From the data of a body to the parameters of the model `kirchhoff_body`.
namespace samara::models {

/// A body and the fluid around it, in body axes about one origin. The matrix of added mass acts on (u, w):
/// linear velocity first, as in (P, L) = K (u, w).
struct KirchhoffBodyData {
  double mass = 0.0;                                             ///< [kg]
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();             ///< about the centre of mass [kg m^2]
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();      ///< [m]
  double displaced_mass = 0.0;                                   ///< of fluid [kg]
  Eigen::Vector3d centre_of_buoyancy = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Matrix<double, 6, 6> added_mass = Eigen::Matrix<double, 6, 6>::Zero();  ///< [kg, kg m, kg m^2]
};

/// Parameter values by name; g is left to its default. Inertia and added mass enter by their symmetric parts:
/// a panel method finds them symmetric to its discretisation error only.
/// @throws ArgumentError if something is not finite, mass is not positive, displaced mass is negative, or the
///   total inertia is not positive definite.
std::map<std::string, double> kirchhoff_parameters(const KirchhoffBodyData& body);

}  // namespace samara::models
