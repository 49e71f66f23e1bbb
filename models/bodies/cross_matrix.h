#pragma once

#include <Eigen/Core>

namespace samara::models {

/// [r]x: the matrix of s -> r x s.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& r) {
  Eigen::Matrix3d matrix;
  matrix << 0.0, -r.z(), r.y(), r.z(), 0.0, -r.x(), -r.y(), r.x(), 0.0;
  return matrix;
}

}  // namespace samara::models
