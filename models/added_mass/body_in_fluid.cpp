#include "samara/models/added_mass/body_in_fluid.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/added_mass/ellipsoid.h"
#include "samara/models/added_mass/panel_solver.h"
#include "samara/models/bodies/kirchhoff_parameters.h"
#include "samara/models/bodies/mesh_file.h"
#include "samara/models/bodies/mesh_shapes.h"
#include "samara/models/bodies/scaling_numbers.h"

namespace samara::models {

namespace {

BodyShape shape_of(const std::string& text) {
  if (text == "ellipsoid") return BodyShape::ellipsoid;
  if (text == "disc") return BodyShape::disc;
  return text == "plate" ? BodyShape::plate : BodyShape::mesh;
}

void require_sizes(const BodyDescription& description, std::size_t count, const char* meaning) {
  if (description.sizes.size() == count) return;
  throw ArgumentError(fmt::format("{} lengths for the shape \"{}\", expected {}: {}",
                                  description.sizes.size(), description.shape, count, meaning));
}

/// Layers of the rim as fine as the narrower rows of the faces, four or more: in-plane motions of thin plates lack a
/// tenth of their added mass with a single one. An even number keeps the symmetries of the box.
TriangleMesh plate_mesh(const Eigen::Vector3d& sides) {
  constexpr int kAcross = 16, kFewest = 4, kMost = 64;
  const double layers = kAcross * sides[2] / std::min(sides[0], sides[1]);
  const int half = static_cast<int>(std::ceil(0.5 * std::clamp<double>(layers, kFewest, kMost)));
  return box_mesh(sides, kAcross, kAcross, 2 * half);
}

/// Sets the body; @returns its mesh, empty of a disc.
TriangleMesh describe(const BodyDescription& description, BodyInFluid& result) {
  if (result.shape != BodyShape::mesh && description.unit)
    throw ArgumentError(
        fmt::format("a {} has a unit, which says what a number in a file means: expected of a mesh only",
                    description.shape));
  const std::vector<double>& sizes = description.sizes;
  switch (result.shape) {
    case BodyShape::ellipsoid:
      require_sizes(description, 3, "the semi-axes along x, y, z");
      result.body = ellipsoid_body(Eigen::Vector3d(sizes.data()), description.density);
      return ellipsoid_mesh(Eigen::Vector3d(sizes.data()), 16);
    case BodyShape::disc:
      require_sizes(description, 2, "radius and thickness");
      result.body = disc_body(sizes[0], sizes[1], description.density);
      if (result.by_panels)
        throw ArgumentError(
            "added mass by panels needs a mesh, which Samara has of plates, ellipsoids and files, not of "
            "discs");
      return {};
    case BodyShape::plate:
      require_sizes(description, 3, "the full sides along x, y, z");
      result.body = plate_body(Eigen::Vector3d(sizes.data()), description.density);
      return plate_mesh(Eigen::Vector3d(sizes.data()));
    case BodyShape::mesh:
      break;
  }
  std::error_code ignored;
  if (!std::filesystem::exists(description.shape, ignored) &&
      description.shape.find('.') == std::string::npos)
    throw ArgumentError(
        fmt::format("\"{}\" is no shape (ellipsoid, disc, plate) and no file", description.shape));
  if (!sizes.empty()) throw ArgumentError("a mesh has a size of its own, none is expected beside it");
  if (!description.unit)
    throw ArgumentError("a mesh needs a unit, the length that one unit of its file means (mm)");
  TriangleMesh mesh = read_mesh(description.shape, *description.unit, {.turn_outward = true});
  result.body = mesh_body(mesh, description.density);
  return mesh;
}

/// The mesh of a file is made to show a shape, which a few large triangles do: the flow about it takes as many panels
/// as those of plates and ellipsoids have.
constexpr int kFewestPanels = 2000;

void add_panels(const TriangleMesh& given, const ProgressCallback& progress, BodyInFluid& result) {
  PanelOptions options;
  options.progress = progress;
  const bool divides = result.shape == BodyShape::mesh && given.triangles.cols() < kFewestPanels;
  const TriangleMesh mesh = divides ? divided(given, kFewestPanels) : given;
  const PanelAddedMass panels =
      panel_added_mass(mesh, result.fluid_density, result.body.centre_of_mass, options);
  if (!panels.is_usable()) throw NoResultError(fmt::format("no added mass: {}", panels.message));
  result.panels = fmt::format(
      "added mass by {} panels{}: {}; before it was made symmetric its entries differed by {:.1g}",
      panels.panels,
      divides ? fmt::format(", into which the {} triangles were divided", given.triangles.cols())
              : std::string(),
      panels.message, panels.asymmetry);
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = result.body.principal.axes;
  result.added_mass = turn.transpose() * panels.matrix * turn;
}

}  // namespace

BodyInFluid body_in_fluid(const BodyDescription& description, const ProgressCallback& progress) {
  if (!description.added_mass.empty() && description.added_mass != "panels" &&
      description.added_mass != "ellipsoid")
    throw ArgumentError(
        fmt::format("added mass by \"{}\", expected \"panels\" or \"ellipsoid\"", description.added_mass));
  BodyInFluid result;
  result.shape = shape_of(description.shape);
  result.fluid_density = description.fluid_density;
  result.by_panels =
      description.added_mass.empty() ? result.shape == BodyShape::mesh : description.added_mass == "panels";
  const TriangleMesh mesh = describe(description, result);
  result.warnings = unit_warnings(result.body, result.fluid_density);
  if (result.by_panels) {
    add_panels(mesh, progress, result);
  } else {
    result.added_mass = ellipsoid_added_mass(result.body.proxy_semi_axes, result.fluid_density).matrix();
  }
  return result;
}

std::map<std::string, double> kirchhoff_parameters(const BodyInFluid& body) {
  return kirchhoff_parameters(KirchhoffBodyData{.mass = body.body.mass,
                                                .inertia = body.body.principal.moments.asDiagonal(),
                                                .displaced_mass = body.fluid_density * body.body.volume,
                                                .added_mass = body.added_mass});
}

std::map<std::string, double> scaling_numbers(const BodyInFluid& described, std::optional<double> viscosity) {
  const Body& body = described.body;
  const double fluid = described.fluid_density;
  const double length = 2.0 * body.proxy_semi_axes[0], thickness = 2.0 * body.proxy_semi_axes[2];
  std::map<std::string, double> numbers = {
      {"fall_speed_scale", fall_speed_scale(body.density, fluid, thickness)}};
  if (described.shape == BodyShape::disc) {
    numbers["inertia_ratio_of_disc"] = inertia_ratio_of_disc(body.density, fluid, length, thickness);
  } else if (described.shape == BodyShape::plate) {
    numbers["inertia_ratio_of_plate"] = inertia_ratio_of_plate(body.density, fluid, length, thickness);
  } else {
    numbers["inertia_ratio_of_ellipse"] =
        inertia_ratio_of_ellipse(body.density, fluid, 0.5 * length, 0.5 * thickness);
  }
  if (viscosity)
    numbers["fall_reynolds_number"] =
        fall_reynolds_number(body.density, fluid, length, thickness, *viscosity / fluid);
  return numbers;
}

}  // namespace samara::models
