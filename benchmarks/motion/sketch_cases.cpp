// Falls along sketches, planned, beside the best of 512 falls at constant coefficients.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <numbers>

#include <fmt/format.h>

#include "motion/cases.h"
#include "samara/base/streams.h"
#include "samara/models/batch/watch_batch.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/planning/planner.h"
#include "samara/motion/records/motion_record.h"

namespace samara::benchmarks::motion_cases {

namespace {

using motion::MotionPlan;
using motion::MotionResult;

constexpr double kFall = 60.0;  ///< semi-chords

/// x as a function of the height fallen.
using Line = std::function<double(double)>;

motion::Sketch drawn(const Line& x, double height, const Line& y = {}) {
  constexpr int kPoints = 121;
  Eigen::MatrixX3d points(kPoints, 3);
  for (int k = 0; k < kPoints; ++k) {
    const double fallen = height * k / (kPoints - 1);
    points.row(k) << x(fallen), y ? y(fallen) : 0.0, height - fallen;
  }
  return motion::Sketch(points);
}

double s_line(double d) {
  return 6.0 * std::sin(2.0 * std::numbers::pi * d / kFall);
}

MotionPlan plate_plan(const Line& line) {
  MotionPlan plan;
  plan.model = models::find_model("falling_plate_nd");
  plan.fixed = {{"inertia_ratio", 1.3}, {"theta(0)", 0.6}, {"y(0)", kFall},
                {"C_T", 1.1},           {"C_R", 3.0},      {"A", 1.4}};
  plan.box = {{"C_T", 0.8, 1.4, 1.1}, {"C_R", 2.0, 4.0, 3.0}, {"A", 1.0, 1.8, 1.4}};
  plan.search.step = 0.01;
  plan.search.ramp = 1.0;
  plan.sketch = drawn(line, kFall);
  return plan;
}

/// The card of the dissertation, 2 m of air, released aslant: a bend to the side and forward.
MotionPlan card_plan() {
  MotionPlan plan;
  plan.model = models::find_model("immersed_body");
  const double half = 0.5 * 20.0 * std::numbers::pi / 180.0, axis = 35.0 * std::numbers::pi / 180.0;
  plan.fixed = {{"a", 0.035},
                {"b", 0.02},
                {"c", 5e-5},
                {"density", 1200.0},
                {"C_D0", 0.05},
                {"C_w", 2.0},
                {"C_D90", 1.2},
                {"C_T", 1.2},
                {"C_R", 1.2},
                {"z(0)", 2.0},
                {"qw(0)", std::cos(half)},
                {"qx(0)", std::sin(half) * std::cos(axis)},
                {"qy(0)", std::sin(half) * std::sin(axis)},
                {"qz(0)", 0.0}};
  plan.box = {{"C_D90", 0.6, 1.8, 1.2}, {"C_T", 0.6, 1.8, 1.2}, {"C_R", 0.6, 1.8, 1.2}};
  plan.search.step = 1e-3;
  plan.search.ramp = 0.03;
  plan.sketch = drawn([](double fallen) { return 0.3 * std::sin(0.5 * std::numbers::pi * fallen / 2.0); },
                      2.0, [](double fallen) { return 0.1 * fallen * fallen / 2.0; });
  return plan;
}

/// Root mean square deviations of falls at constant coefficients drawn in the box, the least first.
std::vector<double> uncontrolled(const MotionPlan& plan, int count) {
  std::map<std::string, double> fixed = plan.fixed;
  std::vector<std::string> names;
  for (const motion::SteeredCoefficient& coefficient : plan.box) {
    fixed.erase(coefficient.name);
    names.push_back(coefficient.name);
  }
  Eigen::MatrixXd points(count, static_cast<Eigen::Index>(names.size()));
  for (int n = 0; n < count; ++n) {
    Stream stream(512, static_cast<std::uint64_t>(n));
    for (std::size_t j = 0; j < names.size(); ++j) {
      points(n, static_cast<Eigen::Index>(j)) =
          plan.box[j].lower + (plan.box[j].upper - plan.box[j].lower) * stream.uniform();
    }
  }
  const motion::MotionStates states(plan.model->info());
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(count), times = Eigen::VectorXd::Zero(count);
  models::watch_batch(
      models::ParametricModel(plan.model, fixed, names), points,
      [&](Eigen::Index n, double t, std::span<const double> state) {
        const Eigen::Vector3d place = states.position(state);
        squares[n] += (place - plan.sketch->target(t, place)).squaredNorm();
        times[n] += 1.0;
        return place.z() > plan.ground;
      },
      {.step = plan.search.step, .interval = 5.0 * plan.search.step, .end = 4e4 * plan.search.step});
  std::vector<double> deviations;
  for (Eigen::Index n = 0; n < count; ++n) {
    const double rms = std::sqrt(squares[n] / times[n]);
    if (std::isfinite(rms)) deviations.push_back(rms);
  }
  std::ranges::sort(deviations);
  return deviations;
}

struct Followed {
  MotionResult motion;
  double best = 0.0;
};

Followed follow(const MotionPlan& plan) {
  return {.motion = plan_motion(plan), .best = uncontrolled(plan, 512).front()};
}

void report_sketch(const std::string& test_case, const MotionPlan& plan) {
  const Followed followed = follow(plan);
  const double a = plan.semi_length();
  print({.bench = kMotion,
         .test_case = test_case,
         .metric = "deviation",
         .value = followed.motion.deviation / a,
         .unit = "a",
         .baseline = "best_of_512",
         .ratio = followed.best / followed.motion.deviation});
  print({.bench = kMotion,
         .test_case = test_case,
         .metric = "best_of_512",
         .value = followed.best / a,
         .unit = "a"});
  print({.bench = kMotion,
         .test_case = test_case,
         .metric = "time",
         .value = followed.motion.seconds,
         .unit = "s"});
}

/// x = sum over m = 1..3 of (6/m) g_m sin(m pi d/60 + phi_m), from 0 on, g_m normal, phi_m uniform; drawn again until
/// it is nowhere flatter than 35 degrees off the vertical: plates of the box glide as far.
Line random_line(std::uint64_t seed) {
  for (std::uint64_t attempt = 0;; ++attempt) {
    Stream stream(seed, attempt);
    std::array<double, 3> size, phase;
    for (std::size_t m = 0; m < 3; ++m) {
      size[m] = 6.0 / static_cast<double>(m + 1) * stream.normal();
      phase[m] = 2.0 * std::numbers::pi * stream.uniform();
    }
    const Line sum = [size, phase](double d) {
      double x = 0.0;
      for (std::size_t m = 0; m < 3; ++m)
        x += size[m] * std::sin(static_cast<double>(m + 1) * std::numbers::pi * d / kFall + phase[m]);
      return x;
    };
    double steepest = 0.0;
    for (double d = 0.0; d < kFall; d += 0.5)
      steepest = std::max(steepest, std::abs(sum(d + 0.5) - sum(d)) / 0.5);
    if (steepest <= std::tan(35.0 * std::numbers::pi / 180.0))
      return [sum](double d) { return sum(d) - sum(0.0); };
  }
}

void run_fresh() {
  std::vector<double> ratios;
  for (std::uint64_t seed = 101; seed <= 110; ++seed) {
    const Followed followed = follow(plate_plan(random_line(seed)));
    ratios.push_back(followed.motion.deviation / followed.best);
    std::cerr << fmt::format("sketch_fresh, seed {}: {:.3f} a, best of 512 {:.3f} a\n", seed,
                             followed.motion.deviation, followed.best);
  }
  std::ranges::sort(ratios);
  print({.bench = kMotion,
         .test_case = "sketch_fresh",
         .metric = "ratio",
         .value = 0.5 * (ratios[4] + ratios[5])});
  print({.bench = kMotion, .test_case = "sketch_fresh", .metric = "largest_ratio", .value = ratios.back()});
}

double zigzag(double d) {
  const double u = d / 20.0, rest = u - std::floor(u);
  return 20.0 * (static_cast<int>(std::floor(u)) % 2 == 0 ? rest : 1.0 - rest);
}

}  // namespace

MotionPlan s_plan() {
  return plate_plan(s_line);
}

void run_sketches(const Options& options) {
  if (options.wants("sketch_s")) report_sketch("sketch_s", plate_plan(s_line));
  if (options.wants("sketch_slanted"))
    report_sketch("sketch_slanted",
                  plate_plan([](double d) { return d * std::tan(std::numbers::pi / 6.0); }));
  if (options.wants("sketch_zigzag")) report_sketch("sketch_zigzag", plate_plan(zigzag));
  if (options.wants("sketch_fresh")) run_fresh();
  if (!options.wants("sketch_3d")) return;
  const Followed followed = follow(card_plan());
  print({.bench = kMotion,
         .test_case = "sketch_3d",
         .metric = "ratio",
         .value = followed.motion.deviation / followed.best});
  print({.bench = kMotion,
         .test_case = "sketch_3d",
         .metric = "deviation",
         .value = followed.motion.deviation,
         .unit = "m"});
  print({.bench = kMotion,
         .test_case = "sketch_3d",
         .metric = "time",
         .value = followed.motion.seconds,
         .unit = "s"});
}

}  // namespace samara::benchmarks::motion_cases
