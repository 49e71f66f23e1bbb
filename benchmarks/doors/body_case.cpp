/// `samara body` of a mesh: from a file to mass, inertia and added mass.
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <fmt/format.h>
#include <unistd.h>

#include "cases.h"
#include "child.h"
#include "samara/models/bodies/mesh_shapes.h"

namespace samara::benchmarks::doors {

namespace {

/// A leaf of 70 by 30 mm, 0.6 mm thick, bent along its length, as an OBJ file in millimetres.
void write_leaf(const std::filesystem::path& file) {
  models::TriangleMesh mesh = models::ellipsoid_mesh({35.0, 15.0, 0.3}, 14);
  for (Eigen::Index k = 0; k < mesh.vertices.cols(); ++k)
    mesh.vertices(2, k) += 0.004 * mesh.vertices(0, k) * mesh.vertices(0, k);
  std::ofstream out(file);
  for (Eigen::Index k = 0; k < mesh.vertices.cols(); ++k)
    out << fmt::format("v {} {} {}\n", mesh.vertices(0, k), mesh.vertices(1, k), mesh.vertices(2, k));
  for (Eigen::Index k = 0; k < mesh.triangles.cols(); ++k)
    out << fmt::format("f {} {} {}\n", mesh.triangles(0, k) + 1, mesh.triangles(1, k) + 1,
                       mesh.triangles(2, k) + 1);
  print({kBench, "body_leaf", "panels", static_cast<double>(mesh.triangles.cols())});
}

}  // namespace

void body_case(const Options& options) {
  if (!options.wants("body_leaf")) return;
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("samara_leaf_{}", getpid());
  std::filesystem::create_directories(folder);
  const std::string leaf = folder / "leaf.obj";
  write_leaf(leaf);
  const double seconds = time_of(
      [&] {
        if (wait_for(start_samara({"body", leaf, "--unit", "mm", "--density", "700", "--fluid", "1.2"})) != 0)
          throw std::runtime_error("samara body failed");
      },
      options.quick ? 1 : 5, 0.0);
  print({kBench, "body_leaf", "time", seconds, "s"});
  std::filesystem::remove_all(folder);
}

}  // namespace samara::benchmarks::doors
