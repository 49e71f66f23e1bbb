#include "guard_families.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>

#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

using pgd::Random;
using Point = Eigen::Map<const Eigen::VectorXd>;
/// Of a point, what a feature depends on.
using Measure = std::function<double(const Eigen::VectorXd&)>;

constexpr int kCalibration = 50'000;

Point at(std::span<const double> x) {
  return {x.data(), static_cast<Eigen::Index>(x.size())};
}

Eigen::VectorXd normal_vector(int size, Random& random) {
  return Eigen::VectorXd::NullaryExpr(size, [&] { return random.normal(); });
}

Eigen::VectorXd uniform_point(int size, Random& random) {
  return Eigen::VectorXd::NullaryExpr(size, [&] { return random.uniform(); });
}

/// Orthonormal, uniform over all rotations but for signs.
Eigen::MatrixXd rotation(int size, Random& random) {
  const Eigen::MatrixXd normal = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return random.normal(); });
  return Eigen::HouseholderQR<Eigen::MatrixXd>(normal).householderQ();
}

double log_uniform(double lower, double upper, Random& random) {
  return lower * std::pow(upper / lower, random.uniform());
}

/// A plane and two waves about as long as the box, with a range of about one.
std::function<double(const Eigen::VectorXd&)> smooth_ground(int d, Random& random) {
  const Eigen::VectorXd slope = normal_vector(d, random).normalized();
  const Eigen::VectorXd first = normal_vector(d, random).normalized();
  const Eigen::VectorXd second = normal_vector(d, random).normalized();
  const double phase = 6.28 * random.uniform();
  const double reach = slope.cwiseAbs().sum();
  return [=](const Eigen::VectorXd& x) {
    return 0.7 * slope.dot(x) / reach + 0.1 * std::cos(2.0 * first.dot(x) + phase) +
           0.1 * std::sin(1.5 * second.dot(x));
  };
}

/// Smooth functions as engineers have them, of moderate curvature in all coordinates.
std::function<double(const Eigen::VectorXd&)> smooth_function(int d, Random& random) {
  const Eigen::VectorXd a = normal_vector(d, random).cwiseAbs() / std::sqrt(d);
  const Eigen::VectorXd b = normal_vector(d, random) / std::sqrt(d);
  const Eigen::VectorXd c = normal_vector(d, random) / std::sqrt(d);
  switch (random.below(4)) {
    case 0:
      return [=](const Eigen::VectorXd& x) { return 1.0 / (1.0 + a.dot(x)); };
    case 1:
      return [=](const Eigen::VectorXd& x) { return std::exp(b.dot(x)) * std::cos(2.0 * c.dot(x)); };
    case 2:
      return [=](const Eigen::VectorXd& x) {
        return (1.0 + a.cwiseProduct(x).sum() * c.dot(x)) / (1.5 + std::sin(b.dot(x)));
      };
    default:
      return [=](const Eigen::VectorXd& x) {
        return std::sqrt(1.0 + (a.array() * x.array()).square().sum()) + 0.5 * std::sin(2.0 * b.dot(x));
      };
  }
}

/// The value below which `measure` lies in this share of the box.
double quantile(const Measure& measure, int d, double share, Random& random) {
  std::vector<double> values(kCalibration);
  for (double& value : values) value = measure(uniform_point(d, random));
  const auto place = values.begin() + static_cast<std::ptrdiff_t>(share * (kCalibration - 1));
  std::nth_element(values.begin(), place, values.end());
  return *place;
}

/// A feature that has faded to the tolerance where `distance` is `reach` widths: profile(distance / width).
struct Feature {
  Measure distance;
  double reach = 1.0;
  std::function<double(double)> profile;
  std::vector<double> place;
};

std::vector<double> listed(const Eigen::VectorXd& x) {
  return {x.begin(), x.end()};
}

double gaussian(double r) {
  return std::exp(-0.5 * r * r);
}

double gaussian_reach(double tolerance) {
  return std::sqrt(-2.0 * std::log(tolerance));
}

/// Gaussian of the distance in `directions` turned directions, of random relative widths: all of them a
/// peak, one a sheet.
Feature turned_gaussian(int d, int directions, double tolerance, Random& random) {
  Eigen::MatrixXd turned = rotation(d, random).topRows(directions);
  for (Eigen::Index i = 0; i < directions; ++i) turned.row(i) /= log_uniform(0.5, 2.0, random);
  const Eigen::VectorXd centre = uniform_point(d, random);
  return {[=](const Eigen::VectorXd& x) { return (turned * (x - centre)).norm(); }, gaussian_reach(tolerance),
          gaussian, listed(centre)};
}

/// How far a point is from the farthest corner in a turned direction, from 0 to 1.
Feature turned_corner(int d, const std::function<double(double)>& profile, double reach, Random& random) {
  const Eigen::VectorXd direction = normal_vector(d, random).normalized();
  const Eigen::VectorXd corner = (direction.array() > 0.0).select(Eigen::VectorXd::Ones(d), 0.0);
  const double length = direction.cwiseAbs().sum();
  return {[=](const Eigen::VectorXd& x) { return direction.dot(corner - x) / length; }, reach, profile,
          listed(corner)};
}

