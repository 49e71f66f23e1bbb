#pragma once

#include <optional>
#include <string>
#include <vector>

namespace samara::models {

/// A body in a fluid as people describe it, in a plan or on a command line; body_in_fluid() works it out.
struct BodyDescription {
  /// "ellipsoid", "disc" or "plate"; else a mesh file (mesh_file.h).
  std::string shape;
  /// m; semi-axes of an ellipsoid, radius and thickness of a disc, full sides of a plate. None of a mesh.
  std::vector<double> sizes = {};
  std::optional<double> unit = {};  ///< m, what one unit of a mesh file means
  double density = 0.0;             ///< of the body [kg/m^3]
  double fluid_density = 0.0;       ///< [kg/m^3]
  /// "panels", or "ellipsoid": of the one with the same extents. Empty: panels of a mesh, else ellipsoid.
  std::string added_mass = {};
};

}  // namespace samara::models
