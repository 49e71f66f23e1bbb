#include "samara/models/added_mass/reference_point.h"

#include "samara/models/bodies/cross_matrix.h"

namespace samara::models {

Eigen::Matrix<double, 6, 6> added_mass_about(const Eigen::Matrix<double, 6, 6>& added_mass,
                                             const Eigen::Vector3d& offset) {
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Identity();
  A.topRightCorner<3, 3>() = cross_matrix(offset);
  return A.transpose() * added_mass * A;
}

}  // namespace samara::models
