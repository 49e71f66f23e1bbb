#include "samara/pgd/transform_trial.h"

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "samara/pgd/random.h"

namespace samara::pgd {

namespace {

constexpr int kLines = 2;
constexpr int kNodes = 5;
/// A transform is taken only if it is clearly better than none.
constexpr double kClearly = 0.5;

/// cos(i pi / (n-1)).
double lobatto_node(int i) {
  return -std::cos(std::numbers::pi * i / (kNodes - 1));
}

/// Row j: weights of the values at the nodes in the coefficient of Chebyshev's T_j.
Eigen::MatrixXd coefficient_matrix() {
  Eigen::MatrixXd vandermonde(kNodes, kNodes);
  for (int i = 0; i < kNodes; ++i) {
    for (int j = 0; j < kNodes; ++j) vandermonde(i, j) = std::cos(j * std::acos(lobatto_node(i)));
  }
  return vandermonde.inverse();
}

/// Values along one coordinate, line by line, at some of the nodes.
Eigen::MatrixXd values_on_lines(const Eigen::MatrixXd& bases, Eigen::Index k, const CoordinateMap& map,
                                SampledFunction& function, const std::vector<int>& nodes) {
  const auto count = static_cast<Eigen::Index>(nodes.size());
  Eigen::MatrixXd points(bases.rows(), kLines * count);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    points.col(j) = bases.col(j / count);
    points(k, j) = map.from_unit(lobatto_node(nodes[static_cast<std::size_t>(j % count)]));
  }
  return function(points);
}

/// Size of the last two coefficients along the coordinate, over the scales of the outputs, in root mean
/// square over the lines.
/// @param ends values at both ends of the lines, which all maps share
double tail(const Eigen::MatrixXd& bases, Eigen::Index k, const CoordinateMap& map, SampledFunction& function,
            const Eigen::MatrixXd& ends) {
  static const Eigen::MatrixXd coefficients = coefficient_matrix();
  constexpr int kInner = kNodes - 2;
  const Eigen::MatrixXd inner = values_on_lines(bases, k, map, function, {1, 2, kNodes - 2});
  double sum = 0.0;
  for (int line = 0; line < kLines; ++line) {
    Eigen::MatrixXd values(inner.rows(), kNodes);
    values << ends.col(2 * line), inner.middleCols(line * kInner, kInner), ends.col(2 * line + 1);
    const Eigen::MatrixXd on_line =
        function.scale().cwiseInverse().asDiagonal() * values * coefficients.bottomRows(2).transpose();
    sum += on_line.rowwise().squaredNorm().maxCoeff();
  }
  return std::sqrt(sum / kLines);
}

bool is_worth_trying(const SampledCoordinate& c) {
  return c.try_transforms && c.label.transform == Transform::none && c.lower > 0.0 && c.upper > 1.5 * c.lower;
}

}  // namespace

std::vector<Transform> try_transforms(const std::vector<SampledCoordinate>& coordinates,
                                      SampledFunction& function, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd bases(static_cast<Eigen::Index>(coordinates.size()), kLines);
  for (Eigen::Index line = 0; line < kLines; ++line) {
    for (Eigen::Index k = 0; k < bases.rows(); ++k) {
      const SampledCoordinate& c = coordinates[static_cast<std::size_t>(k)];
      bases(k, line) = c.lower + (c.upper - c.lower) * random.uniform();
    }
  }
  std::vector<Transform> best;
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    const SampledCoordinate& c = coordinates[k];
    best.push_back(c.label.transform);
    if (!is_worth_trying(c)) continue;
    const auto row = static_cast<Eigen::Index>(k);
    const CoordinateMap linear(c.lower, c.upper, Transform::none);
    const Eigen::MatrixXd ends = values_on_lines(bases, row, linear, function, {0, kNodes - 1});
    double least = kClearly * tail(bases, row, linear, function, ends);
    for (const Transform transform : {Transform::logarithm, Transform::reciprocal, Transform::square_root}) {
      const double with = tail(bases, row, {c.lower, c.upper, transform}, function, ends);
      if (!(with < least)) continue;
      least = with;
      best.back() = transform;
    }
  }
  return best;
}

}  // namespace samara::pgd
