#include <cmath>
#include <cstring>
#include <numbers>
#include <stdexcept>

#include "cases.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/fluid_seen.h"
#include "samara/models/stochastic/realisations.h"
#include "scalar_flight.h"

namespace samara::benchmarks {

namespace {

using models::Ensemble;
using models::RealiseOptions;

models::ParametricModel card() {
  constexpr double kTilt = 0.5;  // rad
  return {models::find_model("immersed_body_in_gusts"),
          {{"a", 0.035},
           {"b", 0.02},
           {"c", 1e-4},
           {"density", 1200.0},
           {"C_D90", 0.61},
           {"C_D0", 0.05},
           {"C_T", 1.81},
           {"C_R", 1.21},
           {"C_w", 2.0},
           {"qw(0)", std::cos(0.5 * kTilt)},
           {"qx(0)", std::sin(0.5 * kTilt)}},
          {}};
}

constexpr double kK = 0.135, kEpsilon = 0.043, kC0 = 6.0, kStep = 1e-3, kEnd = 2.0;

std::shared_ptr<const models::AirSource> gusts() {
  return models::fluid_seen_in(models::uniform_turbulence(kK, kEpsilon), 7, {.C_0 = kC0});
}

Ensemble flown(const RealiseOptions& options, const std::vector<double>& times = {1.0, kEnd}) {
  return models::realise(card(), {}, *gusts(), times, options);
}

void run_cost(const Options& options) {
  const long flights = options.quick ? 200 : 1000;
  Ensemble cloud;
  double height = 0.0;
  std::vector<double> x(13);
  card().initial({}, x);
  const std::vector<double> p = card().parameters({});
  const ScalarGusts scalar = {
      .sigma = std::sqrt(2.0 / 3.0 * kK), .T = 4.0 * kK / (3.0 * kC0 * kEpsilon), .C_0 = kC0};
  const auto ours = [&] { cloud = flown({.realisations = flights, .step = kStep, .threads = 1}); };
  const auto theirs = [&] {
    height = fly_one_by_one(x, p, scalar, flights, kStep, std::lround(kEnd / kStep));
  };
  const Pair times = time_both(ours, theirs, options.quick ? 2 : 5);
  // Two samples of one cloud, or the two did not do the same work.
  const double apart = std::abs(height - cloud.mean(1, 2)), error = std::sqrt(2.0) * cloud.mean_error(1, 2);
  if (!(apart < 5.0 * error)) throw std::runtime_error("the scalar loop flies to other heights");
  print({.bench = "realise",
         .test_case = "card_gusts_1000",
         .metric = "time_per_second",
         .value = times.ours / static_cast<double>(flights) / kEnd,
         .unit = "s",
         .baseline = "scalar",
         .ratio = times.ratio()});
  print({.bench = "realise",
         .test_case = "card_gusts_1000",
         .metric = "deviations_from_scalar",
         .value = apart / error});
}

/// Bytes that differ.
long differing(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  if (a.size() != b.size()) return static_cast<long>(sizeof(double)) * std::max(a.size(), b.size());
  std::vector<unsigned char> left(sizeof(double) * static_cast<std::size_t>(a.size())), right(left.size());
  std::memcpy(left.data(), a.data(), left.size());
  std::memcpy(right.data(), b.data(), right.size());
  long count = 0;
  for (std::size_t i = 0; i < left.size(); ++i) count += left[i] != right[i] ? 1 : 0;
  return count;
}

void run_sameness(const Options& options) {
  const long flights = options.quick ? 300 : 1000;
  const Ensemble one = flown({.realisations = flights, .threads = 1, .keep = flights});
  const Ensemble two = flown({.realisations = flights, .threads = 2, .keep = flights});
  long bytes = differing(one.mean, two.mean) + differing(one.mean_error, two.mean_error);
  for (std::size_t n = 0; n < one.kept.size(); ++n) bytes += differing(one.kept[n], two.kept[n]);
  for (const long n : {0L, 17L, flights - 1}) {
    const Ensemble alone = flown({.realisations = 1, .first = n, .keep = 1});
    bytes += differing(alone.kept[0], one.kept[static_cast<std::size_t>(n)]);
  }
  print({.bench = "realise",
         .test_case = "sameness",
         .metric = "differing_bytes",
         .value = static_cast<double>(bytes)});
}

}  // namespace

void run_flights(const Options& options) {
  if (options.wants("card_gusts_1000")) run_cost(options);
  if (options.wants("sameness")) run_sameness(options);
}

}  // namespace samara::benchmarks
