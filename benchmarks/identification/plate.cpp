#include "plate.h"

#include <numbers>

#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::identification {

namespace {

constexpr int kFrames = 60;
constexpr double kEnd = 6.0;
constexpr double kChord = 2.0;  ///< the unit of length is half of it
constexpr double kNoise = 0.01 * kChord;
constexpr double kAngleNoise = 2.0 * std::numbers::pi / 180.0;

}  // namespace

const std::vector<Truth>& plate_coefficients() {
  static const std::vector<Truth> list = {{"C_T", 1.2}, {"C_R", std::numbers::pi}, {"A", 1.4}, {"mu1", 0.2}};
  return list;
}

std::map<std::string, double> plate_fixed(double inertia_ratio) {
  return {{"inertia_ratio", inertia_ratio}, {"beta", 1.0 / 14.0}, {"B", 1.0}};
}

samara::identification::Capture plate_capture(double inertia_ratio, pgd::Random& random) {
  const auto model = models::find_model("falling_plate_nd");
  auto values = plate_fixed(inertia_ratio);
  for (const Truth& c : plate_coefficients()) values[c.name] = c.value;
  const models::ParametricModel parametric(model, values, {"theta(0)"});
  const double begin = 20.0 + 20.0 * random.uniform();
  std::vector<double> times;
  for (int k = 0; k < kFrames; ++k) times.push_back(begin + kEnd * k / (kFrames - 1));
  const double theta = 0.2 + 0.4 * random.uniform();
  const auto trajectory = models::integrate(parametric, std::vector{theta}, times);
  samara::identification::Capture result;
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

std::map<std::string, samara::models::Interval> plate_box() {
  std::map<std::string, samara::models::Interval> box;
  for (const Truth& c : plate_coefficients()) box[c.name] = {0.2 * c.value, 3.0 * c.value};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  box["theta(0)"] = {-60.0, 60.0};
  return box;
}

samara::identification::FitOptions plate_options() {
  samara::identification::FitOptions options;
  options.loss = {.kind = samara::identification::LossKind::none,
                  .scales = {{"x", kNoise}, {"y", kNoise}, {"theta", kAngleNoise}}};
  options.segments.length = 1.0;
  options.starts.count = 1;
  return options;
}

}  // namespace samara::benchmarks::identification
