#include <algorithm>
#include <cmath>
#include <limits>

#include "cases.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

pgd::SamplingResult sample(const SampledCase& sampled, std::uint64_t seed) {
  std::vector<pgd::SampledCoordinate> box;
  for (std::size_t k = 0; k < sampled.lower.size(); ++k) {
    box.push_back({{std::string(1, static_cast<char>('a' + k))}, sampled.lower[k], sampled.upper[k]});
  }
  const auto function = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      values(0, j) = sampled.function({points.col(j).data(), static_cast<std::size_t>(points.rows())});
    }
  };
  pgd::SamplingOptions options;
  options.tolerance = sampled.tolerance;
  options.max_calls = sampled.max_calls;
  options.seed = seed;
  return pgd::sample(box, {{"f"}}, function, options);
}

SampledErrors errors_of(const SampledCase& sampled, const pgd::SamplingResult& result, int points) {
  if (!result.field)
    return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
  pgd::Random random(20261121);
  pgd::TrainField::Workspace workspace = result.field->make_workspace();
  std::vector<double> x(sampled.lower.size());
  Eigen::VectorXd value(1);
  double squares = 0.0, size = 0.0, largest = 0.0;
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (int j = 0; j < points; ++j) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      x[k] = sampled.lower[k] + (sampled.upper[k] - sampled.lower[k]) * random.uniform();
    }
    const double exact = sampled.function(x);
    result.field->evaluate(x, value, workspace);
    const double error = std::abs(value[0] - exact);
    squares += error * error;
    size += exact * exact;
    largest = std::max(largest, error);
    lowest = std::min(lowest, exact);
    highest = std::max(highest, exact);
  }
  double range = std::max(highest - lowest, result.range[0]);
  if (range <= 1e-10 * std::abs(highest)) range = std::abs(highest);  // a constant
  return {std::sqrt(squares / size), largest / range};
}

}  // namespace samara::benchmarks
