#include "samara/codebooks/book/space_mesh.h"

#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>
#include <malloc.h>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"

using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::codebooks::SpaceMesh;

namespace {

/// The unit square in cells x cells squares of two triangles, nodes moved by a shear so that nothing is aligned.
SpaceMesh sheared_square(int cells) {
  const int side = cells + 1;
  Eigen::MatrixXd points(2, side * side);
  Eigen::MatrixXi corners(3, 2 * cells * cells);
  const auto node = [&](int i, int j) { return i + side * j; };
  for (int j = 0; j < side; ++j) {
    for (int i = 0; i < side; ++i) {
      const double y = static_cast<double>(j) / cells;
      points.col(node(i, j)) << static_cast<double>(i) / cells + 0.3 * y, y;
    }
  }
  int next = 0;
  for (int j = 0; j < cells; ++j) {
    for (int i = 0; i < cells; ++i) {
      corners.col(next++) << node(i, j), node(i + 1, j), node(i, j + 1);
      corners.col(next++) << node(i + 1, j + 1), node(i, j + 1), node(i + 1, j);
    }
  }
  return SpaceMesh({"x", "y"}, "m", points, corners);
}

}  // namespace

TEST_CASE("a mesh finds the cell of every point inside, where linear functions are exact with their slopes") {
  const SpaceMesh mesh = sheared_square(7);
  const auto linear = [](const Eigen::Vector2d& p) { return 2.0 + 3.0 * p[0] - 5.0 * p[1]; };
  samara::pgd::Random random(4);
  for (int i = 0; i < 500; ++i) {
    const double y = random.uniform();
    const Eigen::Vector2d p(random.uniform() + 0.3 * y, y);
    const auto place = mesh.find({p.data(), 2});
    REQUIRE(place);
    double value = 0.0;
    Eigen::RowVector2d slope = Eigen::RowVector2d::Zero();
    for (std::size_t c = 0; c < 3; ++c) {
      const double at_corner = linear(mesh.points().col(place->nodes[c]));
      value += place->weights[static_cast<Eigen::Index>(c)] * at_corner;
      slope += place->slopes.row(static_cast<Eigen::Index>(c)) * at_corner;
    }
    CHECK_THAT(value, WithinAbs(linear(p), 1e-13));
    CHECK((slope - Eigen::RowVector2d(3.0, -5.0)).norm() < 1e-12);
    CHECK(place->weights.minCoeff() > -1e-8);
  }
}

TEST_CASE("nodes and borders of a mesh are in it, what is beside is not") {
  const SpaceMesh mesh = sheared_square(5);
  for (int node = 0; node < mesh.node_count(); ++node) CHECK(mesh.find({mesh.points().col(node).data(), 2}));
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.1, 0.5), Eigen::Vector2d(1.2, 0.5),
                                   Eigen::Vector2d(-1e9, 0.0), Eigen::Vector2d(0.5, 1.01)})
    CHECK_FALSE(mesh.find({p.data(), 2}));
}

TEST_CASE("meshes of lines and of tetrahedra find points, too") {
  Eigen::MatrixXi line(2, 2);
  line << 0, 2, 2, 1;
  const SpaceMesh segments({"x"}, "m", Eigen::RowVector3d(0.0, 2.0, 0.5), line);
  const double on_line = 0.8;
  const auto between = segments.find({&on_line, 1});
  REQUIRE(between);
  CHECK(between->nodes == std::vector<int>{2, 1});
  CHECK_THAT(between->weights[1], WithinAbs(0.2, 1e-15));
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(3, 4);
  points.rightCols(3).setIdentity();
  const SpaceMesh solid({"x", "y", "z"}, "m", points, Eigen::Vector4i(0, 1, 2, 3));
  const Eigen::Vector3d inside(0.2, 0.3, 0.1), outside(0.5, 0.5, 0.5);
  const auto place = solid.find({inside.data(), 3});
  REQUIRE(place);
  CHECK((place->weights - Eigen::Vector4d(0.4, 0.2, 0.3, 0.1)).norm() < 1e-15);
  CHECK_FALSE(solid.find({outside.data(), 3}));
}

