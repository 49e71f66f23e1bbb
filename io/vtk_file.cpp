#include "samara/io/vtk_file.h"

#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"

namespace samara::io {

namespace {

/// VTK's numbers of the shapes of cells, by their corners.
int shape_of(Eigen::Index corners) {
  switch (corners) {
    case 2:
      return 3;  // VTK_LINE
    case 3:
      return 5;  // VTK_TRIANGLE
    case 4:
      return 10;  // VTK_TETRA
    default:
      throw ArgumentError(fmt::format("cells have {} corners, expected 2, 3 or 4", corners));
  }
}

/// Numbers, column by column, a column a line.
template <class Matrix>
void append_array(std::string& text, const char* type, const std::string& attributes, const Matrix& numbers) {
  fmt::format_to(std::back_inserter(text), "<DataArray type=\"{}\" {} format=\"ascii\">\n", type, attributes);
  for (Eigen::Index j = 0; j < numbers.cols(); ++j) {
    for (Eigen::Index i = 0; i < numbers.rows(); ++i)
      fmt::format_to(std::back_inserter(text), "{}{}", i == 0 ? "" : " ", numbers(i, j));
    text += '\n';
  }
  text += "</DataArray>\n";
}

void check_grid(const VtkGrid& grid, const std::vector<VtkField>& fields) {
  const Eigen::Index nodes = grid.points.cols();
  if (grid.points.rows() < 1 || grid.points.rows() > 3)
    throw ArgumentError(fmt::format("points have {} directions, expected 1 to 3", grid.points.rows()));
  if (!grid.points.allFinite()) throw ArgumentError("a point is not finite");
  if (grid.cells.size() > 0 && (grid.cells.minCoeff() < 0 || grid.cells.maxCoeff() >= nodes))
    throw ArgumentError(fmt::format("a corner of a cell is no node from 0 to {}", nodes - 1));
  for (const VtkField& field : fields) {
    if (field.values.size() != nodes)
      throw ArgumentError(fmt::format("\"{}\" has {} values, expected one for each of {} nodes", field.name,
                                      field.values.size(), nodes));
    if (!field.values.allFinite())
      throw ArgumentError(fmt::format("\"{}\" has a value that is not finite", field.name));
  }
}

constexpr const char* kHead =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"LittleEndian\">\n";

}  // namespace

std::string format_vtu(const VtkGrid& grid, const std::vector<VtkField>& fields) {
  check_grid(grid, fields);
  const Eigen::Index count = grid.cells.cols(), corners = grid.cells.rows();
  Eigen::MatrixXd points = Eigen::MatrixXd::Zero(3, grid.points.cols());
  points.topRows(grid.points.rows()) = grid.points;
  using Row = Eigen::Matrix<long, 1, Eigen::Dynamic>;
  Row offsets(count);
  for (Eigen::Index cell = 0; cell < count; ++cell) offsets[cell] = (cell + 1) * corners;

  std::string text = fmt::format(kHead, "UnstructuredGrid");
  text += fmt::format("<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
                      points.cols(), count);
  text += "<PointData>\n";
  for (const VtkField& field : fields)
    append_array(text, "Float64", fmt::format("Name=\"{}\"", escaped_for_markup(field.name)),
                 field.values.transpose());
  text += "</PointData>\n<Points>\n";
  append_array(text, "Float64", "NumberOfComponents=\"3\"", points);
  text += "</Points>\n<Cells>\n";
  append_array(text, "Int64", "Name=\"connectivity\"", grid.cells);
  append_array(text, "Int64", "Name=\"offsets\"", offsets);
  append_array(text, "UInt8", "Name=\"types\"", Row::Constant(count, shape_of(corners)));
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  return text;
}

std::string format_pvd(const std::vector<VtkStep>& steps) {
  std::string text = fmt::format(kHead, "Collection") + "<Collection>\n";
  for (const VtkStep& step : steps)
    text += fmt::format("<DataSet timestep=\"{}\" part=\"0\" file=\"{}\"/>\n", step.time,
                        escaped_for_markup(step.file));
  return text + "</Collection>\n</VTKFile>\n";
}

}  // namespace samara::io
