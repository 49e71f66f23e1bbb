#include "samara/identification/fit/mass_check.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/solve/held_noise.h"
#include "samara/identification/statistics/loss.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::identification {

namespace {

/// Another mass is believed if it leaves at most this share of the cost.
constexpr double kFarBetter = 0.25;
constexpr double kMissed = 5.0;  ///< loss scales
constexpr int kMostIterations = 50;

bool is_at_bound(const FitResult& fit) {
  return std::ranges::any_of(fit.coefficients, &Coefficient::at_bound);
}

/// What counts as a large residual; empty where none was given.
std::optional<double> scale_of(const OutputRms& output, const FitResult& fit, const FitOptions& options) {
  const auto scale = options.loss.scales.find(output.output);
  if (scale != options.loss.scales.end()) return scale->second;
  if (output.unit == "m") return options.loss.length_scale;
  for (const NoiseLevel& level : fit.noise) {
    if (std::ranges::count(level.outputs, output.output) > 0)
      return efficient_bend(options.loss.kind) * level.value;
  }
  return {};
}

bool misses_captures(const FitResult& fit, const FitOptions& options) {
  return std::ranges::any_of(fit.residuals, [&](const OutputRms& r) {
    const std::optional<double> scale = scale_of(r, fit, options);
    return scale && r.unit != "rad" && r.rms > kMissed * *scale;
  });
}

/// The parameter that makes the body heavy, if it was held for all captures or known for each.
std::optional<std::string> held_mass(const models::ParametricModel& model, const FitOptions& options) {
  for (const char* name : {"mass", "density"}) {
    if (model.fixed().contains(name) || options.unknowns.known.contains(name)) return name;
  }
  return {};
}

/// The same fit of a body of another mass.
class OtherMasses {
 public:
  OtherMasses(const models::TrajectoryFamily& family, std::span<const Capture> captures,
              const FitOptions& options, const FitResult& fitted, std::string name)
      : model_(*family.equations()),
        captures_(captures.begin(), captures.end()),
        options_(options),
        name_(std::move(name)) {
    for (const models::FamilyCoordinate& c : family.info().coordinates) box_[c.name] = {c.lower, c.upper};
    options_.uncertainty = options_.uncertainty.without_intervals();
    options_.starts.global = {};
    options_.starts.count = 1;
    options_.starts.rounds = 1;
    options_.progress = {};
    options_.solver.max_iterations = std::min(options_.solver.max_iterations, kMostIterations);
    // Costs are comparable where residuals have the same scales. A fit that failed has none.
    if (!fitted.noise.empty()) hold_noise(fitted, options_);
  }

  std::optional<FitResult> fit_with(double factor) const {
    std::map<std::string, double> fixed = model_.fixed();
    FitOptions options = options_;
    if (const auto held = fixed.find(name_); held != fixed.end()) {
      held->second *= factor;
      if (options.unknowns.fixed.contains(name_)) options.unknowns.fixed[name_] = held->second;
    }
    std::map<std::string, models::Interval> box = box_;
    for (auto* intervals : {&box, &options.unknowns.box}) {
      if (const auto known = intervals->find(name_); known != intervals->end())
        known->second = {factor * known->second.lower, factor * known->second.upper};
    }
    if (const auto known = options.unknowns.known.find(name_); known != options.unknowns.known.end())
      known->second.times *= factor;
    try {
      const auto family = options.solver.step
                              ? step_trajectories(model_.shared_model(), fixed, box, *options.solver.step)
                              : reference_trajectories(model_.shared_model(), fixed, box);
      FitResult result = fit(*family, captures_, options);
      if (result.status != Termination::failed) return result;
    } catch (const Error&) {
      // No body can have that mass; the fit that is in doubt stands.
    }
    return {};
  }

 private:
  const models::ParametricModel& model_;
  std::vector<Capture> captures_;
  FitOptions options_;
  std::string name_;
  std::map<std::string, models::Interval> box_;
};

std::string power_text(int power) {
  return power > 0 ? fmt::format("10^{} times as large", power) : fmt::format("10^{} times as small", -power);
}

}  // namespace

std::vector<std::string> check_mass(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                                    const FitOptions& options, const FitResult& fitted) {
  if (family.equations() == nullptr) return {};
  const bool failed = fitted.status == Termination::failed;
  if (!failed && !is_at_bound(fitted) && !misses_captures(fitted, options)) return {};
  const std::optional<std::string> name = held_mass(*family.equations(), options);
  if (!name) return {};
  const OtherMasses others(family, captures, options, fitted, *name);
  double least = failed ? std::numeric_limits<double>::infinity() : kFarBetter * fitted.cost;
  std::optional<int> best;
  for (const int power : {-4, -3, -2, -1, 1, 2, 3, 4}) {
    const std::optional<FitResult> other = others.fit_with(std::pow(10.0, power));
    if (!other || is_at_bound(*other) || !(other->cost < least)) continue;
    if (failed && misses_captures(*other, options)) continue;
    least = other->cost;
    best = power;
  }
  if (!best) return {};
  if (failed) {
    return {fmt::format("the mass of the body is in doubt: the fit fails, and with a {} {} it does not",
                        *name, power_text(*best))};
  }
  return {
      fmt::format("the mass of the body is in doubt: a {} {} would leave {:.2g} of the cost, with every "
                  "coefficient inside its box",
                  *name, power_text(*best), least / fitted.cost)};
}

}  // namespace samara::identification