TEST_CASE("what is no mesh is refused in words") {
  const Eigen::MatrixXd points{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  const Eigen::Vector3i cell(0, 1, 2);
  const auto mesh = [&](const std::vector<std::string>& directions, const Eigen::MatrixXd& p,
                        const Eigen::MatrixXi& c) { return SpaceMesh(directions, "m", p, c); };
  CHECK_THROWS_WITH(mesh({"x", "x"}, points, cell), Contains("names that differ"));
  CHECK_THROWS_WITH(mesh({"x"}, points, cell), Contains("2 x 3"));
  CHECK_THROWS_WITH(mesh({"x", "y"}, points, Eigen::Vector4i(0, 1, 2, 0)), Contains("4 x 1"));
  CHECK_THROWS_WITH(mesh({"x", "y"}, points, Eigen::Vector3i(0, 1, 3)), Contains("corner 3"));
  CHECK_THROWS_WITH(mesh({"x", "y"}, points, Eigen::Vector3i(0, 1, 1)), Contains("no volume"));
  CHECK_THROWS_WITH(mesh({"x", "y"}, points * NAN, cell), Contains("not finite"));
  CHECK_THROWS_WITH(mesh({"x", "y"}, points * 5e-324, cell),
                    Contains("the extent 5e-324, expected at least 1e-290"));
  CHECK_THROWS_WITH(mesh({"x", "y=1"}, points, cell), Contains("\"y=1\", expected one without"));
  CHECK_THROWS_WITH(mesh({"x", "y\x1b[2J"}, points, cell), Contains("\\x1b[2J\", expected one without"));
  CHECK_THROWS_WITH(SpaceMesh({"x", "y"}, "parsec", points, cell), Contains("parsec"));
  CHECK_THROWS_WITH(SpaceMesh({"x", "y"}, "", points, cell), Contains("unit"));
  const double one = 1.0;
  CHECK_THROWS_AS(mesh({"x", "y"}, points, cell).find({&one, 1}), samara::ArgumentError);
}

TEST_CASE("a mesh of any size finds its points") {
  const Eigen::MatrixXd points{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  for (const double size : {1e-120, 1e-9, 1.0, 1e160, 1e300}) {
    CAPTURE(size);
    const SpaceMesh mesh({"x", "y"}, "m", size * points, Eigen::Vector3i(0, 1, 2));
    const Eigen::Vector2d inside = size * Eigen::Vector2d(0.2, 0.3),
                          outside = size * Eigen::Vector2d(0.6, 0.6);
    const auto place = mesh.find({inside.data(), 2});
    REQUIRE(place);
    CHECK((place->weights - Eigen::Vector3d(0.5, 0.2, 0.3)).norm() < 1e-14);
    CHECK_FALSE(mesh.find({outside.data(), 2}));
  }
}

TEST_CASE("cells in heaps over each other take no more memory than a mesh does") {
  // In the boxes of a grid of as many, each in each, they would be 3.6e9 numbers.
  const Eigen::MatrixXd points{{0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
  const Eigen::MatrixXi cells = Eigen::Vector3i(0, 1, 2).replicate(1, 60'000);
  const SpaceMesh mesh({"x", "y"}, "m", points, cells);
  const Eigen::Vector2d inside(0.2, 0.3), outside(0.6, 0.6);
  const auto in_use = [] {
    const struct mallinfo2 memory = mallinfo2();
    return memory.uordblks + memory.hblkhd;
  };
  const std::size_t before = in_use();
  REQUIRE(mesh.find({inside.data(), 2}));
  CHECK(in_use() < before + 64'000'000);
  CHECK_FALSE(mesh.find({outside.data(), 2}));
}

TEST_CASE("threads that look for the first point of a mesh at once all find it") {
  const SpaceMesh mesh = sheared_square(40);
  const Eigen::Vector2d inside(0.41, 0.37);
  std::atomic<int> found = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i) threads.emplace_back([&] { found += mesh.find({inside.data(), 2}) ? 1 : 0; });
  for (std::thread& thread : threads) thread.join();
  CHECK(found == 8);
}
