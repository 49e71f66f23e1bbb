#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "assignments.h"
#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/models/added_mass/ellipsoid.h"
#include "samara/models/added_mass/panel_solver.h"
#include "samara/models/bodies/body.h"
#include "samara/models/bodies/kirchhoff_parameters.h"
#include "samara/models/bodies/mesh_file.h"
#include "samara/models/bodies/mesh_shapes.h"
#include "samara/models/bodies/scaling_numbers.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// What the shape is called, and how many sizes say it.
enum class Shape { ellipsoid, disc, plate, mesh };

Shape shape_of(const std::string& text) {
  if (text == "ellipsoid") return Shape::ellipsoid;
  if (text == "disc") return Shape::disc;
  return text == "plate" ? Shape::plate : Shape::mesh;
}

struct DescribedBody {
  Shape shape = Shape::mesh;
  std::vector<double> sizes;  ///< m, as given
  models::Body body;
  models::TriangleMesh mesh;  ///< of plates, ellipsoids and files
};

std::vector<double> sizes_of(const BodyArguments& arguments, std::size_t count, const char* meaning) {
  if (arguments.sizes.size() != count)
    throw ArgumentError(fmt::format("--size has {} lengths for a {}, expected {}: {}", arguments.sizes.size(),
                                    arguments.body, count, meaning));
  std::vector<double> sizes;
  for (const std::string& text : arguments.sizes) sizes.push_back(number_or_quantity("--size", text, "m"));
  return sizes;
}

DescribedBody described(const BodyArguments& arguments) {
  const double density = number_or_quantity("--density", arguments.density, "kg/m^3");
  DescribedBody result{.shape = shape_of(arguments.body), .sizes = {}, .body = {}, .mesh = {}};
  if (result.shape != Shape::mesh && !arguments.unit.empty())
    throw ArgumentError("--unit says what a number in a file means: expected with a mesh only");
  switch (result.shape) {
    case Shape::ellipsoid: {
      result.sizes = sizes_of(arguments, 3, "the semi-axes along x, y, z");
      const Eigen::Vector3d axes(result.sizes.data());
      result.body = models::ellipsoid_body(axes, density);
      result.mesh = models::ellipsoid_mesh(axes, 16);
      break;
    }
    case Shape::disc:
      result.sizes = sizes_of(arguments, 2, "radius and thickness");
      result.body = models::disc_body(result.sizes[0], result.sizes[1], density);
      if (arguments.added_mass == "panels")
        throw ArgumentError(
            "--added-mass panels needs a mesh, which Samara has of plates, ellipsoids and files, not of "
            "discs");
      break;
    case Shape::plate: {
      result.sizes = sizes_of(arguments, 3, "the full sides along x, y, z");
      const Eigen::Vector3d sides(result.sizes.data());
      result.body = models::plate_body(sides, density);
      result.mesh = models::box_mesh(sides, 16, 16);
      break;
    }
    case Shape::mesh: {
      if (!std::filesystem::exists(arguments.body) && arguments.body.find('.') == std::string::npos)
        throw ArgumentError(
            fmt::format("\"{}\" is no shape (ellipsoid, disc, plate) and no file", arguments.body));
      if (!arguments.sizes.empty())
        throw ArgumentError("--size is of shapes: a mesh has its own, see --unit");
      if (arguments.unit.empty())
        throw ArgumentError("a mesh needs --unit, the length that one unit of its file means (mm)");
      const double unit = number_or_quantity("--unit", "1 " + arguments.unit, "m");
      result.mesh = models::read_mesh(arguments.body, unit, {.turn_outward = true});
      result.body = models::mesh_body(result.mesh, density);
      break;
    }
  }
  return result;
}

/// In body axes, about the centre of mass.
Matrix6 by_panels(const DescribedBody& described, double fluid_density) {
  models::PanelOptions options;
  options.progress = progress_line();
  const models::PanelAddedMass panels =
      models::panel_added_mass(described.mesh, fluid_density, described.body.centre_of_mass, options);
  clear_progress();
  if (!panels.is_usable()) throw NoResultError(fmt::format("no added mass: {}", panels.message));
  narrate(
      fmt::format("added mass by {} panels: {}; before it was made symmetric its entries differed by {:.1g}",
                  panels.panels, panels.message, panels.asymmetry));
  Matrix6 turn = Matrix6::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = described.body.principal.axes;
  return turn.transpose() * panels.matrix * turn;
}