/// 1/(1 + r) from one or two faces.
Feature pole(int d, double tolerance, Random& random) {
  const int faces = 1 + random.below(2);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(d);
  while (weights.count() < faces) weights[random.below(d)] = 0.5 + random.uniform();
  const Eigen::VectorXd face = Eigen::VectorXd::NullaryExpr(d, [&] { return random.below(2); });
  return {[=](const Eigen::VectorXd& x) { return weights.dot((x - face).cwiseAbs()); }, 1.0 / tolerance - 1.0,
          [](double r) { return 1.0 / (1.0 + r); }, listed(face)};
}

/// Something that two to four coordinates do only together, in a small box of them.
Feature interaction(int d, double tolerance, Random& random) {
  const int together = std::min(d, 2 + random.below(3));
  std::vector<int> which(static_cast<std::size_t>(d));
  for (int k = 0; k < d; ++k) which[static_cast<std::size_t>(k)] = k;
  for (int k = 0; k < together; ++k)
    std::swap(which[static_cast<std::size_t>(k)], which[static_cast<std::size_t>(k + random.below(d - k))]);
  which.resize(static_cast<std::size_t>(together));
  const Eigen::VectorXd centre = uniform_point(d, random);
  return {[=](const Eigen::VectorXd& x) {
            double largest = 0.0;
            for (const int k : which) largest = std::max(largest, std::abs(x[k] - centre[k]));
            return largest;
          },
          std::sqrt(1.0 - std::sqrt(tolerance)),
          [](double r) { return r < 1.0 ? (1.0 - r * r) * (1.0 - r * r) : 0.0; }, listed(centre)};
}

Feature feature_of(const std::string& family, int d, double tolerance, Random& random) {
  if (family == "peak") return turned_gaussian(d, d, tolerance, random);
  if (family == "ridge") return turned_gaussian(d, 2 + random.below(d - 2), tolerance, random);
  if (family == "sheet") return turned_gaussian(d, 1, tolerance, random);
  if (family == "kink") {
    return turned_corner(
        d, [](double r) { return std::max(0.0, 1.0 - r); }, 1.0 - tolerance, random);
  }
  if (family == "jump")
    return turned_corner(
        d, [](double r) { return r < 1.0 ? 1.0 : 0.0; }, 1.0, random);
  if (family == "pole") return pole(d, tolerance, random);
  if (family == "interaction") return interaction(d, tolerance, random);
  throw std::invalid_argument("no family of the guard: " + family);
}

/// The same value at the same point, without any order between points: in -1 .. 1.
double noise_at(std::span<const double> x, std::uint64_t seed) {
  std::uint64_t state = seed;
  for (const double value : x) state = Random(state ^ std::bit_cast<std::uint64_t>(value)).bits();
  return 2.0 * Random(state).uniform() - 1.0;
}

}  // namespace

const std::vector<std::string>& guard_families() {
  static const std::vector<std::string> all = {"peak", "ridge",       "sheet", "kink",  "jump",
                                               "pole", "interaction", "noise", "smooth"};
  return all;
}

GuardedFunction guarded_function(const std::string& family, std::uint64_t seed, double tolerance) {
  Random random(seed);
  GuardedFunction f;
  f.family = family;
  f.dimensions = 3 + random.below(8);
  const int d = f.dimensions;
  if (family == "smooth") {
    f.value = [smooth = smooth_function(d, random)](std::span<const double> x) { return smooth(at(x)); };
    return f;
  }
  f.has_feature = true;
  const auto ground = smooth_ground(d, random);
  if (family == "noise") {
    const double amplitude = log_uniform(1e-4, 1e-1, random);
    const std::uint64_t noise = random.bits();
    f.share = std::max(0.0, 1.0 - tolerance / amplitude);
    f.value = [=](std::span<const double> x) { return ground(at(x)) + amplitude * noise_at(x, noise); };
    return f;
  }
  f.share = log_uniform(1e-4, 1e-1, random);
  const Feature feature = feature_of(family, d, tolerance, random);
  const double width = quantile(feature.distance, d, f.share, random) / feature.reach;
  const double sign = random.below(2) == 0 ? -1.0 : 1.0;
  f.places = {feature.place};
  f.value = [=](std::span<const double> x) {
    const Eigen::VectorXd point = at(x);
    return ground(point) + sign * feature.profile(feature.distance(point) / width);
  };
  return f;
}

GuardedFunction oblique_peak(std::uint64_t seed) {
  constexpr int d = 6;
  Random random(seed);
  Eigen::MatrixXd turned = rotation(d, random);
  for (Eigen::Index i = 0; i < d; ++i) turned.row(i) /= 0.08 + 0.07 * random.uniform();
  const Eigen::VectorXd slope = normal_vector(d, random);
  const double height = slope.cwiseAbs().sum();
  const Eigen::VectorXd centre = uniform_point(d, random);
  GuardedFunction f;
  f.family = "oblique peak";
  f.dimensions = d;
  f.has_feature = true;
  f.places = {listed(centre)};
  f.value = [=](std::span<const double> x) {
    const Eigen::VectorXd point = at(x);
    return slope.dot(point) + height * gaussian((turned * (point - centre)).norm());
  };
  return f;
}

}  // namespace samara::benchmarks
