#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/models/stochastic/fluid_seen.h"

/// How far the accelerations of a motion are from what turbulence would do: the negative logarithm of the likelihood
/// of its path, up to a constant, where the body obeys dv = (a - (v - <u>)/T) dt + sqrt(C_0 epsilon) dW,
///
///   E = sum over intervals of |(v_1 - v_0)/h - a + (v_0 - <u>)/T|^2 h/(2 C_0 epsilon),     T = 4 k/(3 C_0 epsilon).
///
/// (L. Onsager, S. Machlup, Phys. Rev. 91 (1953) 1505-1512.) Nothing is drawn, so that a planner may minimise it:
/// dissertation (5.27)-(5.29) compares accelerations with drawn ones, which has another optimum at every draw. A path
/// that turbulence did make has 3/2 an interval on average, of whatever length.
namespace samara::models {

/// World axes, SI; n intervals.
struct TurbulentPath {
  Eigen::VectorXd times;        ///< n + 1, increasing [s]
  Eigen::MatrixX3d velocities;  ///< of the body, (n + 1) x 3 [m/s]
  /// a: what it would have without turbulence, at the beginning of each, n x 3 [m/s^2].
  Eigen::MatrixX3d still;
  Eigen::MatrixX3d fluid;  ///< <u> there, n x 3 [m/s]; no rows: at rest
};

struct TurbulentAction {
  double value = 0.0;
  /// Its derivatives by `still`, n x 3 [s^2/m]: by a coefficient c, the sum of these times d still/dc.
  Eigen::MatrixX3d by_still;
};

/// @param energy per interval, or one for all
/// @throws ArgumentError for sizes that differ, times that do not increase, numbers that are not finite, or an energy
/// without k and epsilon: nothing but `still` is likely there.
TurbulentAction turbulent_action(const TurbulentPath& path, const std::vector<Turbulence>& energy,
                                 const SeenOptions& options = {});

/// The same of accelerations that coefficients give beyond those of the fitted ones, a = (F(c) - F(c_0))/m, held for a
/// while: what a planner pays for moving coefficients. 3/2 is what turbulence does by itself, whatever the duration.
/// @param extra a [m/s^2]  @param duration [s]
/// @throws ArgumentError likewise
double turbulent_action(const Eigen::Vector3d& extra, double duration, const Turbulence& energy,
                        const SeenOptions& options = {});

}  // namespace samara::models
