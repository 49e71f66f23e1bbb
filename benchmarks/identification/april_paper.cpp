#include "april_paper.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "real_data.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::Coefficient;
using samara::identification::FitOptions;
using samara::identification::FitResult;

namespace {

constexpr double kPaper = 0.160;       ///< kg/m^2
constexpr double kThickness = 2.0e-4;  ///< m, of such paper; not measured
constexpr double kAir = 1.2;           ///< kg/m^3
constexpr double kLongestGap = 8.5 / 240.0;
constexpr Eigen::Index kFewestFrames = 12;
constexpr double kPlaces = 10e-3;        ///< m: cameras agree to 20 mm
constexpr double kTurns = 0.35;          ///< rad: tags are seen at 20 degrees or worse
constexpr double kPriorDeviation = 1.0;  ///< of the logarithm of every coefficient
constexpr double kIdentified = 0.3;      ///< of the logarithm

const std::map<std::string, double>& usual() {
  static const std::map<std::string, double> values = {
      {"C_D0", 0.2}, {"C_D90", 2.0}, {"C_T", 1.0}, {"C_R", 1.0}, {"C_w", 2.0}};
  return values;
}

/// The frames with a whole pose.
Capture with_pose(const Capture& camera) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index k = 0; k < camera.times.size(); ++k) {
    const auto is_seen = [&](const auto& channel) { return std::isfinite(channel.values[k]); };
    if (std::ranges::all_of(camera.channels, is_seen)) seen.push_back(k);
  }
  Capture result = camera;
  result.times = Eigen::VectorXd(camera.times(seen));
  for (std::size_t c = 0; c < camera.channels.size(); ++c)
    result.channels[c].values = Eigen::VectorXd(camera.channels[c].values(seen));
  return result;
}

/// Where a frame is missed for long, a run ends.
std::vector<Capture> runs_of(const Capture& camera) {
  std::vector<Capture> runs;
  Eigen::Index first = 0;
  for (Eigen::Index k = 1; k <= camera.times.size(); ++k) {
    if (k < camera.times.size() && camera.times[k] - camera.times[k - 1] < kLongestGap) continue;
    if (k - first >= kFewestFrames) {
      Capture run = frames_of(camera, first, k - first, camera.times[first]);
      run.id = fmt::format("{} from {:.3f} s", camera.id, camera.times[first]);
      runs.push_back(std::move(run));
    }
    first = k;
  }
  return runs;
}

double logarithmic_error(const Coefficient& c) {
  const double error = std::max(c.standard_error.value_or(0.0), c.naive_standard_error.value_or(0.0));
  return error > 0.0 ? error / c.value : kPriorDeviation;
}

}  // namespace

std::vector<Capture> april_windows(const std::filesystem::path& folder) {
  const auto sidecar = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "april_tag_paper.toml";
  std::vector<Capture> windows;
  for (const Capture& piece : samara::identification::read_captures(folder / "vid220_fall.csv", sidecar)) {
    for (Capture& run : runs_of(with_pose(piece))) {
      run.labels["drop"] = "vid220";
      run.motion.clear();  // each is a window by itself
      windows.push_back(std::move(run));
    }
  }
  return windows;
}

std::unique_ptr<samara::models::TrajectoryFamily> april_family(double size) {
  // An ellipsoid with 3/4 of the thickness as semi-axis has the volume and the mass of the card.
  const double mass = kPaper * M_PI * size * size;
  const std::map<std::string, double> fixed = {{"a", size},
                                               {"b", size},
                                               {"c", 0.75 * kThickness},
                                               {"density", kPaper / kThickness},
                                               {"fluid_density", kAir},
                                               {"I_x", 0.25 * mass * size * size},
                                               {"I_y", 0.25 * mass * size * size},
                                               {"I_z", 0.5 * mass * size * size}};
  Box box = {{"C_D0", {0.01, 3.0}},
             {"C_D90", {0.1, 20.0}},
             {"C_T", {0.02, 10.0}},
             {"C_R", {0.02, 10.0}},
             {"C_w", {0.05, 50.0}}};
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-5.0, 5.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-4.0, 4.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-60.0, 60.0};
  return samara::models::step_trajectories(models::find_model("immersed_body"), fixed, box, 2.1e-3);
}

FitOptions april_options() {
  FitOptions options;
  for (const auto& [name, value] : usual()) {
    options.starts.initial[name] = value;
    options.unknowns.log_scale.push_back(name);
    options.priors.coordinates[name] = {.mean = value, .deviation = kPriorDeviation, .logarithmic = true};
  }
  options.compared.outputs = {"x", "y", "z", "qw", "qx", "qy", "qz"};
  options.loss = {.kind = samara::identification::LossKind::cauchy, .length_scale = kPlaces};
  options.loss.attitude_scale = kTurns;
  options.segments.length = 10.0;  // each run is one
  options.starts.count = 1;
  options.starts.rounds = 2;
  options.solver.max_iterations = 40;
  return options;
}

std::vector<AprilVariant> april_variants(const std::vector<Capture>& windows, bool cameras) {
  const auto family = april_family(kAprilSize);
  FitOptions doubtful = april_options();
  doubtful.loss.attitude_scale *= 3.0;
  std::vector<AprilVariant> variants = {
      {"the size of the card",
       samara::identification::fit(*april_family(1.5 * kAprilSize), windows, april_options())},
      {"how far angles are believed", samara::identification::fit(*family, windows, doubtful)}};
  for (const char* camera : {"1", "2", "3"}) {
    if (!cameras) break;
    std::vector<Capture> others;
    for (const Capture& window : windows) {
      if (window.labels.at("cam") != camera) others.push_back(window);
    }
    variants.push_back(
        {fmt::format("camera {}", camera), samara::identification::fit(*family, others, april_options())});
  }
  return variants;
}

std::vector<AprilVerdict> april_verdicts(const FitResult& fitted, const std::vector<AprilVariant>& variants) {
  std::vector<AprilVerdict> verdicts;
  for (const Coefficient& c : fitted.coefficients) {
    AprilVerdict v{.name = c.name, .value = c.value, .error = logarithmic_error(c)};
    std::string doubt;
    for (const AprilVariant& variant : variants) {
      const auto& others = variant.fit.coefficients;
      const auto other = std::ranges::find(others, c.name, &Coefficient::name);
      const double change =
          other == others.end() ? kPriorDeviation : std::abs(std::log(other->value / c.value));
      if (change < v.change) continue;
      v.change = change;
      doubt = variant.doubt;
    }
    v.identified = !c.at_bound && c.determined && v.error < kIdentified && v.change < kIdentified;
    const double percent = 100.0 * std::max(v.error, v.change);
    v.words = v.identified                      ? fmt::format("{:.3g} within {:.0f} %", c.value, percent)
              : c.at_bound                      ? "at a bound of its box"
              : v.error > 0.7 * kPriorDeviation ? "not identified: what was assumed beforehand decides"
              : v.change > v.error              ? fmt::format("not identified: {} decides", doubt)
                                                : "not identified: windows disagree";
    verdicts.push_back(std::move(v));
  }
  return verdicts;
}

}  // namespace samara::benchmarks::identification
