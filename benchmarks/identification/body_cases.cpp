/// A card in air, seen for a second of its developed three-dimensional motion: coefficients from positions
/// and attitudes alone.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases.h"
#include "real_data.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/rotations.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks::identification {

namespace {

using samara::identification::Capture;
using samara::identification::Coefficient;
using samara::identification::FitOptions;
using samara::identification::FitResult;
using samara::models::Interval;

constexpr int kFrames = 241;
constexpr double kRate = 240.0;
constexpr double kNoise = 1e-3;
constexpr double kAngleNoise = 2.0 * std::numbers::pi / 180.0;
constexpr double kStartSpread = 0.35;
constexpr double kSegment = 15.0 / kRate;

using Values = std::map<std::string, double>;

const Values& card() {
  static const Values values = {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}};
  return values;
}

Values pattern(double C_D90, double C_T, double C_R) {
  return {{"C_D0", 0.05}, {"C_D90", C_D90}, {"C_T", C_T}, {"C_R", C_R}, {"C_w", 2.0}};
}

/// A second of the fall after an oblique release by 10 degrees, from a random moment on.
Capture capture(const Values& coefficients, pgd::Random& random) {
  const auto model = models::find_model("immersed_body");
  Values values = card();
  values.insert(coefficients.begin(), coefficients.end());
  const double direction = 2.0 * std::numbers::pi * random.uniform();
  const double tilt = 10.0 * std::numbers::pi / 180.0;
  const models::Quaternion q =
      models::rotation_exponential(tilt * Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0));
  values["qw(0)"] = q[0];
  values["qx(0)"] = q[1];
  values["qy(0)"] = q[2];
  values["qz(0)"] = q[3];
  const models::ParametricModel parametric(model, values, {});
  const double begin = 1.0 + random.uniform();
  std::vector<double> times;
  for (int k = 0; k < kFrames; ++k) times.push_back(begin + k / kRate);
  const auto trajectory = models::integrate(parametric, {}, times);
  Capture result;
  result.id = "card";
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), kFrames).array() - begin;
  const char* names[] = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  Eigen::MatrixXd seen = trajectory.states.leftCols(7);
  for (Eigen::Index frame = 0; frame < kFrames; ++frame) {
    for (Eigen::Index k = 0; k < 3; ++k) seen(frame, k) += kNoise * random.normal();
    const Eigen::Vector3d error(random.normal(), random.normal(), random.normal());
    const models::Quaternion attitude = {seen(frame, 3), seen(frame, 4), seen(frame, 5), seen(frame, 6)};
    const models::Quaternion turned =
        models::product(attitude, models::rotation_exponential(kAngleNoise * error));
    seen.row(frame).segment<4>(3) = Eigen::RowVector4d(turned.data());
  }
  for (Eigen::Index k = 0; k < 7; ++k) result.channels.push_back({names[k], k < 3 ? "m" : "1", seen.col(k)});
  return result;
}

FitResult fit_one(const Values& truth, std::uint64_t seed) {
  pgd::Random random(seed);
  const Capture seen = capture(truth, random);
  std::map<std::string, models::Interval> box;
  FitOptions options;
  for (const auto& [name, value] : truth) {
    box[name] = {0.2 * value, 3.0 * value};
    options.starts.initial[name] = value * (1.0 + kStartSpread * (2.0 * random.uniform() - 1.0));
  }
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-50.0, 50.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-20.0, 20.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-300.0, 300.0};
  options.loss = {.kind = samara::identification::LossKind::none, .length_scale = kNoise};
  options.loss.attitude_scale = kAngleNoise;
  options.segments.length = kSegment;
  options.starts.count = 1;
  const auto family =
      samara::models::step_trajectories(models::find_model("immersed_body"), card(), box, 1.05e-3);
  return samara::identification::fit(*family, std::vector{seen}, options);
}

void run(const std::string& test_case, const Values& truth, int seeds) {
  int converged = 0;
  std::vector<double> times;
  for (int seed = 1; seed <= seeds; ++seed) {
    const FitResult result = fit_one(truth, static_cast<std::uint64_t>(seed));
    times.push_back(result.seconds);
    bool near = true;
    for (const Coefficient& c : result.coefficients) {
      const bool asked = c.name == "C_T" || c.name == "C_R" || c.name == "C_w";
      if (asked && !(std::abs(c.value / truth.at(c.name) - 1.0) < 0.05)) near = false;
    }
    converged += near ? 1 : 0;
  }
  print({kBench, test_case, "converged_fraction", static_cast<double>(converged) / seeds});
  print({kBench, test_case, "time", median_of(times), "s"});
}

}  // namespace

void body_cases(const Options& options) {
  const int seeds = options.quick ? 5 : 20;
  if (options.wants("body3d_zz")) run("body3d_zz", pattern(0.31, 0.91, 0.61), seeds);
  if (options.wants("body3d_az")) run("body3d_az", pattern(0.61, 1.81, 1.21), seeds);
  if (options.wants("body3d_ar")) run("body3d_ar", pattern(0.61, 2.71, 0.91), seeds);
}

}  // namespace samara::benchmarks::identification
