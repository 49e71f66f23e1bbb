#pragma once

#include "samara/pgd/nonlinear/strategy_slab.h"

/// f and J of an iterate by cross interpolation over the parameters.
namespace samara::pgd {

/// Of a slab's tolerance, what the source may be wrong by.
inline constexpr double kSourceShare = 0.1;

/// f(X) at the Radau points, rounded to the source's share of the tolerance.
Outcome<TensorTrain> separated_rates(const StrategySlab& slab, const TensorTrain& iterate,
                                     CrossPivots& pivots);

/// J(X) at the Radau points, rounded to the tolerance, for a first mode as in LinearSlab::jacobian.
Outcome<TensorTrain> separated_jacobian(const StrategySlab& slab, const TensorTrain& iterate,
                                        double tolerance, CrossPivots& pivots);

/// J at states given at the Radau points (StrategySlab::at_points), as the cross found it.
Outcome<TensorTrain> separated_jacobian_at(const StrategySlab& slab, const TensorTrain& states,
                                           double tolerance, CrossPivots& pivots);

/// Columns: the source f(X) - A X at entries, for X (from the first Radau point on) and A at these entries.
Eigen::MatrixXd source_at(const StrategySlab& slab, const Eigen::MatrixXd& rates, const Eigen::MatrixXd& x,
                          const Eigen::MatrixXd& jacobians);

}  // namespace samara::pgd
