#pragma once

#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/train_field.h"

namespace samara::pgd {

/// How far the coefficients of a field have decayed along its axes, which are Chebyshev axes of one element:
/// per axis the last two Chebyshev coefficients along lines through the given points (axes x points), the
/// largest output over its scale, in root mean square over the lines.
std::vector<double> coefficient_tails(const TrainField& field, const Eigen::VectorXd& scale,
                                      const Eigen::MatrixXd& points);

}  // namespace samara::pgd
