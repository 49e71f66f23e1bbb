/// Draws of five coefficients of a falling plate from one noisy capture, by a codebook's derivatives: how long 4,000
/// effective ones take, and how often 95 % intervals hold the truth, over captures whose truth is drawn from the box.
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
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/identification/fit/fit.h"

namespace samara::benchmarks::identification {

namespace {

namespace id = samara::identification;

constexpr const char* kCase = "posterior_plate";
constexpr double kEnd = 3.0;
constexpr int kFrames = 40;
constexpr double kNoise = 0.02;  ///< of the semi-chord, and in rad

codebooks::Codebook plate_book() {
  return codebooks::build(codebooks::parse_plan(R"(
model = 'falling_plate_nd'
[fixed]
inertia_ratio = 1.1
beta = 0.0714
'theta(0)' = 0.4
[box]
C_T = [0.9, 1.5]
C_R = [2.4, 3.9]
A = [1.2, 1.7]
B = [0.7, 1.1]
mu1 = [0.1, 0.3]
[time]
end = 3
[tolerance]
relative = 1e-4
[builder]
kind = 'pgd'
)",
                                                "posterior_plate"))
      .book;
}

struct Synthetic {
  std::vector<double> truth;
  id::Capture capture;
};

Synthetic synthetic_of(const codebooks::Codebook& book, std::uint64_t number) {
  Stream random(11, number);
  Synthetic result;
  for (const codebooks::Coordinate& c : book.parameters())
    result.truth.push_back(c.lower + random.uniform() * (c.upper - c.lower));
  std::vector<double> times;
  for (int k = 0; k < kFrames; ++k) times.push_back(kEnd * k / (kFrames - 1));
  const std::vector<std::string> outputs = {"x", "y", "theta"};
  codebooks::TrajectoryQuery query(book, times, outputs);
  Eigen::MatrixXd values(kFrames, 3);
  query.values(result.truth, values);
  result.capture.id = "plate";
  result.capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), kFrames);
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    Eigen::VectorXd seen = values.col(static_cast<Eigen::Index>(o));
    for (double& value : seen) value += kNoise * random.normal();
    result.capture.channels.push_back({outputs[o], o < 2 ? "1" : "rad", seen});
  }
  return result;
}

id::FitResult drawn(const models::TrajectoryFamily& family, const id::Capture& capture, int samples) {
  id::FitOptions options;
  options.loss = {.kind = id::LossKind::none, .scales = {{"x", kNoise}, {"y", kNoise}, {"theta", kNoise}}};
  options.starts.count = 1;
  options.unknowns.offsets = std::vector<std::string>{};
  options.uncertainty.posterior.samples = samples;
  return id::fit(family, std::vector{capture}, options);
}

}  // namespace

void posterior_case(const Options& options) {
  if (!options.wants(kCase)) return;
  const codebooks::Codebook book = plate_book();
  const auto family = codebooks::codebook_trajectories(book);
  const std::size_t coefficients = book.parameters().size();

  const Synthetic one = synthetic_of(book, 0);
  id::FitResult result;
  const double time = time_of([&] { result = drawn(*family, one.capture, 16000); }, 3, 0.0);
  double effective = HUGE_VAL, rhat = 0.0;
  for (std::size_t k = 0; k < coefficients; ++k) {
    effective = std::min(effective, result.posterior->unknowns[k].effective);
    rhat = std::max(rhat, result.posterior->unknowns[k].rhat);
  }
  print({kBench, kCase, "time", time, "s"});
  print({kBench, kCase, "effective_draws", effective});
  print({kBench, kCase, "rhat", rhat});
  print({kBench, kCase, "evaluations", static_cast<double>(result.posterior->evaluations)});

  const int captures = options.quick ? 100 : 1000;
  std::vector<int> covered(static_cast<std::size_t>(captures));
  parallel_for(captures, [&](int n) {
    const Synthetic synthetic = synthetic_of(book, static_cast<std::uint64_t>(n + 1));
    const id::FitResult fit = drawn(*family, synthetic.capture, 400);
    for (std::size_t k = 0; k < coefficients && fit.posterior; ++k) {
      const id::PosteriorUnknown& unknown = fit.posterior->unknowns[k];
      covered[static_cast<std::size_t>(n)] +=
          unknown.lower <= synthetic.truth[k] && synthetic.truth[k] <= unknown.upper ? 1 : 0;
    }
  });
  double sum = 0.0;
  for (const int one_covered : covered) sum += one_covered;
  print({kBench, kCase, "coverage95", sum / (captures * static_cast<double>(coefficients))});
}

}  // namespace samara::benchmarks::identification
