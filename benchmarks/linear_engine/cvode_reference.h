#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

namespace samara::benchmarks {

/// M u' = f(t) - K u by CVODE (BDF, dense, relative tolerance 1e-10), the independent solution of the
/// semi-discrete problems here.
/// @returns u at the given increasing times, column by column; times[0] is the start
Eigen::MatrixXd integrate_linear(const Eigen::MatrixXd& mass, const Eigen::MatrixXd& stiffness,
                                 const std::function<Eigen::VectorXd(double)>& load,
                                 const Eigen::VectorXd& start, const Eigen::VectorXd& times);

}  // namespace samara::benchmarks
