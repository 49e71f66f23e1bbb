#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>

#include "samara/models/bodies/triangle_mesh.h"
#include "samara/models/interface/parametric_model.h"

/// Bodies as they are drawn: closed meshes of a few hundred triangles at most, in body axes.
namespace samara::models {

/// A shape about the origin, its normal along z [m].
/// @param shape "plate" (full sides along x, y, z), "disc" (radius, thickness) or "ellipsoid" (semi-axes)
/// @throws ArgumentError for another shape or number of sizes, and sizes that are not positive numbers
TriangleMesh shown_shape(const std::string& shape, std::span<const double> sizes);

/// The body of a model, as far as its parameters say what it looks like: semi_chord and semi_thickness, or beta (an
/// elliptic plate, as deep as its chord); chord and thickness, with an offset of the centre of mass; a, b and c (an
/// ellipsoid); diameter (a sphere); area and thickness (a disc).
/// @param parameters all of the model, complete
/// @returns nothing where they do not say it, or are not positive numbers
std::optional<TriangleMesh> shown_body(const std::map<std::string, double>& parameters);
/// The same. @param q of the free coordinates, as ParametricModel::parameters
std::optional<TriangleMesh> shown_body(const ParametricModel& model, std::span<const double> q);

}  // namespace samara::models
