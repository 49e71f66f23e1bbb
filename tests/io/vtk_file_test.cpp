#include "samara/io/vtk_file.h"

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::io;
using Catch::Matchers::Contains;

namespace {

VtkGrid line() {
  VtkGrid grid{Eigen::RowVector3d(0.0, 0.1, 1.0), Eigen::MatrixXi(2, 2)};
  grid.cells << 0, 1, 1, 2;
  return grid;
}

}  // namespace

TEST_CASE("a grid is written with points in three directions, cells, their ends and shapes") {
  const std::string text = format_vtu(line(), {{"u[K]", Eigen::Vector3d(1.0, 1.0 / 3.0, -2.0)}});
  CHECK_THAT(text, Contains("<Piece NumberOfPoints=\"3\" NumberOfCells=\"2\">"));
  CHECK_THAT(text, Contains("Name=\"u[K]\" format=\"ascii\">\n1\n0.3333333333333333\n-2\n</DataArray>"));
  CHECK_THAT(text,
             Contains("NumberOfComponents=\"3\" format=\"ascii\">\n0 0 0\n0.1 0 0\n1 0 0\n</DataArray>"));
  CHECK_THAT(text, Contains("Name=\"connectivity\" format=\"ascii\">\n0 1\n1 2\n</DataArray>"));
  CHECK_THAT(text, Contains("Name=\"offsets\" format=\"ascii\">\n2\n4\n</DataArray>"));
  CHECK_THAT(text, Contains("Name=\"types\" format=\"ascii\">\n3\n3\n</DataArray>"));
}

TEST_CASE("names are escaped, and times listed") {
  CHECK_THAT(format_vtu(line(), {{"a<\"b\"&c", Eigen::Vector3d::Zero()}}),
             Contains("Name=\"a&lt;&quot;b&quot;&amp;c\""));
  const std::string text = format_pvd({{0.0, "a_0000.vtu"}, {0.5, "a_0001.vtu"}});
  CHECK_THAT(text, Contains("<DataSet timestep=\"0.5\" part=\"0\" file=\"a_0001.vtu\"/>"));
}

TEST_CASE("what is no grid or no field on it is refused") {
  VtkGrid grid = line();
  CHECK_THROWS_WITH(format_vtu(grid, {{"u", Eigen::Vector2d::Zero()}}), Contains("\"u\" has 2 values"));
  CHECK_THROWS_WITH(format_vtu(grid, {{"u", Eigen::Vector3d(0.0, 1.0, 1.0 / 0.0)}}), Contains("not finite"));
  grid.cells(0, 0) = 3;
  CHECK_THROWS_WITH(format_vtu(grid, {}), Contains("no node from 0 to 2"));
  grid.cells = Eigen::MatrixXi::Zero(5, 1);
  CHECK_THROWS_WITH(format_vtu(grid, {}), Contains("5 corners"));
}
