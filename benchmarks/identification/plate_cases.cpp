/// The reference plate, fluttering and tumbling: coefficients and initial state from one noisy capture.
#include <algorithm>
#include <cmath>
#include <random>

#include <fmt/format.h>

#include "cases.h"
#include "samara/identification/fit.h"
#include "samara/identification/step_trajectories.h"
#include "samara/models/integrate.h"
#include "samara/pgd/random.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Capture;
using samara::identification::Coefficient;
using samara::identification::FitOptions;
using samara::identification::FitResult;
using samara::identification::FitStatus;
using samara::identification::Interval;

constexpr int kFrames = 60;
constexpr double kEnd = 6.0;
constexpr double kChord = 2.0;  ///< the unit of length is half of it
constexpr double kNoise = 0.01 * kChord;
constexpr double kAngleNoise = 2.0 * M_PI / 180.0;
/// A coefficient is identified if its standard error is less than this share of it.
constexpr double kIdentified = 0.05;
/// Starts of coefficients, relative to the truth.
constexpr double kStartSpread = 0.35;

struct Truth {
  std::string name;
  double value;
};

const std::vector<Truth>& coefficients() {
  static const std::vector<Truth> list = {{"C_T", 1.2}, {"C_R", M_PI}, {"A", 1.4}, {"mu1", 0.2}};
  return list;
}

std::map<std::string, double> fixed(double inertia_ratio) {
  return {{"inertia_ratio", inertia_ratio}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
}

/// The developed motion, seen by a camera from a random moment on.
Capture capture(double inertia_ratio, pgd::Random& random) {
  const auto model = models::find_model("falling_plate_nd");
  auto values = fixed(inertia_ratio);
  for (const Truth& c : coefficients()) values[c.name] = c.value;
  const models::ParametricModel parametric(model, values, {"theta(0)"});
  std::vector<double> times;
  const double begin = 20.0 + 20.0 * random.uniform();
  for (int k = 0; k < kFrames; ++k) times.push_back(begin + kEnd * k / (kFrames - 1));
  const double theta = 0.2 + 0.4 * random.uniform();
  const auto trajectory = models::integrate(parametric, std::vector{theta}, times);
  Capture result;
  result.id = "plate";
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), kFrames).array() - begin;
  const auto& states = model->info().states;
  for (std::size_t s = 0; s < states.size(); ++s) {
    const std::string& name = states[s].name;
    if (name != "x" && name != "y" && name != "theta") continue;
    Eigen::VectorXd seen = trajectory.states.col(static_cast<Eigen::Index>(s));
    for (double& value : seen) value += (name == "theta" ? kAngleNoise : kNoise) * random.normal();
    result.channels.push_back({name, "1", seen});
  }
  return result;
}

FitResult fit_one(double inertia_ratio, std::uint64_t seed) {
  pgd::Random random(seed);
  const Capture seen = capture(inertia_ratio, random);
  std::map<std::string, Interval> box;
  FitOptions options;
  for (const Truth& c : coefficients()) {
    box[c.name] = {0.2 * c.value, 3.0 * c.value};
    options.initial[c.name] = c.value * (1.0 + kStartSpread * (2.0 * random.uniform() - 1.0));
  }
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  box["theta(0)"] = {-60.0, 60.0};
  options.loss = {.kind = samara::identification::LossKind::none,
                  .scales = {{"x", kNoise}, {"y", kNoise}, {"theta", kAngleNoise}}};
  options.segments.length = 1.0;
  options.starts = 1;
  const auto family = samara::identification::step_trajectories(models::find_model("falling_plate_nd"),
                                                                fixed(inertia_ratio), box, 0.01);
  return samara::identification::fit(*family, std::vector{seen}, options);
}

/// By the fit's own account.
bool is_identified(const Coefficient& c) {
  return c.naive_standard_error && *c.naive_standard_error < kIdentified * std::abs(c.value);
}

double median(std::vector<double> values) {
  if (values.empty()) return std::nan("");
  std::ranges::nth_element(values, values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2));
  return values[values.size() / 2];
}

void run(const std::string& test_case, double inertia_ratio, int seeds) {
  int converged = 0;
  int identified = 0;
  int covered = 0;
  std::vector<double> errors, times;
  for (int seed = 1; seed <= seeds; ++seed) {
    const FitResult result = fit_one(inertia_ratio, static_cast<std::uint64_t>(seed));
    times.push_back(result.seconds);
    bool near = result.status == FitStatus::converged;
    for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
      const Coefficient& c = result.coefficients[k];
      const auto truth = std::ranges::find(coefficients(), c.name, &Truth::name);
      const double error = std::abs(c.value - truth->value);
      const double sigma = c.naive_standard_error.value_or(std::nan(""));
      near = near && error < 6.0 * sigma;
      if (!is_identified(c)) continue;
      ++identified;
      errors.push_back(error / truth->value);
      covered += error < 1.96 * sigma ? 1 : 0;
    }
    converged += near ? 1 : 0;
    if (!near && std::getenv("SAMARA_TRACE")) {
      fmt::print(stderr, "seed {}: {} cost {:.4g}", seed, result.message, result.cost);
      for (const Coefficient& c : result.coefficients) {
        fmt::print(stderr, "  {} {:.4f} +- {:.4f}", c.name, c.value, c.naive_standard_error.value_or(-1.0));
      }
      fmt::print(stderr, "\n");
    }
  }
  print({kBench, test_case, "converged_fraction", static_cast<double>(converged) / seeds});
  print({kBench, test_case, "median_error", median(errors)});
  print({kBench, test_case, "coverage95", static_cast<double>(covered) / std::max(1, identified)});
  print({kBench, test_case, "identified_fraction",
         static_cast<double>(identified) / (seeds * static_cast<double>(coefficients().size()))});
  print({kBench, test_case, "time", median(times), "s"});
}

}  // namespace

void plate_cases(const Options& options) {
  const int seeds = options.quick ? 20 : 200;
  if (options.wants("plate_flutter")) run("plate_flutter", 1.1, seeds);
  if (options.wants("plate_tumbling")) run("plate_tumbling", 1.4, seeds);
}

}  // namespace samara::benchmarks::identification
