#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

/// Writing of fields on meshes for ParaView and other readers of VTK's XML formats, with numbers as text that reads
/// back to the same bits. Reference: VTK File Formats, Kitware,
/// https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html
namespace samara::io {

struct VtkGrid {
  Eigen::MatrixXd points;  ///< 1 to 3 directions x nodes; those that are missing are zero
  /// Corners x cells: lines (2), triangles (3) or tetrahedra (4), by numbers of nodes.
  Eigen::MatrixXi cells;
};

/// One number per node.
struct VtkField {
  std::string name;
  Eigen::VectorXd values;
};

/// An unstructured grid and fields on it: the text of a .vtu file.
/// @throws ArgumentError if cells have not 2 to 4 corners, a corner is no node, a field has another number of
/// values than there are nodes, or a number is not finite
std::string format_vtu(const VtkGrid& grid, const std::vector<VtkField>& fields);

struct VtkStep {
  double time = 0.0;
  std::string file;  ///< relative to the collection
};

/// Files of a time series: the text of a .pvd file.
std::string format_pvd(const std::vector<VtkStep>& steps);

}  // namespace samara::io
