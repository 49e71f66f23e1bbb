#include <cmath>

#include <catch2/catch.hpp>

#include "flow_cases.h"
#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/flow/grid/mesh_shape.h"
#include "samara/models/bodies/mesh_shapes.h"

using namespace samara::flow;
using namespace flow_cases;

namespace {

/// Open area of a unit square's grid with a body in it.
double open_area_of(const MacGrid& grid, const Openness& open) {
  double sum = 0.0;
  for (int j = 0; j < grid.cells[1]; ++j) {
    for (int i = 0; i < grid.cells[0]; ++i) sum += open.cell[static_cast<std::size_t>(grid.at(i, j))];
  }
  return sum * grid.spacing * grid.spacing;
}

}  // namespace

TEST_CASE("open cells leave out the area of the body", "[flow]") {
  const MacGrid grid(2, {64, 64, 1}, 1.0 / 64, Eigen::Vector3d::Zero());
  const Eigen::Vector3d middle(0.5, 0.5, 0.0);
  const Borders borders;
  const auto area = [&](Shape shape, double angle) {
    return 1.0 -
           open_area_of(grid, measure_openness(grid, borders, PlacedShape(std::move(shape), middle, angle)));
  };
  CHECK(area(rectangle_section(0.5, 0.25), 0.0) == Approx(0.125).margin(1e-12));
  CHECK(area(rectangle_section(0.5, 0.25), 0.5 * kPi) == Approx(0.125).margin(1e-12));
  CHECK(area(rectangle_section(0.5, 0.25), 0.4) == Approx(0.125).epsilon(0.005));
  CHECK(area(ellipse_section(0.3, 0.1), 0.7) == Approx(0.03 * kPi).epsilon(0.005));
  Eigen::Matrix2Xd corners(2, 4);
  corners << -0.2, 0.2, 0.2, -0.2, -0.1, -0.1, 0.1, 0.1;
  CHECK(area(polygon_section(corners), 0.4) == Approx(area(rectangle_section(0.4, 0.2), 0.4)).margin(1e-12));
}

TEST_CASE("a polygon is as thin as the widest circle within it, and takes of a stream what its outline does",
          "[flow]") {
  const auto polygon = [](std::vector<double> x, std::vector<double> y) {
    Eigen::Matrix2Xd corners(2, std::ssize(x));
    for (Eigen::Index k = 0; k < corners.cols(); ++k)
      corners.col(k) << x[static_cast<std::size_t>(k)], y[static_cast<std::size_t>(k)];
    return polygon_section(corners);
  };
  const auto frontal = [](const Shape& shape, double angle) {
    return PlacedShape(shape, {3.0, 1.0, 0.0}, angle).frontal_size();
  };
  const double h = std::sqrt(0.5);
  const Shape square = polygon({-0.15, 0.15, 0.15, -0.15}, {-0.15, -0.15, 0.15, 0.15});
  const Shape strip = polygon({0.0, 1.0, 1.0, 0.0}, {0.0, 0.0, 0.07, 0.07});
  const Shape diamond = polygon({-h, 0.0, h, 0.0}, {0.0, -h, 0.0, h});  // a unit square
  const Shape triangle = polygon({0.0, 3.0, 0.0}, {0.0, 0.0, 4.0});
  const Shape elbow = polygon({0, 2, 2, 0.4, 0.4, 0}, {0, 0, 0.3, 0.3, 2, 2});
  CHECK(square.thickness == Approx(0.3).epsilon(1e-12));
  CHECK(strip.thickness == Approx(0.07).epsilon(1e-12));
  CHECK(diamond.thickness == Approx(1.0).epsilon(1e-3));
  CHECK(triangle.thickness == Approx(2.0).epsilon(1e-3));  // radius (3 + 4 - 5)/2
  // It touches both outer sides and the inner corner: (0.4 - r)^2 + (0.3 - r)^2 = r^2.
  CHECK(elbow.thickness == Approx(1.4 - std::sqrt(0.96)).epsilon(1e-3));
  // A strip that is turned is as thin, down to what no grid resolves.
  for (const double thin : {0.1, 1e-3, 1e-4}) {
    const Eigen::Vector2d along(std::cos(0.4), std::sin(0.4)),
        across(-0.5 * thin * along.y(), 0.5 * thin * along.x());
    const Eigen::Vector2d a = -across, b = along - across, c = along + across, d = across;
    CHECK(polygon({a.x(), b.x(), c.x(), d.x()}, {a.y(), b.y(), c.y(), d.y()}).thickness ==
          Approx(thin).epsilon(kThicknessError).margin(3e-5));
  }
  // Corners that go around twice have no inside.
  CHECK_THROWS_WITH(polygon({0, 1, 1, 0, 0, 1, 1, 0}, {0, 0, 1, 1, 0, 0, 1, 1}),
                    Catch::Contains("radius of the widest circle within"));
  CHECK(triangle.volume == Approx(6.0));
  CHECK(frontal(diamond, 0.25 * kPi) == Approx(1.0));
  CHECK(frontal(diamond, 0.0) == Approx(2.0 * h));
  CHECK(frontal(triangle, 0.0) == Approx(4.0));
  CHECK(frontal(triangle, 0.5 * kPi) == Approx(3.0));
  CHECK(frontal(rectangle_section(1.0, 1.0), 0.25 * kPi) == Approx(2.0 * h));
  CHECK(frontal(ellipsoid_shape({0.5, 0.2, 0.3}), 0.0) == Approx(0.06 * kPi));
  // Nothing of it is outside the box about its place, which is that of its own box.
  const PlacedShape turned(triangle, Eigen::Vector3d::Zero(), 0.7);
  const Eigen::Vector3d half = turned.half_extent();
  for (int k = 0; k < 100; ++k) {
    const double along = -3.0 + 0.06 * k;
    CHECK(turned.distance({half.x() + 1e-9, along, 0.0}) > 0.0);
    CHECK(turned.distance({-half.x() - 1e-9, along, 0.0}) > 0.0);
    CHECK(turned.distance({along, half.y() + 1e-9, 0.0}) > 0.0);
    CHECK(turned.distance({along, -half.y() - 1e-9, 0.0}) > 0.0);
  }
}

