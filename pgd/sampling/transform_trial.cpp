#include "samara/pgd/sampling/transform_trial.h"

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/LU>

#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

namespace {

constexpr Eigen::Index kLines = 2;
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

constexpr std::array<Transform, 4> kTried = {Transform::none, Transform::logarithm, Transform::reciprocal,
                                             Transform::square_root};
/// Points of a coordinate that is tried: the ends of the lines, which all transforms share, then line by line
/// the nodes between them, transform by transform.
constexpr Eigen::Index kEnds = 2 * kLines, kInner = kLines * (kNodes - 2);
constexpr Eigen::Index kTrialPoints = kEnds + static_cast<Eigen::Index>(kTried.size()) * kInner;

Eigen::MatrixXd points_on_lines(const Eigen::MatrixXd& bases, Eigen::Index k, const SampledCoordinate& c) {
  Eigen::MatrixXd points(bases.rows(), kTrialPoints);
  Eigen::Index j = 0;
  const auto add = [&](Eigen::Index line, double x) {
    points.col(j) = bases.col(line);
    points(k, j++) = x;
  };
  for (Eigen::Index line = 0; line < kLines; ++line) {
    add(line, c.lower);
    add(line, c.upper);
  }
  for (const Transform transform : kTried) {
    const CoordinateMap map(c.lower, c.upper, transform);
    for (Eigen::Index line = 0; line < kLines; ++line) {
      for (int i = 1; i + 1 < kNodes; ++i) add(line, map.from_unit(lobatto_node(i)));
    }
  }
  return points;
}

/// Size of the last two coefficients along the coordinate, over the scales of the outputs, in root mean
/// square over the lines. @param ends,inner values at the points of a coordinate
double tail(const Eigen::MatrixXd& ends, const Eigen::MatrixXd& inner, const Eigen::VectorXd& scale) {
  static const Eigen::MatrixXd coefficients = coefficient_matrix();
  double sum = 0.0;
  for (Eigen::Index line = 0; line < kLines; ++line) {
    Eigen::MatrixXd values(inner.rows(), kNodes);
    values << ends.col(2 * line), inner.middleCols(line * (kNodes - 2), kNodes - 2), ends.col(2 * line + 1);
    const Eigen::MatrixXd on_line =
        scale.cwiseInverse().asDiagonal() * values * coefficients.bottomRows(2).transpose();
    sum += on_line.rowwise().squaredNorm().maxCoeff();
  }
  return std::sqrt(sum / kLines);
}

/// @param values at the points of a coordinate
Transform best_transform(const Eigen::MatrixXd& values, const Eigen::VectorXd& scale) {
  Transform best = Transform::none;
  double least = 0.0;
  for (std::size_t t = 0; t < kTried.size(); ++t) {
    const Eigen::Index first = kEnds + static_cast<Eigen::Index>(t) * kInner;
    const double size = tail(values.leftCols(kEnds), values.middleCols(first, kInner), scale);
    if (t > 0 && !(size < least)) continue;
    best = kTried[t];
    least = t == 0 ? kClearly * size : size;
  }
  return best;
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
  std::vector<std::size_t> tried;
  Eigen::MatrixXd points(bases.rows(), 0);
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    best.push_back(coordinates[k].label.transform);
    if (!is_worth_trying(coordinates[k])) continue;
    tried.push_back(k);
    points.conservativeResize(Eigen::NoChange, points.cols() + kTrialPoints);
    points.rightCols(kTrialPoints) = points_on_lines(bases, static_cast<Eigen::Index>(k), coordinates[k]);
  }
  if (tried.empty()) return best;
  // Of one coordinate, all lines are the same.
  const Eigen::MatrixXd values = function.recalled(points);
  const Eigen::VectorXd scale = function.scale();
  for (std::size_t i = 0; i < tried.size(); ++i) {
    const Eigen::Index first = static_cast<Eigen::Index>(i) * kTrialPoints;
    best[tried[i]] = best_transform(values.middleCols(first, kTrialPoints), scale);
  }
  return best;
}

}  // namespace samara::pgd
