#include "samara/pgd/sampling/noise_level.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace samara::pgd {

namespace {

constexpr int kPlaces = 3;  // for each distance
constexpr int kPoints = 7;
constexpr std::array kApart = {1e-6, 1e-3};  // of the box

/// Standard deviation of the noise in equidistant values, from differences of the orders 2 .. 5; zero where
/// they do not agree within a factor of four, or all have one sign, as those of a smooth function.
double noise_of(Eigen::VectorXd values) {
  double smallest = 0.0, largest = 0.0, sum = 0.0;
  double factor = 1.0;  // (k!)^2 / (2 k)!: of independent noise, differences of order k are wider by its root
  int orders = 0;
  for (int k = 1; k <= 5; ++k) {
    values = (values.tail(values.size() - 1) - values.head(values.size() - 1)).eval();
    factor *= static_cast<double>(k) / (2.0 * (2.0 * k - 1.0));
    if (k < 2) continue;
    const double noise = std::sqrt(factor * values.squaredNorm() / static_cast<double>(values.size()));
    const bool changes_sign = values.minCoeff() < 0.0 && values.maxCoeff() > 0.0;
    if (k < 4 && !changes_sign) return 0.0;
    smallest = orders == 0 ? noise : std::min(smallest, noise);
    largest = std::max(largest, noise);
    sum += noise;
    ++orders;
  }
  constexpr double kAgree = 4.0;
  return largest <= kAgree * smallest ? sum / orders : 0.0;
}

}  // namespace

double noise_level(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
                   Random& random) {
  const auto d = static_cast<Eigen::Index>(coordinates.size());
  constexpr auto kLines = static_cast<Eigen::Index>(kPlaces * kApart.size());
  Eigen::MatrixXd points(d, kLines * kPoints);
  for (Eigen::Index line = 0; line < kLines; ++line) {
    const double apart = kApart[static_cast<std::size_t>(line / kPlaces)];
    for (Eigen::Index k = 0; k < d; ++k) {
      const SampledCoordinate& c = coordinates[static_cast<std::size_t>(k)];
      const double length = c.upper - c.lower;
      const double from = c.lower + length * (1.0 - kPoints * apart) * random.uniform();
      const double step = length * apart * (0.5 + 0.5 * random.uniform());
      for (Eigen::Index i = 0; i < kPoints; ++i)
        points(k, line * kPoints + i) = from + step * static_cast<double>(i);
    }
  }
  const Eigen::MatrixXd values = function(points);
  const Eigen::VectorXd scale = function.scale();
  double largest = 0.0;
  for (Eigen::Index m = 0; m < values.rows(); ++m) {
    for (Eigen::Index first = 0; first < kLines; first += kPlaces) {
      std::array<double, kPlaces> noises{};
      for (Eigen::Index i = 0; i < kPlaces; ++i) {
        const auto line = values.row(m).segment((first + i) * kPoints, kPoints);
        noises[static_cast<std::size_t>(i)] = noise_of(line.transpose()) / scale[m];
      }
      std::ranges::sort(noises);
      largest = std::max(largest, noises[kPlaces / 2]);
    }
  }
  return largest;
}

}  // namespace samara::pgd
