#include "samara/models/bodies/shown_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/bodies/mesh_shapes.h"

namespace samara::models {

namespace {

/// An elliptic cylinder: semi-axes along `u` and `v`, height along u x v.
TriangleMesh elliptic_cylinder(const Eigen::Vector3d& u, const Eigen::Vector3d& v, double height) {
  constexpr int kSectors = 36;
  const Eigen::Vector3d half = 0.5 * height * u.cross(v).normalized();
  TriangleMesh mesh;
  mesh.vertices.resize(3, 2 * kSectors + 2);
  mesh.triangles.resize(3, 4 * kSectors);
  for (int k = 0; k < kSectors; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / kSectors;
    const Eigen::Vector3d rim = std::cos(angle) * u + std::sin(angle) * v;
    mesh.vertices.col(k) = rim - half;
    mesh.vertices.col(kSectors + k) = rim + half;
    const int next = (k + 1) % kSectors;
    mesh.triangles.col(4 * k) << k, next, kSectors + next;
    mesh.triangles.col(4 * k + 1) << k, kSectors + next, kSectors + k;
    mesh.triangles.col(4 * k + 2) << 2 * kSectors, next, k;
    mesh.triangles.col(4 * k + 3) << 2 * kSectors + 1, kSectors + k, kSectors + next;
  }
  mesh.vertices.col(2 * kSectors) = -half;
  mesh.vertices.col(2 * kSectors + 1) = half;
  return mesh;
}

TriangleMesh ellipsoid(const Eigen::Vector3d& semi_axes) {
  return icosahedral_ellipsoid_mesh(semi_axes, 4);
}

TriangleMesh disc(double radius, double thickness) {
  return elliptic_cylinder({radius, 0.0, 0.0}, {0.0, radius, 0.0}, thickness);
}

/// Of an elliptic section in the plane of x and z, as deep as its chord.
TriangleMesh elliptic_plate(double semi_chord, double semi_thickness) {
  return elliptic_cylinder({0.0, 0.0, semi_thickness}, {semi_chord, 0.0, 0.0}, 2.0 * semi_chord);
}

}  // namespace

TriangleMesh shown_shape(const std::string& shape, std::span<const double> sizes) {
  const std::size_t expected = shape == "disc" ? 2 : 3;
  if (shape != "plate" && shape != "disc" && shape != "ellipsoid") {
    throw ArgumentError(
        fmt::format("the shape of a body is \"{}\", expected plate, disc or ellipsoid", shape));
  }
  if (sizes.size() != expected) {
    throw ArgumentError(fmt::format("a {} has {} sizes, but {} are given: {} was expected", shape, expected,
                                    sizes.size(),
                                    shape == "plate"  ? "its full sides"
                                    : shape == "disc" ? "its radius and its thickness"
                                                      : "its semi-axes"));
  }
  for (const double size : sizes) {
    if (!(size > 0.0) || !std::isfinite(size))
      throw ArgumentError(fmt::format("a size of the {} is {}, expected more than 0", shape, size));
  }
  if (shape == "disc") return disc(sizes[0], sizes[1]);
  const Eigen::Vector3d all(sizes[0], sizes[1], sizes[2]);
  return shape == "plate" ? box_mesh(all, 1, 1, 1) : ellipsoid(all);
}

std::optional<TriangleMesh> shown_body(const std::map<std::string, double>& parameters) {
  const auto has = [&](const std::vector<std::string_view>& names) {
    return std::ranges::all_of(names, [&](std::string_view name) {
      const auto found = parameters.find(std::string(name));
      return found != parameters.end() && std::isfinite(found->second) && found->second > 0.0;
    });
  };
  const auto value = [&](const char* name) { return parameters.at(name); };
  if (has({"semi_chord", "semi_thickness"}))
    return elliptic_plate(value("semi_chord"), value("semi_thickness"));
  if (has({"inertia_ratio", "beta"})) return elliptic_plate(1.0, value("beta"));
  if (has({"chord", "thickness"})) {
    TriangleMesh mesh = box_mesh({value("chord"), value("chord"), value("thickness")}, 1, 1, 1);
    // The origin is the centre of mass, which lies at `offset` from the plate's centre.
    if (const auto offset = parameters.find("offset"); offset != parameters.end())
      mesh.vertices.row(0).array() -= offset->second;
    return mesh;
  }
  if (has({"a", "b", "c"})) return ellipsoid({value("a"), value("b"), value("c")});
  if (has({"diameter"})) return ellipsoid(Eigen::Vector3d::Constant(0.5 * value("diameter")));
  if (has({"area", "thickness"}))
    return disc(std::sqrt(value("area") / std::numbers::pi), value("thickness"));
  return std::nullopt;
}

std::optional<TriangleMesh> shown_body(const ParametricModel& model, std::span<const double> q) {
  const std::vector<double> values = model.parameters(q);
  std::map<std::string, double> by_name;
  for (std::size_t k = 0; k < values.size(); ++k)
    by_name[model.model().info().parameters[k].name] = values[k];
  return shown_body(by_name);
}

}  // namespace samara::models
