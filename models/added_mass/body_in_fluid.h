#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/models/bodies/body.h"
#include "samara/models/bodies/body_description.h"

/// From the description of a body to what its motion needs. In the library of mesh files (samara::mesh_files).
namespace samara::models {

enum class BodyShape { ellipsoid, disc, plate, mesh };

struct BodyInFluid {
  BodyShape shape = BodyShape::mesh;
  Body body;
  double fluid_density = 0.0;  ///< [kg/m^3]
  /// In body axes about the centre of mass, linear motions first [kg, kg m, kg m^2].
  Eigen::Matrix<double, 6, 6> added_mass = Eigen::Matrix<double, 6, 6>::Zero();
  bool by_panels = false;
  std::string panels = {};                 ///< how they were solved, in a sentence
  std::vector<std::string> warnings = {};  ///< of what looks like a mistake of units
};

/// The triangles of a mesh are divided for its panels, where there are fewer than 2000 (divided(), triangle_mesh.h).
/// @throws ArgumentError for sizes or densities that are no positive numbers, another number of sizes than the shape
///   has, a mesh without a unit, a shape with one, panels of a disc; InputError for a mesh file that is none or not
///   closed; NoResultError where panels have no solution
BodyInFluid body_in_fluid(const BodyDescription& description, const ProgressCallback& progress = {});

/// Parameters of the model `kirchhoff_body`, by name; g is left to its default.
std::map<std::string, double> kirchhoff_parameters(const BodyInFluid& body);

/// Numbers by which falling bodies are classified (scaling_numbers.h), of the largest and the smallest extent: fall
/// speed scale [m/s], the inertia ratio of the shape, and with a viscosity [Pa s] the Reynolds number of the fall.
std::map<std::string, double> scaling_numbers(const BodyInFluid& body, std::optional<double> viscosity = {});

}  // namespace samara::models
