/// What a frame of a followed motion takes on one core: a plate in its plane that is seen with its angle; a disc in
/// space seen as positions alone, with what is left of its hypotheses; and a body with fitted polynomials that is seen
/// with its attitude (a blimp).
#include <algorithm>
#include <chrono>
#include <map>
#include <vector>

#include "cases.h"
#include "samara/base/streams.h"
#include "samara/identification/following/follower.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

namespace samara::benchmarks::prediction {

namespace {

using samara::identification::Follower;
using samara::identification::FollowOptions;

constexpr const char* kFollowCase = "follow";
constexpr double kFrameTime = 0.01;  // s
constexpr int kFrames = 100;
constexpr int kFirst = 20;  ///< frames by which every start is found

struct FollowedBody {
  const char* name;
  std::string model;
  FollowOptions options;
  std::map<std::string, double> start;  ///< initial values of the motion that is seen
};

FollowedBody plate() {
  FollowOptions options;
  options.noise = {{"x", 1e-3}, {"y", 1e-3}, {"theta", 0.02}};
  options.fixed = {{"semi_chord", 0.035},
                   {"semi_thickness", 5e-4},
                   {"density", 1200.0},
                   {"fluid_density", 1.2},
                   {"B", 1.0},
                   {"mu2", 0.2}};
  for (const auto& [name, value] :
       std::map<std::string, double>{{"C_T", 1.2}, {"C_R", 1.5}, {"A", 1.4}, {"mu1", 0.2}})
    options.coefficients.push_back(
        {.name = name, .value = value, .deviation = 0.1, .drift = 0.05, .logarithmic = true});
  options.start = {{"vx", {0.0, 1.0}}, {"vy", {0.0, 1.0}}, {"w", {0.0, 8.0}}};
  options.model_noise = {.velocity = 0.1, .rate = 1.0};
  return {"plate", "falling_plate", options, {{"w(0)", 3.0}, {"theta(0)", 0.7}}};
}

FollowedBody disc() {
  FollowOptions options;
  options.noise = {{"x", 1e-3}, {"y", 1e-3}, {"z", 1e-3}};
  options.fixed = {{"a", 0.05},   {"b", 0.05}, {"c", 1e-3}, {"density", 100.0}, {"fluid_density", 1.2},
                   {"wz(0)", 0.0}};
  for (const auto& [name, value] :
       std::map<std::string, double>{{"C_D0", 0.1}, {"C_D90", 2.0}, {"C_T", 1.0}, {"C_R", 1.0}, {"C_w", 3.0}})
    options.coefficients.push_back(
        {.name = name, .value = value, .deviation = 0.1, .drift = 0.05, .logarithmic = true});
  for (const char* velocity : {"ux", "uy", "uz"}) options.start[velocity] = {0.0, 2.0};
  for (const char* rate : {"wx", "wy"}) options.start[rate] = {0.0, 5.0};
  options.model_noise = {.velocity = 0.1, .rate = 1.0, .states = {{"wz", 0.0}}};
  options.round_body = true;
  return {
      "disc", "immersed_body", options, {{"qw(0)", 0.94}, {"qx(0)", 0.27}, {"qy(0)", 0.21}, {"wx(0)", 1.0}}};
}

FollowedBody body() {
  FollowOptions options;
  options.noise = {{"x", 2e-3}, {"y", 2e-3}, {"z", 2e-3}};
  options.attitude_noise = 5e-3;
  options.fixed = {{"mass", 0.12},
                   {"I_x", 4e-3},
                   {"I_y", 5e-3},
                   {"I_z", 5e-3},
                   {"displaced_mass", 0.1132},
                   {"area", 0.25},
                   {"thrust_left", 0.02},
                   {"thrust_right", 0.02},
                   {"thrust_arm", 0.15}};
  for (const auto& [name, value] : std::map<std::string, double>{{"Cd0", 0.2},
                                                                 {"Cda", 4.0},
                                                                 {"Cl0", 0.1},
                                                                 {"Cla", 3.0},
                                                                 {"Cmy0", 0.01},
                                                                 {"Cmya", -0.1},
                                                                 {"K1", -0.1},
                                                                 {"K2", -0.1},
                                                                 {"K3", -0.1}})
    options.coefficients.push_back({.name = name, .value = value, .deviation = 0.1 * std::abs(value)});
  for (const char* velocity : {"ux", "uy", "uz"}) options.start[velocity] = {0.3, 0.5};
  for (const char* rate : {"wx", "wy", "wz"}) options.start[rate] = {0.0, 0.5};
  options.model_noise = {.velocity = 0.05, .rate = 0.05};
  return {"body", "coefficient_body", options, {{"qw(0)", 0.0}, {"qx(0)", 1.0}, {"ux(0)", 0.4}}};
}

void follow_body(const FollowedBody& followed) {
  const auto model = samara::models::find_model(followed.model);
  std::map<std::string, double> values = followed.start;
  for (const auto& [name, value] : followed.options.fixed) values.emplace(name, value);
  for (const auto& c : followed.options.coefficients) values.emplace(c.name, c.value);
  std::vector<double> times;
  for (int k = 0; k < kFrames; ++k) times.push_back(kFrameTime * k);
  const auto motion =
      samara::models::integrate(samara::models::ParametricModel(model, values, {}), {}, times);
  const auto& states = model->info().states;
  std::vector<double> seconds, forecasts;
  double hypotheses = 0.0;
  Stream random(1, 0);
  Follower follower(model, followed.options);
  std::vector<double> seen(follower.measured().size());
  for (int k = 0; k < kFrames; ++k) {
    for (std::size_t o = 0; o < seen.size(); ++o) {
      const auto state = std::ranges::find(states, follower.measured()[o], &samara::models::StateInfo::name);
      const auto noise = followed.options.noise.find(follower.measured()[o]);
      const double deviation = noise == followed.options.noise.end() ? 1e-3 : noise->second;
      seen[o] = motion.states(k, state - states.begin()) + deviation * random.normal();
    }
    const auto begin = std::chrono::steady_clock::now();
    const auto frame = follower.add(times[static_cast<std::size_t>(k)], seen);
    const auto end = std::chrono::steady_clock::now();
    if (k < kFirst) continue;
    seconds.push_back(std::chrono::duration<double>(end - begin).count());
    hypotheses += frame.hypotheses;
  }
  const double ahead = times.back() + 0.1;
  const double forecast_time = time_of([&] { follower.forecast({&ahead, 1}); });
  std::ranges::sort(seconds);
  const std::string name = followed.name;
  print({kBench, kFollowCase, "frame_time_" + name, seconds[seconds.size() / 2], "s"});
  print({kBench, kFollowCase, "longest_frame_" + name, seconds.back(), "s"});
  print({kBench, kFollowCase, "forecast_time_" + name, forecast_time, "s"});
  print({kBench, kFollowCase, "hypotheses_" + name, hypotheses / static_cast<double>(seconds.size())});
}

}  // namespace

void follow_case(const Options& options) {
  if (!options.wants(kFollowCase)) return;
  for (const FollowedBody& followed : {plate(), disc(), body()}) follow_body(followed);
}

}  // namespace samara::benchmarks::prediction
