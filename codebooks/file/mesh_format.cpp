#include "samara/codebooks/file/mesh_format.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::codebooks {

void write_mesh(io::Hdf5Writer& file, const SpaceMesh& mesh) {
  file.create_group("/mesh");
  file.write_text_attribute("/mesh", "units", mesh.unit());
  file.write_texts("/mesh/directions", mesh.directions());
  file.write_matrix("/mesh/points", mesh.points().transpose());
  file.write_matrix("/mesh/cells", mesh.cells().transpose().cast<double>());
}

SpaceMesh read_mesh(const io::Hdf5Reader& file) {
  const Eigen::MatrixXd points = file.matrix("/mesh/points");
  const Eigen::MatrixXd cells = file.matrix("/mesh/cells");
  const auto is_place = [](double x) {
    return x == std::floor(x) && x >= 0.0 && x <= std::numeric_limits<int>::max();
  };
  for (const double corner : cells.reshaped()) {
    if (!is_place(corner))
      throw file.error("/mesh/cells", fmt::format("holds {}, expected numbers of nodes", corner));
  }
  try {
    return SpaceMesh(file.texts("/mesh/directions"), file.text_attribute("/mesh", "units"),
                     points.transpose(), cells.transpose().cast<int>());
  } catch (const ArgumentError& error) {
    throw file.error("/mesh", error.what());
  }
}

}  // namespace samara::codebooks
