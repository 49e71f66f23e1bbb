#include "samara/models/bodies/kirchhoff_parameters.h"

#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/bodies/cross_matrix.h"

namespace samara::models {

namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Matrix6 body_inertia(const KirchhoffBodyData& body) {
  const Eigen::Matrix3d r = cross_matrix(body.centre_of_mass);
  Matrix6 matrix;
  matrix << body.mass * Eigen::Matrix3d::Identity(), -body.mass * r, body.mass * r,
      body.inertia - body.mass * r * r;
  return matrix;
}

void check(const KirchhoffBodyData& body) {
  const bool finite = body.inertia.allFinite() && body.centre_of_mass.allFinite() &&
                      body.centre_of_buoyancy.allFinite() && body.added_mass.allFinite();
  if (!finite) throw ArgumentError("the data of the Kirchhoff body hold a value that is not finite");
  require_positive(body.mass, "the mass of the Kirchhoff body");
  require_not_negative(body.displaced_mass, "the displaced mass of the Kirchhoff body");
  const Eigen::MatrixXd total = body_inertia(body) + body.added_mass;
  if (Eigen::LLT<Eigen::MatrixXd>((total + total.transpose()) / 2.0).info() != Eigen::Success) {
    throw ArgumentError("the inertia of the Kirchhoff body, added mass included, is not positive definite");
  }
}

}  // namespace

std::map<std::string, double> kirchhoff_parameters(const KirchhoffBodyData& body) {
  check(body);
  std::map<std::string, double> values = {{"mass", body.mass}, {"displaced_mass", body.displaced_mass}};
  const char axes[] = {'x', 'y', 'z'};
  for (int i = 0; i < 3; ++i) {
    values[fmt::format("r_c{}", axes[i])] = body.centre_of_mass[i];
    values[fmt::format("r_b{}", axes[i])] = body.centre_of_buoyancy[i];
    for (int j = i; j < 3; ++j) {
      values[fmt::format("I_{}{}", axes[i], axes[j])] = (body.inertia(i, j) + body.inertia(j, i)) / 2.0;
    }
  }
  for (int i = 0; i < 6; ++i) {
    for (int j = i; j < 6; ++j) {
      values[fmt::format("K_{}{}", i + 1, j + 1)] = (body.added_mass(i, j) + body.added_mass(j, i)) / 2.0;
    }
  }
  return values;
}

}  // namespace samara::models
