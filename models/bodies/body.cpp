#include "samara/models/bodies/body.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/bodies/size_check.h"
#include "samara/models/checks/parameter_warnings.h"

namespace samara::models {

namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using std::numbers::pi;

void require_density(double density, const char* where) {
  require_positive(density, "density of the solid [kg/m^3]", where);
}

/// A body symmetric to the three planes of its frame.
Body symmetric_body(double density, double volume, const Vector3d& moments_over_mass,
                    const Vector3d& half_extents) {
  Body body;
  body.density = density;
  body.volume = volume;
  body.mass = density * volume;
  body.principal = principal_axes(body.mass * Matrix3d(moments_over_mass.asDiagonal()));
  body.proxy_semi_axes = body.principal.axes.transpose().cwiseAbs() * half_extents;
  return body;
}

/// Of the orthonormal vectors spanning a space of dimension `size`, those next to the frame's axes: the
/// projections of the axes, longest first, made orthonormal.
template <class Block>
void align_with_frame(Block vectors) {
  const Eigen::MatrixXd span = vectors;
  for (Index k = 0; k < span.cols(); ++k) {
    Matrix3d projections = span * span.transpose();
    for (Index i = 0; i < k; ++i) {
      const Vector3d done = vectors.col(i);
      projections -= done * (done.transpose() * projections);
    }
    // Lengths that are equal but for round-off must not be told apart by it: the earlier axis wins.
    Index longest = 0;
    for (Index i = 1; i < 3; ++i) {
      if (projections.col(i).norm() > projections.col(longest).norm() + 1e-9) longest = i;
    }
    vectors.col(k) = projections.col(longest).normalized();
  }
}

void fix_signs(Matrix3d& axes) {
  for (Index k = 0; k < 2; ++k) {
    Index largest = 0;
    for (Index i = 1; i < 3; ++i) {
      if (std::abs(axes(i, k)) > std::abs(axes(largest, k)) + 1e-9) largest = i;
    }
    if (axes(largest, k) < 0.0) axes.col(k) = -axes.col(k);
  }
  axes.col(2) = axes.col(0).cross(axes.col(1));
}

/// Second moments Int y y^T dV and volume, centroid about an origin near the body.
struct PolyhedronMoments {
  double volume = 0.0;
  Vector3d first = Vector3d::Zero();
  Matrix3d second = Matrix3d::Zero();

  PolyhedronMoments(const TriangleMesh& mesh, const Vector3d& origin) {
    for (Index i = 0; i < mesh.triangles.cols(); ++i) {
      Matrix3d corners;
      for (int k = 0; k < 3; ++k) corners.col(k) = mesh.vertices.col(mesh.triangles(k, i)) - origin;
      // The tetrahedron from the origin to the triangle, with its sign.
      const double six_volumes = corners.determinant();
      const Vector3d sum = corners.rowwise().sum();
      volume += six_volumes / 6.0;
      first += six_volumes / 24.0 * sum;
      second += six_volumes / 120.0 * (corners * corners.transpose() + sum * sum.transpose());
    }
  }
};

Vector3d half_extents(const TriangleMesh& mesh, const Matrix3d& axes) {
  const Eigen::Matrix3Xd along = axes.transpose() * mesh.vertices;
  return 0.5 * (along.rowwise().maxCoeff() - along.rowwise().minCoeff());
}

}  // namespace

PrincipalAxes principal_axes(const Matrix3d& inertia) {
  const double size = inertia.cwiseAbs().maxCoeff();
  if (!inertia.allFinite() || (inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * size) {
    throw ArgumentError("principal_axes: the matrix of inertia is not finite and symmetric");
  }
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(0.5 * (inertia + inertia.transpose()));
  PrincipalAxes result{solver.eigenvectors(), solver.eigenvalues()};
  for (Index first = 0; first < 3;) {
    Index end = first + 1;
    while (end < 3 && result.moments[end] - result.moments[end - 1] <= 1e-9 * size) ++end;
    align_with_frame(result.axes.middleCols(first, end - first));
    first = end;
  }
  fix_signs(result.axes);
  return result;
}

Body ellipsoid_body(const Vector3d& semi_axes, double density) {
  require_sizes(semi_axes, "semi-axis along", "ellipsoid_body");
  require_density(density, "ellipsoid_body");
  const Vector3d s = semi_axes.cwiseAbs2() / 5.0;
  return symmetric_body(density, 4.0 / 3.0 * pi * semi_axes.prod(),
                        {s.y() + s.z(), s.z() + s.x(), s.x() + s.y()}, semi_axes);
}

Body disc_body(double radius, double thickness, double density) {
  require_positive(radius, "radius [m]", "disc_body");
  require_positive(thickness, "thickness [m]", "disc_body");
  require_density(density, "disc_body");
  const double across = radius * radius / 4.0 + thickness * thickness / 12.0;
  return symmetric_body(density, pi * radius * radius * thickness, {across, across, radius * radius / 2.0},
                        {radius, radius, 0.5 * thickness});
}

Body plate_body(const Vector3d& sides, double density) {
  require_sizes(sides, "side along", "plate_body");
  require_density(density, "plate_body");
  const Vector3d s = sides.cwiseAbs2() / 12.0;
  return symmetric_body(density, sides.prod(), {s.y() + s.z(), s.z() + s.x(), s.x() + s.y()}, 0.5 * sides);
}

Body mesh_body(const TriangleMesh& mesh, double density) {
  require_closed(mesh);
  require_density(density, "mesh_body");
  const Vector3d near = mesh.vertices.col(mesh.triangles(0, 0));
  const PolyhedronMoments there(mesh, near);
  Body body;
  body.density = density;
  body.volume = there.volume;
  body.mass = density * there.volume;
  body.centre_of_mass = near + there.first / there.volume;
  const Matrix3d second = density * PolyhedronMoments(mesh, body.centre_of_mass).second;
  body.principal = principal_axes(second.trace() * Matrix3d::Identity() - second);
  body.proxy_semi_axes = half_extents(mesh, body.principal.axes);
  return body;
}

std::vector<std::string> unit_warnings(const Body& body, double fluid_density) {
  std::vector<std::string> warnings = density_warnings(body.density, fluid_density);
  const double longest = 2.0 * body.proxy_semi_axes.maxCoeff(),
               shortest = 2.0 * body.proxy_semi_axes.minCoeff();
  if (longest > 10.0) {
    warnings.push_back(fmt::format("the body is {:g} m long: were its sizes given in mm or cm?", longest));
  }
  if (shortest < 1e-5) {
    warnings.push_back(
        fmt::format("the body is {:g} m thin: were its sizes scaled to metres twice?", shortest));
  }
  return warnings;
}

}  // namespace samara::models