/// Numbers by which falling bodies are classified, of the largest and the smallest extent.
std::map<std::string, double> scaling_numbers(const DescribedBody& described, double fluid_density,
                                              std::optional<double> viscosity) {
  const models::Body& body = described.body;
  const double length = 2.0 * body.proxy_semi_axes[0], thickness = 2.0 * body.proxy_semi_axes[2];
  std::map<std::string, double> numbers = {
      {"fall_speed_scale", models::fall_speed_scale(body.density, fluid_density, thickness)}};
  if (described.shape == Shape::disc) {
    numbers["inertia_ratio_of_disc"] =
        models::inertia_ratio_of_disc(body.density, fluid_density, length, thickness);
  } else if (described.shape == Shape::plate) {
    numbers["inertia_ratio_of_plate"] =
        models::inertia_ratio_of_plate(body.density, fluid_density, length, thickness);
  } else {
    numbers["inertia_ratio_of_ellipse"] =
        models::inertia_ratio_of_ellipse(body.density, fluid_density, 0.5 * length, 0.5 * thickness);
  }
  if (viscosity)
    numbers["fall_reynolds_number"] = models::fall_reynolds_number(body.density, fluid_density, length,
                                                                   thickness, *viscosity / fluid_density);
  return numbers;
}

template <class Matrix>
Json rows_of(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    Json row = Json::array();
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) row.push_back(matrix(i, j));
    rows.push_back(std::move(row));
  }
  return rows;
}

template <class Vector>
Json list_of(const Vector& vector) {
  return Json(std::vector<double>(vector.begin(), vector.end()));
}

std::string toml_of(const std::map<std::string, double>& parameters) {
  std::string text = "model = \"kirchhoff_body\"\n\n[fixed]\n";
  for (const auto& [name, value] : parameters) text += fmt::format("{} = {}\n", name, value);
  return text;
}

std::string words_of(const models::Body& body, const Matrix6& added,
                     const std::map<std::string, double>& numbers) {
  const auto three = [](const auto& v, const char* unit) {
    return fmt::format("{:.6g}, {:.6g}, {:.6g} {}", v[0], v[1], v[2], unit);
  };
  std::string text = fmt::format("mass            {:.6g} kg, volume {:.6g} m^3\n", body.mass, body.volume);
  text +=
      fmt::format("centre of mass  {}, in the frame of the description\n", three(body.centre_of_mass, "m"));
  text +=
      fmt::format("inertia         {}, about it, along body axes\n", three(body.principal.moments, "kg m^2"));
  for (int k = 0; k < 3; ++k)
    text +=
        fmt::format("body {}          {}\n", "xyz"[k], three(body.principal.axes.col(k), "of that frame"));
  text += fmt::format("half extents    {}, of the proxy ellipsoid\n", three(body.proxy_semi_axes, "m"));
  const Eigen::Vector3d linear = added.diagonal().head<3>(), angular = added.diagonal().tail<3>();
  text +=
      fmt::format("added mass      {}\nadded inertia   {}\n", three(linear, "kg"), three(angular, "kg m^2"));
  for (const auto& [name, value] : numbers) text += fmt::format("{} = {:.6g}\n", name, value);
  return text;
}

}  // namespace

int run(const BodyArguments& arguments) {
  const double fluid_density = number_or_quantity("--fluid", arguments.fluid, "kg/m^3");
  std::optional<double> viscosity;
  if (!arguments.viscosity.empty())
    viscosity = number_or_quantity("--viscosity", arguments.viscosity, "Pa s");
  const DescribedBody described = apps::described(arguments);
  const models::Body& body = described.body;
  for (const std::string& sentence : models::unit_warnings(body, fluid_density)) warn(sentence);
  const bool is_mesh = described.shape == Shape::mesh;
  const bool has_panels = arguments.added_mass.empty() ? is_mesh : arguments.added_mass == "panels";
  const Matrix6 added = has_panels
                            ? by_panels(described, fluid_density)
                            : models::ellipsoid_added_mass(body.proxy_semi_axes, fluid_density).matrix();
  const std::map<std::string, double> numbers = scaling_numbers(described, fluid_density, viscosity);
  const std::map<std::string, double> parameters =
      models::kirchhoff_parameters({.mass = body.mass,
                                    .inertia = body.principal.moments.asDiagonal(),
                                    .displaced_mass = fluid_density * body.volume,
                                    .added_mass = added});
  if (arguments.toml) {
    print(toml_of(parameters));
  } else if (arguments.json) {
    Json object = {{"schema", "samara-body/1"},
                   {"mass", body.mass},
                   {"volume", body.volume},
                   {"density", body.density},
                   {"fluid_density", fluid_density},
                   {"centre_of_mass", list_of(body.centre_of_mass)},
                   {"inertia", list_of(body.principal.moments)},
                   {"body_axes", rows_of(body.principal.axes)},
                   {"proxy_semi_axes", list_of(body.proxy_semi_axes)},
                   {"added_mass", rows_of(added)},
                   {"added_mass_by", has_panels ? "panels" : "ellipsoid"},
                   {"scaling_numbers", numbers},
                   {"kirchhoff_body", parameters}};
    print(object);
  } else {
    print(words_of(body, added, numbers));
  }
  return kDone;
}

}  // namespace samara::apps
