#include "samara/models/added_mass/panel_integrals.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace samara::models::added_mass {

using Eigen::Vector3d;

Panel::Panel(const Vector3d& p0, const Vector3d& p1, const Vector3d& p2) : corner{p0, p1, p2} {
  const Vector3d twice = (p1 - p0).cross(p2 - p0);
  area = 0.5 * twice.norm();
  normal = twice.normalized();
  centroid = (p0 + p1 + p2) / 3.0;
  second_moment.setZero();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d edge = corner[(k + 1) % 3] - corner[k];
    side[k] = edge.norm();
    tangent[k] = edge / side[k];
    outward[k] = tangent[k].cross(normal);
    const Vector3d from_centroid = corner[k] - centroid;
    radius = std::max(radius, from_centroid.norm());
    second_moment += from_centroid * from_centroid.transpose() / 12.0;
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t opposite = (k + 1) % 3;
    gradient[k] = -side[opposite] / (2.0 * area) * outward[opposite];
    curl[k] = normal.cross(gradient[k]);
  }
}

PanelIntegrals integrate_panel(const Panel& panel, const Vector3d& x) {
  std::array<Vector3d, 3> to;
  std::array<double, 3> R;
  for (std::size_t k = 0; k < 3; ++k) {
    to[k] = panel.corner[k] - x;
    R[k] = to[k].norm();
  }
  const double d = -to[0].dot(panel.normal);
  PanelIntegrals result;
  Vector3d sum_mf = Vector3d::Zero();  // Int (y-x')/r^3 dS = -sum_k outward_k Int 1/r dl
  Vector3d sum_mg = Vector3d::Zero();  // Int (y-x')/r dS = sum_k outward_k Int r dl
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double across = to[k].dot(panel.outward[k]);
    const double start = to[k].dot(panel.tangent[k]), end = start + panel.side[k];
    // Int 1/r dl = log((R'+R+L)/(R'+R-L)): infinite on the side itself, where it is multiplied by 0.
    const double around = R[k] + R[next];
    const double f = std::log((around + panel.side[k]) / std::max(around - panel.side[k], 1e-15 * around));
    result.source += across * f;
    sum_mf += f * panel.outward[k];
    sum_mg += 0.5 * (end * R[next] - start * R[k] + (across * across + d * d) * f) * panel.outward[k];
  }
  const double cosine_part =
      R[0] * R[1] * R[2] + to[0].dot(to[1]) * R[2] + to[1].dot(to[2]) * R[0] + to[2].dot(to[0]) * R[1];
  result.solid_angle = 2.0 * std::atan2(2.0 * panel.area * d, cosine_part);
  result.source -= d * result.solid_angle;
  const Vector3d foot = x - d * panel.normal;
  result.source_moment = result.source * foot + sum_mg;
  for (std::size_t k = 0; k < 3; ++k) {
    const double psi = 1.0 / 3.0 + panel.gradient[k].dot(foot - panel.centroid);
    result.dipole[k] = psi * result.solid_angle - d * panel.gradient[k].dot(sum_mf);
  }
  return result;
}

}  // namespace samara::models::added_mass
