#pragma once

#include <Eigen/Core>

/// Kernels between moments of motions that hold however these are turned about the vertical, and for their mirror
/// images.
///
/// A moment m has level numbers a, displacements as complex numbers x + iy, and others b that do not turn. Of the
/// Gaussian kernel
///
///     exp(-(|a - R a_j|^2 + |b - b_j|^2)/2)
///
/// the means over turns R = exp(it), as it is and times R, are covariant kernels (Glielmo, Sollich and De Vita, Phys.
/// Rev. B 95 (2017) 214302). With z_j = sum_k a_k a_jk* they are, over all turns,
///
///     k_n = exp(-(|a|^2 + |a_j|^2 + |b - b_j|^2)/2) I_n(|z_j|) (z_j/|z_j|)^n,  n = 0, 1,
///
/// I_n the modified Bessel functions. Mirrored centres have a_j* in place of a_j.
///
/// A moment may have views: numbers of two pictures that are taken along the level axes, s + iu, s of the one along x.
/// A quarter turn exchanges s and u, a mirror leaves them, and of other turns nothing is known. So with views the means
/// are those over quarter turns R = i^q, and the Gaussian kernel has |v - v_j|^2 besides, v_j exchanged where q is odd.
namespace samara::identification {

/// Numbers of a motion: those that turn with it about the vertical, those that do not, and views; a row each moment.
struct TurningRows {
  Eigen::MatrixXcd level = {};
  Eigen::MatrixXd others = {};
  Eigen::MatrixXcd views = {};
};

/// (k_0 + k_0')/2, k_0' that of the mirrored centres; moments x centres.
Eigen::MatrixXd still_kernel(const TurningRows& moments, const TurningRows& centres);

/// k_1/2 and k_1'/2.
struct TurningKernel {
  Eigen::MatrixXcd as_seen = {}, mirrored = {};
};
TurningKernel turning_kernel(const TurningRows& moments, const TurningRows& centres);

}  // namespace samara::identification
