// The sweep of the source: 729 coefficient points, falls of 2 m, statistics of each.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "cases.h"
#include "falling_card.h"
#include "samara/models/batch/batch.h"
#include "samara/models/batch/watch_batch.h"

namespace samara::benchmarks {

namespace {

using namespace models;

constexpr double kHeight = 2.0;  // m

/// One fall, as far as it has come.
struct Fall {
  double t = 0.0, x = 0.0, y = 0.0, z = 0.0;
  double side = 1.0;  ///< which face looks up
  int flips = 0;
  double time = 0.0;   ///< of the whole fall [s]
  double drift = 0.0;  ///< horizontal distance at its end [m]

  /// @returns whether it goes on
  bool see(double now, std::span<const double> state) {
    const double up = 1.0 - 2.0 * (state[4] * state[4] + state[5] * state[5]);  // R_zz
    if (up * side < 0.0) {
      ++flips;
      side = -side;
    }
    if (state[2] > -kHeight) {
      t = now;
      x = state[0];
      y = state[1];
      z = state[2];
      return true;
    }
    const double share = (-kHeight - z) / (state[2] - z);
    time = t + share * (now - t);
    drift = std::hypot(x + share * (state[0] - x), y + share * (state[1] - y));
    return false;
  }
};

/// Means over all falls.
struct Statistics {
  double flips = 0.0, drift = 0.0, speed = 0.0;
};

std::vector<Fall> sweep(const ParametricModel& card, const Eigen::MatrixXd& points, double step) {
  std::vector<Fall> falls(static_cast<std::size_t>(points.rows()));
  watch_batch(card, points,
              [&](Eigen::Index n, double t, std::span<const double> state) {
                return falls[static_cast<std::size_t>(n)].see(t, state);
              },
              {.step = step, .interval = 4e-3, .end = 60.0});
  return falls;
}

void append(std::vector<Fall>& all, const std::vector<Fall>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

Statistics means(const std::vector<Fall>& falls) {
  Statistics mean;
  for (const Fall& fall : falls) {
    const double share = 1.0 / static_cast<double>(falls.size());
    mean.flips += share * fall.flips;
    mean.drift += share * fall.drift;
    mean.speed += share * kHeight / fall.time;
  }
  return mean;
}

/// Standard error of the difference of two mean drifts: falls that tumble in chaos part at any change of the
/// step, so that the means differ by about this whatever the step.
double drift_scatter(const std::vector<Fall>& a, const std::vector<Fall>& b) {
  const double count = static_cast<double>(a.size());
  double sum = 0.0, squares = 0.0;
  for (std::size_t n = 0; n < a.size(); ++n) {
    const double difference = a[n].drift - b[n].drift;
    sum += difference;
    squares += difference * difference;
  }
  return std::sqrt((squares / count - sum * sum / (count * count)) / count);
}

}  // namespace

void run_sweep(const Options& options) {
  constexpr const char* kName = "sweep729";
  if (!options.wants(kName)) return;
  constexpr double kStep = 1e-3;
  constexpr double kSource = 5.7 * 3600.0;  // s
  const ParametricModel card = oblique_card();
  const Eigen::MatrixXd points = coefficient_grid();
  const double time = time_of([&] { sweep(card, points, kStep); }, options.quick ? 1 : 5);
  // Tumbling is chaotic: means over one release move by about 2 % with anything. Those over 16 releases,
  // their axes a turn apart in golden shares, are firmer.
  std::vector<Fall> falls, finer_falls;
  for (int release = 0; release < (options.quick ? 2 : 16); ++release) {
    const ParametricModel released = oblique_card(0.6 + release * 2.0 * std::numbers::pi * 0.6180339887);
    append(falls, sweep(released, points, kStep));
    append(finer_falls, sweep(released, points, 0.5 * kStep));
  }
  const Statistics here = means(falls);
  const Statistics finer = means(finer_falls);
  const auto change = [](double a, double b) { return std::abs(a / b - 1.0); };
  print({kModels, kName, "time", time, "s", "the source's sweep", kSource / time});
  print({kModels, kName, "statistics_change",
         std::max({change(here.flips, finer.flips), change(here.drift, finer.drift),
                   change(here.speed, finer.speed)}),
         "1"});
  print({kModels, kName, "drift_scatter", drift_scatter(falls, finer_falls) / finer.drift, "1"});
  print({kModels, kName, "mean_flips", here.flips, "1"});
  print({kModels, kName, "mean_drift", here.drift, "m"});
  print({kModels, kName, "mean_speed", here.speed, "m/s"});
}

}  // namespace samara::benchmarks
