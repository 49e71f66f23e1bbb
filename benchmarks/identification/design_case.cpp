/// The next experiment with a falling plate: a fit of four captures that were released alike, two more as
/// proposed, and what 200 repetitions of all six, with noise drawn anew, scatter by; beside it the same with
/// two releases at random.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cases.h"
#include "samara/base/parallel.h"
#include "samara/base/streams.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/identification/design/design.h"
#include "samara/identification/fit/fit.h"

namespace samara::benchmarks::identification {

namespace {

namespace id = samara::identification;

constexpr const char* kCase = "design";
constexpr double kEnd = 3.0;
constexpr int kFrames = 40;
constexpr double kNoise = 0.02;  ///< of the semi-chord, and in rad
constexpr int kMore = 2;         ///< captures
constexpr std::uint64_t kSeed = 21;

const std::vector<double>& truth() {
  static const std::vector<double> values = {1.25, 3.0, 0.18};
  return values;
}

codebooks::Codebook plate_book() {
  return codebooks::build(codebooks::parse_plan(R"(
model = 'falling_plate_nd'
[fixed]
inertia_ratio = 1.1
beta = 0.0714
A = 1.4
B = 1.0
[box]
C_T = [0.9, 1.5]
C_R = [2.4, 3.9]
mu1 = [0.1, 0.3]
'theta(0)' = [0.1, 1.4]
'w(0)' = [-0.5, 0.5]
[time]
end = 3
[tolerance]
relative = 1e-3
[builder]
kind = 'pgd'
)",
                                                "design"))
      .book;
}

/// theta(0) and w(0).
using Release = std::vector<double>;

/// What was done so far.
const std::vector<Release>& releases_so_far() {
  static const std::vector<Release> releases = {{0.35, 0.0}, {0.4, 0.0}, {0.45, 0.0}, {0.5, 0.0}};
  return releases;
}

std::vector<id::Capture> seen(const models::TrajectoryFamily& family, const std::vector<Release>& releases,
                              std::uint64_t number) {
  Stream random(kSeed, number);
  const std::vector<std::string> outputs = {"x", "y", "theta"};
  std::vector<double> times;
  for (int k = 0; k < kFrames; ++k) times.push_back(kEnd * k / (kFrames - 1));
  std::vector<id::Capture> captures;
  for (std::size_t c = 0; c < releases.size(); ++c) {
    std::vector<double> q = truth();
    q.insert(q.end(), releases[c].begin(), releases[c].end());
    const auto motion = models::trajectory(family, q, times, outputs);
    id::Capture capture;
    capture.id = "plate " + std::to_string(c);
    capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), kFrames);
    for (std::size_t o = 0; o < outputs.size(); ++o) {
      Eigen::VectorXd values = motion.values.col(static_cast<Eigen::Index>(o));
      for (double& value : values) value += kNoise * random.normal();
      capture.channels.push_back({outputs[o], o < 2 ? "1" : "rad", values});
    }
    captures.push_back(std::move(capture));
  }
  return captures;
}

id::FitResult fitted(const models::TrajectoryFamily& family, const std::vector<id::Capture>& captures) {
  id::FitOptions options;
  options.loss = {.kind = id::LossKind::none, .scales = {{"x", kNoise}, {"y", kNoise}, {"theta", kNoise}}};
  options.starts.count = 1;
  return id::fit(family, captures, options);
}

/// Root mean square of coefficients less the truth, over repetitions.
/// @param more releases of repetition `number`
template <class More>
std::vector<double> achieved_errors(const models::TrajectoryFamily& family, int repetitions,
                                    const More& more) {
  std::vector<std::vector<double>> errors(static_cast<std::size_t>(repetitions));
  parallel_for(repetitions, [&](int n) {
    std::vector<Release> all = releases_so_far();
    for (const Release& release : more(static_cast<std::uint64_t>(n))) all.push_back(release);
    const id::FitResult result = fitted(family, seen(family, all, static_cast<std::uint64_t>(n + 1)));
    for (std::size_t k = 0; k < truth().size(); ++k)
      errors[static_cast<std::size_t>(n)].push_back(result.coefficients[k].value - truth()[k]);
  });
  std::vector<double> sums(truth().size(), 0.0);
  for (const auto& one : errors)
    for (std::size_t k = 0; k < one.size(); ++k) sums[k] += one[k] * one[k] / repetitions;
  for (double& sum : sums) sum = std::sqrt(sum);
  return sums;
}

std::vector<Release> random_releases(const id::Design& design, std::uint64_t number) {
  Stream random(kSeed + 1, number);
  std::vector<Release> releases(kMore);
  for (Release& release : releases) {
    for (const id::ReleaseCoordinate& c : design.coordinates)
      release.push_back(c.lower + random.uniform() * (c.upper - c.lower));
  }
  return releases;
}

}  // namespace

void design_case(const Options& options) {
  if (!options.wants(kCase)) return;
  const codebooks::Codebook book = plate_book();
  const auto family = codebooks::codebook_trajectories(book);
  const id::FitResult so_far = fitted(*family, seen(*family, releases_so_far(), 0));

  id::Design design;
  const double time =
      time_of([&] { design = id::design_experiment(*family, so_far, {.captures = kMore}); }, 3, 0.0);
  print({kBench, kCase, "time", time, "s"});
  print({kBench, kCase, "evaluations", static_cast<double>(design.evaluations)});
  print({kBench, kCase, "expected_error", design.error});

  std::vector<Release> proposed;
  for (const id::ProposedCapture& capture : design.captures) proposed.push_back(capture.release);
  const int repetitions = options.quick ? 50 : 200;
  const auto by_design = achieved_errors(*family, repetitions, [&](std::uint64_t) { return proposed; });
  const auto at_random =
      achieved_errors(*family, repetitions, [&](std::uint64_t n) { return random_releases(design, n); });
  double ratio = 1.0, gain = 0.0;
  for (std::size_t k = 0; k < truth().size(); ++k) {
    const double expected = design.coefficients[k].expected;
    ratio = std::max({ratio, expected / by_design[k], by_design[k] / expected});
    gain += std::log(at_random[k] / by_design[k]) / static_cast<double>(truth().size());
  }
  print({kBench, kCase, "error_ratio", ratio});
  print({kBench, kCase, "gain_over_random", std::exp(gain)});
}

}  // namespace samara::benchmarks::identification