TEST_CASE("a polygon whose edges cross is refused", "[flow]") {
  Eigen::Matrix2Xd corners(2, 4);
  corners << -0.5, 0.5, 0.4, -0.5, -0.2, -0.2, 0.2, 0.3;
  CHECK_NOTHROW(polygon_section(corners));
  corners.col(2).swap(corners.col(3));
  CHECK_THROWS_WITH(polygon_section(corners), Catch::Contains("the edges from corners 2 and 4 cross"));
}

TEST_CASE("distances from an ellipsoid are those to the nearest of many points on it", "[flow]") {
  const Eigen::Vector3d axes(1.0, 0.4, 0.2);
  const Shape shape = ellipsoid_shape(axes);
  const std::vector<Eigen::Vector3d> points = {{1.5, 0.3, 0.2}, {0.1, 0.05, 0.05}, {0.5, 0.0, 0.0},
                                               {0.0, 0.0, 0.0}, {0.0, 0.7, 0.4},   {0.9, 0.0, 0.0}};
  for (const Eigen::Vector3d& point : points) {
    double nearest = 1e30;
    for (int a = 0; a <= 800; ++a) {
      for (int b = 0; b < 800; ++b) {
        const double polar = kPi * a / 800, around = 2 * kPi * b / 800;
        const Eigen::Vector3d on(axes.x() * std::cos(polar), axes.y() * std::sin(polar) * std::cos(around),
                                 axes.z() * std::sin(polar) * std::sin(around));
        nearest = std::min(nearest, (point - on).norm());
      }
    }
    const double inside = (point.array() / axes.array()).square().sum() < 1.0 ? -1.0 : 1.0;
    INFO(point.transpose());
    CHECK(shape.distance(point) == Approx(inside * nearest).margin(1e-4));
  }
}

TEST_CASE("distances from a mesh of a box are those from the box", "[flow]") {
  const Eigen::Vector3d sides(1.0, 0.25, 0.5);
  const Shape box = box_shape(sides), mesh = mesh_shape(samara::models::box_mesh(2.0 * sides, 4, 3, 2), 0.25);
  CHECK((mesh.half - box.half).norm() < 1e-12);
  CHECK(mesh.volume == Approx(0.125));
  const PlacedShape turned_mesh(mesh, {1, 2, 3}, 0.4), turned_box(box, {1, 2, 3}, 0.4);
  CHECK((turned_mesh.half_extent() - turned_box.half_extent()).norm() < 1e-12);
  CHECK(turned_mesh.frontal_size() == Approx(turned_box.frontal_size()));
  samara::Stream random(5, 0);
  for (int point = 0; point < 2000; ++point) {
    const Eigen::Vector3d x(1.6 * random.uniform() - 0.8, random.uniform() - 0.5,
                            1.2 * random.uniform() - 0.6);
    INFO(x.transpose());
    REQUIRE(mesh.distance(x) == Approx(box.distance(x)).margin(1e-9));
  }
  // Nearest to corners and edges of several triangles.
  CHECK(mesh.distance({0.6, 0.225, 0.35}) == Approx(std::sqrt(0.03)).epsilon(1e-9));
  CHECK_THROWS_AS(mesh_shape(samara::models::TriangleMesh{}, 0.1), samara::ArgumentError);
}

TEST_CASE("a body thinner than two cells, or at the border, is refused with the cells that it takes",
          "[flow]") {
  const auto march = [](double thickness, double place) {
    FlowMarch({.grid = MacGrid(2, {64, 64, 1}, 1.0 / 16, Eigen::Vector3d::Zero()),
               .borders = stream(),
               .body = PlacedShape(rectangle_section(1.0, thickness), {place, 2.0, 0.0}, 0.0),
               .viscosity = 0.01});
  };
  CHECK_NOTHROW(march(0.125, 2.0));
  CHECK_THROWS_WITH(march(0.1, 2.0),
                    "the body is 0.1 thin, less than two cells of 0.0625: expected cells of at most 0.05");
  CHECK_THROWS_WITH(march(0.125, 0.6),
                    "the body comes within 0.1 of a border, expected at least 0.25, four cells");
}
