#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "samara/pgd/tensors/random.h"

// Chaos: the Lorenz equations over initial values and all three parameters. A window is the flow map over
// 0.05 units of time, sampled once over a box around the attractor and composed; beside it one map over one
// unit of time.

namespace samara::benchmarks {

namespace {

using State = std::array<double, 3>;
struct Lorenz {
  double sigma, rho, beta;
};

State rate(const State& x, const Lorenz& p) {
  return {p.sigma * (x[1] - x[0]), x[0] * (p.rho - x[2]) - x[1], x[0] * x[1] - p.beta * x[2]};
}

State moved(const State& x, double h, const State& k) {
  return {x[0] + h * k[0], x[1] + h * k[1], x[2] + h * k[2]};
}

/// Runge and Kutta with a step of 2.5e-4: its error of about 1e-12 over a window is below every tolerance
/// asked for here.
State flow(State x, const Lorenz& p, double end) {
  const int steps = static_cast<int>(std::lround(end * 4000.0));
  const double h = end / steps;
  for (int i = 0; i < steps; ++i) {
    const State k1 = rate(x, p);
    const State k2 = rate(moved(x, 0.5 * h, k1), p);
    const State k3 = rate(moved(x, 0.5 * h, k2), p);
    const State k4 = rate(moved(x, h, k3), p);
    for (std::size_t j = 0; j < 3; ++j) x[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
  }
  return x;
}

pgd::SamplingResult sampled_map(const State& lower, const State& upper, double end, double tolerance,
                                long max_calls, std::uint64_t seed) {
  std::vector<pgd::SampledCoordinate> box = {{{"x"}, lower[0], upper[0]}, {{"y"}, lower[1], upper[1]},
                                             {{"z"}, lower[2], upper[2]}, {{"sigma"}, 9.0, 11.0},
                                             {{"rho"}, 26.0, 30.0},       {{"beta"}, 2.4, 2.9}};
  const auto map = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      const State x =
          flow({points(0, j), points(1, j), points(2, j)}, {points(3, j), points(4, j), points(5, j)}, end);
      values.col(j) << x[0], x[1], x[2];
    }
  };
  pgd::SamplingOptions options;
  options.tolerance = tolerance;
  options.max_calls = max_calls;
  options.seed = seed;
  return pgd::sample(box, {{"x"}, {"y"}, {"z"}}, map, options);
}

/// Relative root mean square error of x(end) over random initial values x, y in +-10, z in [15, 35]; windows
/// of the map are composed. Infinite if a state leaves the map's box.
double composed_error(const pgd::TrainField& map, double window, double end, int points) {
  pgd::Random random(8);
  pgd::TrainField::Workspace workspace = map.make_workspace();
  Eigen::VectorXd values(3);
  double squares = 0.0, size = 0.0;
  for (int j = 0; j < points; ++j) {
    State x = {-10.0 + 20.0 * random.uniform(), -10.0 + 20.0 * random.uniform(),
               15.0 + 20.0 * random.uniform()};
    const Lorenz p = {9.0 + 2.0 * random.uniform(), 26.0 + 4.0 * random.uniform(),
                      2.4 + 0.5 * random.uniform()};
    const State exact = flow(x, p, end);
    const auto windows = std::lround(end / window);
    for (long k = 0; k < windows; ++k) {
      const std::array<double, 6> at = {x[0], x[1], x[2], p.sigma, p.rho, p.beta};
      map.evaluate(at, values, workspace);
      x = {values[0], values[1], values[2]};
    }
    squares += (x[0] - exact[0]) * (x[0] - exact[0]);
    size += exact[0] * exact[0];
  }
  return std::sqrt(squares / size);
}

/// The largest of every metric over some seeds, in the order in which they came.
class Worst {
 public:
  void take(const std::string& metric, double value) {
    const auto known = std::ranges::find(metrics_, metric, &Metric::first);
    if (known == metrics_.end()) {
      metrics_.emplace_back(metric, value);
    } else {
      known->second = std::max(known->second, value);
    }
  }
  void print(const std::string& test_case) const {
    for (const auto& [metric, value] : metrics_) benchmarks::print({kSampling, test_case, metric, value});
  }

 private:
  using Metric = std::pair<std::string, double>;
  std::vector<Metric> metrics_;
};

}  // namespace

void run_lorenz(const Options& options) {
  const int points = options.quick ? 200 : 2000;
  const std::uint64_t seeds = options.quick ? 1 : 5;
  if (options.wants("lorenz_windows")) {
    Worst worst;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      // Around all that starts in the box of initial values.
      const pgd::SamplingResult map =
          sampled_map({-25.0, -32.0, 0.0}, {25.0, 32.0, 60.0}, 0.05, 1e-10, 400'000, seed);
      worst.take("calls", static_cast<double>(map.calls));
      worst.take("numbers", static_cast<double>(map.field->entries()));
      for (const int end : {1, 2, 8})
        worst.take(fmt::format("error_T{}", end), composed_error(*map.field, 0.05, end, points));
    }
    worst.print("lorenz_windows");
  }
  if (options.wants("lorenz_global")) {
    const pgd::SamplingResult map =
        sampled_map({-10.0, -10.0, 15.0}, {10.0, 10.0, 35.0}, 1.0, 1e-2, options.quick ? 20'000 : 400'000, 1);
    print({kSampling, "lorenz_global", "calls", static_cast<double>(map.calls)});
    print({kSampling, "lorenz_global", "error_T1", composed_error(*map.field, 1.0, 1.0, points)});
  }
}

}  // namespace samara::benchmarks
