#pragma once

#include <cmath>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "samara/pgd/sampling/sampling.h"
#include "samara/pgd/tensors/random.h"

/// Functions of one output for tests of sampling, and how far a result is from them.
namespace samara::pgd {

using Scalar = std::function<double(std::span<const double>)>;

inline PointsFunction one_output(const Scalar& f) {
  return [f](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      values(0, j) = f({points.col(j).data(), static_cast<std::size_t>(points.rows())});
    }
  };
}

inline std::vector<SampledCoordinate> unit_box(int dimensions) {
  std::vector<SampledCoordinate> box;
  for (int k = 0; k < dimensions; ++k)
    box.push_back({{std::string(1, static_cast<char>('a' + k))}, 0.0, 1.0});
  return box;
}

/// Largest error at random points that are not the builder's, over the largest difference of values.
inline double independent_error(const SamplingResult& result, const Scalar& f, int points = 3000) {
  Random random(987654321);
  std::vector<double> x(static_cast<std::size_t>(result.field->axis_count()));
  double error = 0.0;
  for (int j = 0; j < points; ++j) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      const Axis& axis = result.field->axes()[k];
      x[k] = axis.lower() + axis.length() * random.uniform();
    }
    error = std::max(error, std::abs((*result.field)(x)[0] - f(x)));
  }
  return error / result.range[0];
}

inline double sum_of(std::span<const double> x) {
  double sum = 0.0;
  for (const double value : x) sum += value;
  return sum;
}

}  // namespace samara::pgd
