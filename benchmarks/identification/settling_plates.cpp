#include "settling_plates.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "real_data.h"
#include "samara/base/errors.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/models/batch/batch.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::identification::FitResult;
using samara::identification::Flutter;

namespace {

constexpr double kSide = 0.01;                    ///< m
constexpr double kStep = 4.2e-3;                  ///< s: eight a frame
constexpr double kFrameRate = 30.0;               ///< Hz
constexpr double kFall = 12.0, kTransient = 4.0;  ///< s
constexpr double kSpeedWeight = 0.01, kFrequencyWeight = 0.01, kAmplitudeWeight = 0.03;
constexpr double kTilts[] = {0.05, 0.1, 0.16, 0.22, 0.28, 0.34, 0.4, 0.46, 0.52, 0.58, 0.64, 0.7};  ///< rad

const std::vector<std::string>& coefficient_names() {
  static const std::vector<std::string> names = {"C_D0", "C_D90", "C_R", "C_T", "C_w"};
  return names;
}

std::map<std::string, double> plate(const PlateKind& kind) {
  const double thickness = kind.volume / (kSide * kSide);
  const double radius = kSide / std::sqrt(std::numbers::pi);
  const double mass = kind.density * kind.volume;
  const double in_plane = mass * (kSide * kSide + thickness * thickness) / 12.0;
  return {{"a", radius},
          {"b", radius},
          {"c", 0.75 * thickness},
          {"density", kind.density},
          {"fluid_density", kWater},
          {"I_x", in_plane},
          {"I_y", in_plane},
          {"I_z", mass * kSide * kSide / 6.0},
          {"speed_floor", 2e-3},
          {"rate_floor", 0.3},
          {"wz(0)", 0.0}};
}

Flutter medians(const std::vector<Flutter>& all) {
  std::vector<double> speed;
  std::vector<double> frequency;
  std::vector<double> amplitude;
  for (const Flutter& one : all) {
    speed.push_back(one.fall_speed);
    frequency.push_back(one.frequency);
    amplitude.push_back(one.amplitude);
  }
  return {median_of(speed), median_of(frequency), median_of(amplitude)};
}

/// Covariance of the logarithms of the coefficients over the fits of a bootstrap, which go where the cost
/// bends.
Eigen::MatrixXd scatter_of_logs(const samara::identification::Bootstrap& bootstrap) {
  Eigen::MatrixXd logs = bootstrap.coefficients.array().log();
  logs.rowwise() -= logs.colwise().mean().eval();
  return logs.transpose() * logs / static_cast<double>(logs.rows() - 1);
}

/// The joint cost around the optimum of the windows.
class Joint {
 public:
  Joint(const PlateKind& kind, const FitResult& windows, const Flutter& measured)
      : kind_(kind), measured_(measured), centre_(static_cast<Eigen::Index>(windows.coefficients.size())) {
    const auto n = centre_.size();
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto& a = windows.coefficients[static_cast<std::size_t>(i)];
      names_.push_back(a.name);
      centre_[i] = std::log(a.value);
    }
    Eigen::MatrixXd covariance = windows.bootstrap ? scatter_of_logs(*windows.bootstrap) : Eigen::MatrixXd();
    for (Eigen::Index i = 0; i < n && !windows.bootstrap; ++i) {
      covariance.conservativeResize(n, n);
      for (Eigen::Index k = 0; k < n; ++k) {
        const double value = windows.covariance(i, k) / std::exp(centre_[i] + centre_[k]);
        // What the windows do not determine is known within a factor of e.
        covariance(i, k) = std::isfinite(value) ? value : (i == k ? 1.0 : 0.0);
      }
    }
    // Few drops leave the covariance nearly singular: 3 % of each coefficient are never known.
    covariance.diagonal().array() += 0.03 * 0.03;
    inverse_ = covariance.ldlt();
  }

  const Eigen::VectorXd& centre() const { return centre_; }

  JointFit operator()(const Eigen::VectorXd& logs) const {
    JointFit fit;
    for (std::size_t k = 0; k < names_.size(); ++k) {
      fit.coefficients[names_[k]] = std::exp(logs[static_cast<Eigen::Index>(k)]);
    }
    const Eigen::VectorXd d = logs - centre_;
    fit.cost.windows = 0.5 * d.dot(inverse_.solve(d));
    const std::optional<Flutter> simulated = simulated_flutter(kind_, fit.coefficients);
    if (!simulated) {
      fit.cost.statistics = std::numeric_limits<double>::infinity();
      return fit;
    }
    fit.simulated = *simulated;
    const auto part = [](double value, double wanted, double weight) {
      return 0.5 * std::pow(std::log(std::max(value, 1e-6) / wanted) / weight, 2);
    };
    fit.cost.statistics = part(simulated->fall_speed, measured_.fall_speed, kSpeedWeight) +
                          part(simulated->frequency, measured_.frequency, kFrequencyWeight) +
                          part(simulated->amplitude, measured_.amplitude, kAmplitudeWeight);
    return fit;
  }

 private:
  const PlateKind& kind_;
  Flutter measured_;
  std::vector<std::string> names_;
  Eigen::VectorXd centre_;
  Eigen::LDLT<Eigen::MatrixXd> inverse_;
};

double total(const JointFit& fit) {
  return fit.cost.windows + fit.cost.statistics;
}

}  // namespace

