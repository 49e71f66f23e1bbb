// Added mass by panels against the ellipsoid's, and its cost.
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "samara/models/added_mass/ellipsoid.h"
#include "samara/models/added_mass/panel_solver.h"
#include "samara/models/bodies/mesh_shapes.h"

namespace samara::benchmarks {

namespace {

using namespace models;
using Eigen::Vector3d;

const Vector3d kBody(4.0, 2.0, 1.0);
const Vector3d kLeaf(7.3, 4.2, 0.03);
/// The dissertation's time for 1280 panels (section 5.3).
constexpr double kPublishedSeconds = 0.053;

PanelOptions one_thread() {
  PanelOptions options;
  options.threads = 1;
  return options;
}

/// Largest relative error among entries of the diagonal.
double error(const PanelAddedMass& found, const Vector3d& semi_axes, const std::vector<int>& entries) {
  const auto exact = ellipsoid_added_mass(semi_axes, 1.0).matrix();
  double largest = 0.0;
  for (const int i : entries) largest = std::max(largest, std::abs(found.matrix(i, i) / exact(i, i) - 1.0));
  return largest;
}

double error(const TriangleMesh& mesh) {
  return error(panel_added_mass(mesh, 1.0), kBody, {0, 1, 2, 3, 4, 5});
}

void leaf(const Options& options) {
  const TriangleMesh mesh = ellipsoid_mesh(kLeaf, 12);  // corners on the leaf's surface
  const PanelAddedMass K = panel_added_mass(mesh, 1.0, Vector3d::Zero(), one_thread());
  print({kModels, "panel_leaf", "error_normal", error(K, kLeaf, {2, 3, 4})});
  print({kModels, "panel_leaf", "error_tangential", error(K, kLeaf, {0, 1, 5})});
  print({kModels, "panel_leaf", "panels", static_cast<double>(K.panels)});
  const double time =
      time_of([&] { panel_added_mass(mesh, 1.0, Vector3d::Zero(), one_thread()); }, options.quick ? 3 : 9);
  print({kModels, "panel_leaf", "time", time, "s"});
}

void panels_1280(const Options& options) {
  const TriangleMesh mesh = icosahedral_ellipsoid_mesh(kBody, 8, Placement::equal_volume);
  print({kModels, "panel_1280", "error", error(mesh)});
  print({kModels, "panel_1280", "error_inscribed", error(icosahedral_ellipsoid_mesh(kBody, 8))});
  const double time =
      time_of([&] { panel_added_mass(mesh, 1.0, Vector3d::Zero(), one_thread()); }, options.quick ? 3 : 15);
  print({kModels, "panel_1280", "time", time, "s", "published, 1280 panels", kPublishedSeconds / time});
}

/// From 320 to 5120 panels: the error falls as panels^(-order/2).
void order(const Options&) {
  const double coarse = error(icosahedral_ellipsoid_mesh(kBody, 4)),
               fine = error(icosahedral_ellipsoid_mesh(kBody, 16));
  print({kModels, "panel_order", "order", std::log2(coarse / fine) / 2.0});
}

void cost(const Options& options) {
  double first = 0.0, last = 0.0;
  int first_panels = 0, last_panels = 0;
  for (const int divisions : {8, 11, 16, 22}) {
    const TriangleMesh mesh = icosahedral_ellipsoid_mesh(kBody, divisions);
    PanelAddedMass K;
    const double time = time_of([&] { K = panel_added_mass(mesh, 1.0, Vector3d::Zero(), one_thread()); },
                                options.quick ? 1 : 3);
    print({kModels, "panel_cost", fmt::format("time_{}", K.panels), time, "s"});
    if (first_panels == 0) first = time, first_panels = K.panels;
    last = time, last_panels = K.panels;
  }
  print({kModels, "panel_cost", "exponent",
         std::log(last / first) / std::log(static_cast<double>(last_panels) / first_panels)});
}

}  // namespace

void run_panels(const Options& options) {
  if (options.wants("panel_leaf")) leaf(options);
  if (options.wants("panel_1280")) panels_1280(options);
  if (options.wants("panel_order")) order(options);
  if (options.wants("panel_cost")) cost(options);
}

}  // namespace samara::benchmarks