const PlateKind& plate_kind(const std::string& material) {
  static const PlateKind kinds[] = {{"POM", 0.133e-6, 1410.0, 1.5, 15, 6},
                                    {"PTFE", 0.089e-6, 2175.0, 1.0, 11, 4}};
  const auto* const kind = std::ranges::find(kinds, material, &PlateKind::material);
  if (kind == std::end(kinds)) throw ArgumentError("there is no plate of " + material);
  return *kind;
}

namespace {

std::vector<Capture> read_drops(const std::filesystem::path& folder, const PlateKind& kind,
                                const char* sidecar) {
  std::vector<Capture> drops;
  for (const char* position : {"pos1", "pos2", "pos3"}) {
    const auto table = folder / fmt::format("{}_1x1_{}.csv", kind.material, position);
    const auto captures = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures";
    for (Capture& drop : samara::identification::read_captures(table, captures / sidecar))
      drops.push_back(std::move(drop));
  }
  return drops;
}

}  // namespace

std::vector<Capture> plate_drops(const std::filesystem::path& folder, const PlateKind& kind) {
  return read_drops(folder, kind, "settling_plates.toml");
}

std::vector<Capture> flagged_plate_drops(const std::filesystem::path& folder, const PlateKind& kind) {
  std::vector<Capture> drops = read_drops(folder, kind, "settling_plates_all.toml");
  const std::vector<Capture> clean = plate_drops(folder, kind);
  std::erase_if(drops,
                [&](const Capture& drop) { return std::ranges::count(clean, drop.id, &Capture::id) > 0; });
  return drops;
}

Eigen::MatrixXcd silhouettes_of(const Capture& drop) {
  Eigen::MatrixXcd views(drop.frame_count(), 2);
  views.real() << drop.channel("aspect_1").values, drop.channel("area_1").values;
  views.imag() << drop.channel("aspect_2").values, drop.channel("area_2").values;
  return views;
}

Flutter measured_flutter(const std::vector<Capture>& drops, const PlateKind& kind) {
  std::vector<Flutter> all;
  for (const Capture& drop : drops) {
    const auto one = samara::identification::typical_flutter(drop.times, positions_of(drop), kind.part);
    if (one) all.push_back(*one);
  }
  return medians(all);
}

std::unique_ptr<samara::models::TrajectoryFamily> plate_family(const PlateKind& kind) {
  Box box = disc_start_box(2.0, 0.4, 40.0);
  for (const std::string& name : coefficient_names()) box[name] = {0.01, 50.0};
  return samara::models::step_trajectories(models::find_model("immersed_body"), plate(kind), box, kStep);
}

FitOptions settling_options() {
  return disc_options({{"C_D0", 0.3}, {"C_D90", 4.0}, {"C_T", 1.5}, {"C_R", 1.0}, {"C_w", 3.0}}, 1e-3,
                      "drop");
}

std::optional<Flutter> simulated_flutter(const PlateKind& kind, const Coefficients& coefficients) {
  std::map<std::string, double> fixed = plate(kind);
  fixed.insert(coefficients.begin(), coefficients.end());
  const models::ParametricModel model(models::find_model("immersed_body"), fixed, {"qw(0)", "qx(0)"});
  Eigen::MatrixXd points(std::ssize(kTilts), 2);
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    points.row(k) << std::cos(0.5 * kTilts[k]), std::sin(0.5 * kTilts[k]);
  }
  std::vector<double> times;
  for (int k = 0; k <= static_cast<int>(kFall * kFrameRate); ++k) times.push_back(k / kFrameRate);
  const auto batch = models::integrate_batch(model, points, times, {.step = kStep});
  const auto first = static_cast<Eigen::Index>(kTransient * kFrameRate);
  const Eigen::Index count = batch.times.size() - first;
  std::vector<Flutter> all;
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    if (batch.status[static_cast<std::size_t>(k)] != models::BatchStatus::done) continue;
    const Eigen::MatrixX3d positions = batch.states.block(0, batch.column(k, first), 3, count).transpose();
    const auto one = samara::identification::typical_flutter(batch.times.tail(count), positions, kind.part);
    if (one) all.push_back(*one);
  }
  if (all.empty()) return {};
  return medians(all);
}

JointFit fit_jointly(const PlateKind& kind, const FitResult& windows, const Flutter& measured, int sweeps) {
  const Joint joint(kind, windows, measured);
  // Statistics of simulations are not smooth: a search by comparisons, along each coefficient and along the
  // last way that led down.
  Eigen::VectorXd at = joint.centre();
  JointFit best = joint(at);
  Eigen::VectorXd steps = Eigen::VectorXd::Constant(at.size(), 0.3);
  for (int sweep = 0; sweep < sweeps && steps.maxCoeff() > 1e-3; ++sweep) {
    const Eigen::VectorXd before = at;
    const auto attempt = [&](const Eigen::VectorXd& trial) {
      JointFit there = joint(trial);
      if (!(total(there) < total(best))) return false;
      best = std::move(there);
      at = trial;
      return true;
    };
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      const Eigen::VectorXd step = steps[k] * Eigen::VectorXd::Unit(at.size(), k);
      const bool found = attempt(at + step) || attempt(at - step);
      steps[k] *= found ? 1.5 : 0.5;
    }
    if (before != at) attempt(at + (at - before));
  }
  return best;
}

}  // namespace samara::benchmarks::identification
