#include "samara/identification/fit/fit_warnings.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/identification/captures/capture_suspicions.h"
#include "samara/identification/captures/gravity_check.h"
#include "samara/identification/problem/camera.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/segments.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

void warn_about_bounds(FitResult& result) {
  for (const Coefficient& c : result.coefficients) {
    if (!c.at_bound || !c.determined) continue;
    result.warnings.add(WarningKind::bounds,
                        fmt::format("{} = {:.6g} lies at a bound of its box, {:.6g} to {:.6g}: its best "
                                    "value is probably outside, and it has no standard error",
                                    c.name, c.value, c.lower, c.upper));
  }
  std::map<std::string, std::vector<std::string>> captures;
  for (const CaptureFit& capture : result.captures) {
    for (const Nuisance& n : capture.nuisances) {
      if (n.at_bound) captures[n.name].push_back(fmt::format("\"{}\"", capture.id));
    }
  }
  for (const auto& [name, ids] : captures) {
    result.warnings.add(WarningKind::bounds,
                        fmt::format("{} lies at a bound of its box in {} of {} captures: {}", name,
                                    ids.size(), result.captures.size(), join(ids)));
  }
}

constexpr double kFar = 4.0;  // deviations of a prior
constexpr const char* kClash = "what was known of it beforehand and the captures contradict each other";

/// Answers that what was known of an unknown beforehand all but rules out. Combinations say how unknowns go together,
/// and are left out.
void warn_about_priors(const FitProblem& problem, const FitPoint& point, FitResult& result) {
  for (const PriorTerm& prior : problem.priors) {
    if (prior.weights().size() > 1) continue;
    const Coefficient& c = result.coefficients[static_cast<std::size_t>(prior.weights().front().unknown)];
    add_prior_warning(c.name, c.value, std::abs(prior.residual(point.shared.data())), result.warnings);
  }
  for (const PriorTerm& prior : problem.own_priors) {
    const auto unknown = static_cast<std::size_t>(prior.weights().front().unknown);
    double farthest = 0.0;
    std::vector<std::string> ids;
    for (const Motion& motion : problem.motions) {
      const double away = std::abs(prior.residual(point.own[motion.first_segment].data()));
      if (!(away > kFar)) continue;
      farthest = std::max(farthest, away);
      ids.push_back(fmt::format("\"{}\"", motion.id));
    }
    if (ids.empty()) continue;
    result.warnings.add(
        WarningKind::model,
        fmt::format("{} lies up to {:.3g} deviations of its prior from the prior's mean in {} of {} "
                    "captures, {}: {}",
                    result.captures.front().nuisances[unknown].name, farthest, ids.size(),
                    result.captures.size(), join(ids), kClash));
  }
}

void warn_about_undetermined(const Uncertainty& uncertainty, FitResult& result) {
  for (const std::vector<int>& set : uncertainty.undetermined_sets) {
    std::vector<std::string> names;
    for (const int k : set) names.push_back(result.coefficients[static_cast<std::size_t>(k)].name);
    result.warnings.add(
        WarningKind::undetermined,
        names.size() == 1
            ? fmt::format("the captures do not determine {}: it can change without changing the residuals",
                          names[0])
            : fmt::format(
                  "the captures do not determine {}: they can change together without changing the residuals",
                  join(names)));
  }
  for (const std::vector<int>& set : uncertainty.sets_held_by_priors) {
    std::vector<std::string> names;
    for (const int k : set) names.push_back(result.coefficients[static_cast<std::size_t>(k)].name);
    result.warnings.add(
        WarningKind::undetermined,
        fmt::format("the captures alone do not determine {}: what is said of {} rests on the priors",
                    join(names), names.size() == 1 ? "it" : "them"));
  }
  std::size_t segment = 0;
  for (std::size_t c = 0; c < result.captures.size(); ++c) {
    const OwnUncertainty& own = uncertainty.own[segment];
    segment += static_cast<std::size_t>(result.captures[c].segments);
    for (std::size_t k = 0; k < result.captures[c].nuisances.size(); ++k) {
      if (own.determined[k]) continue;
      result.warnings.add(WarningKind::undetermined,
                          fmt::format("capture \"{}\" does not determine its {}", result.captures[c].id,
                                      result.captures[c].nuisances[k].name));
    }
  }
  for (const Coefficient& c : result.coefficients) {
    const double error = std::max(c.standard_error.value_or(0.0), c.naive_standard_error.value_or(0.0));
    if (error < 0.5 * (c.upper - c.lower)) continue;
    result.warnings.add(
        WarningKind::undetermined,
        fmt::format("the captures say little about {}: its standard error {:.3g} is half its box "
                    "or more",
                    c.name, error));
  }
}

/// Unknowns of cameras whose errors are those of what was known beforehand.
void warn_about_camera(const FitProblem& problem, FitResult& result) {
  constexpr double kNothingNew = 0.95;
  const std::vector<std::string> names = camera_unknowns(problem);
  for (std::size_t k = 0; k < names.size(); ++k) {
    const double before = problem.camera->deviations[k];
    const auto is_new = [&](const CaptureFit& capture) {
      const std::size_t at = capture.nuisances.size() - names.size() + k;
      return capture.nuisances[at].standard_error.value_or(before) < kNothingNew * before;
    };
    if (std::ranges::any_of(result.captures, is_new)) continue;
    result.warnings.add(WarningKind::undetermined,
                        fmt::format("the captures say nothing of the {} of their camera{} that was not known "
                                    "beforehand: its errors are those of the deviation given",
                                    names[k], result.captures.size() == 1 ? "" : "s"));
  }
}

/// Delays and gains of captures of which their range says as much as the captures do.
void warn_about_measurement(const FitProblem& problem, FitResult& result) {
  for (std::size_t k = 0; k < problem.own.size(); ++k) {
    const models::FamilyCoordinate& own = problem.own[k];
    if (!is_of_measurement(problem, static_cast<int>(k))) continue;
    std::vector<std::string> ids;
    for (const CaptureFit& capture : result.captures) {
      if (capture.nuisances[k].standard_error.value_or(0.0) >= 0.5 * (own.upper - own.lower))
        ids.push_back(fmt::format("\"{}\"", capture.id));
    }
    if (ids.empty()) continue;
    result.warnings.add(
        WarningKind::undetermined,
        fmt::format("captures that say little about their {}, with a standard error of half its "
                    "range or more: {} of {}, {}",
                    own.name, ids.size(), result.captures.size(), join(ids)));
  }
}

void warn_about_errors(const Uncertainty& uncertainty, FitResult& result) {
  if (result.coefficients.empty()) return;
  if (result.clusters < 2) {
    result.warnings.add(WarningKind::errors,
                        "there is only one cluster of captures: the standard errors take all frames as "
                        "independent and are usually much too small");
  } else if (result.clusters <= static_cast<int>(result.coefficients.size())) {
    result.warnings.add(WarningKind::errors,
                        fmt::format("{} coefficients rest on {} clusters of captures: their covariance is "
                                    "singular, their errors are rough",
                                    result.coefficients.size(), result.clusters));
  }
  const bool has_naive = std::ranges::any_of(result.coefficients, [](const Coefficient& c) {
    return c.naive_standard_error || c.at_bound || !c.determined;
  });
  if (!has_naive)
    result.warnings.add(WarningKind::errors,
                        "there are no more values than unknowns: nothing says how large the noise is");
  if (uncertainty.beyond_bend) {
    result.warnings.add(WarningKind::errors,
                        "too many residuals lie beyond the bend of the loss: the standard errors are rough; "
                        "a larger loss scale is advised");
  }
}

std::string values_text(const FitResult& result, const StartRecord& start) {
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < start.coefficients.size(); ++k) {
    texts.push_back(fmt::format("{} = {:.5g}", result.coefficients[k].name, start.coefficients[k]));
  }
  return join(texts);
}

/// Farther from the best than a hundredth of the box, in any coefficient.
bool is_elsewhere(const FitResult& result, const StartRecord& start) {
  for (std::size_t k = 0; k < start.coefficients.size(); ++k) {
    const Coefficient& c = result.coefficients[k];
    if (std::abs(start.coefficients[k] - c.value) > 0.01 * (c.upper - c.lower)) return true;
  }
  return false;
}

void warn_about_starts(const Uncertainty& uncertainty, FitResult& result) {
  if (result.starts.size() > 1 && result.starts_at_best == 1) {
    result.warnings.add(WarningKind::optima,
                        fmt::format("only one of {} starts reached the best cost: others may be better still",
                                    result.starts.size()));
  }
  if (!uncertainty.undetermined_sets.empty()) return;
  for (std::size_t k = 0; k < result.starts.size(); ++k) {
    const StartRecord& start = result.starts[k];
    if (start.status != Termination::converged || !is_elsewhere(result, start)) continue;
    if (start.cost > 1.1 * result.cost && !start.reached_best) continue;
    const double excess = result.cost > 0.0 ? 100.0 * (start.cost / result.cost - 1.0) : 0.0;
    result.warnings.add(WarningKind::optima,
                        fmt::format("start {} ended in another optimum, {}, at a cost only {:.2g} % higher",
                                    k + 1, values_text(result, start), excess));
  }
}

/// @param scale of the loss, in the unit of the residual
void warn_about_misfit(const OutputRms& residual, double scale, FitResult& result) {
  constexpr double kMany = 5.0;
  if (!(residual.rms > kMany * scale)) return;
  const std::string unit = unit_suffix(residual.unit);
  result.warnings.add(
      WarningKind::model,
      fmt::format(
          "the model misses {} by {:.3g}{} in the root mean square, {:.2g} times the loss scale of "
          "{:.3g}{}: perhaps the model, what is fixed, a unit or the span is not that of the captures",
          residual.output, residual.rms, unit, residual.rms / scale, scale, unit));
}

/// Of a body of the family that is let go; true where its equations are not known.
bool falls_in_middle(const models::TrajectoryFamily& family) {
  if (family.equations() == nullptr) return true;
  std::vector<double> middle;
  for (const models::FamilyCoordinate& c : family.info().coordinates)
    middle.push_back(0.5 * (c.lower + c.upper));
  return falls(*family.equations(), middle);
}

}  // namespace

void add_prior_warning(const std::string& what, double value, double away, Warnings& warnings) {
  if (!(away > kFar)) return;
  warnings.add(WarningKind::model,
               fmt::format("{} = {:.6g} lies {:.3g} deviations of its prior from the prior's mean: {}", what,
                           value, away, kClash));
}

void add_misfit_warnings(const FitProblem& problem, FitResult& result) {
  for (std::size_t o = 0; o < problem.outputs.size() && o < result.residuals.size(); ++o) {
    if (problem.outputs[o].scale_is_stated)
      warn_about_misfit(result.residuals[o], problem.outputs[o].scale, result);
  }
  // The attitude comes after the outputs, where it was compared.
  if (!problem.attitude_scale || result.residuals.size() == problem.outputs.size()) return;
  if (problem.loss != LossKind::none || *problem.attitude_scale != LossOptions{}.attitude_scale)
    warn_about_misfit(result.residuals.back(), *problem.attitude_scale, result);
}

void add_start_warning(const models::TrajectoryFamily& family, const FitOptions& options, FitResult& result) {
  if (!options.segments.length || family.equations() != nullptr) return;
  result.warnings.add(
      WarningKind::segments,
      fmt::format("the equations of the {} of \"{}\" are not known: segments began in the middle of their "
                  "boxes, not where the captures show them, and in one round",
                  result.source, result.model));
}

std::vector<std::string> moved_times(const models::FamilyInfo& family, std::span<const Capture> captures) {
  // Segments of a series know by their clock when they begin.
  if (family.autonomous || !family.clock.empty()) return {};
  std::vector<std::pair<std::string, std::string>> found;
  for (const Capture& capture : captures) {
    if (capture.start == 0.0) continue;
    found.emplace_back(
        capture.id,
        fmt::format("{:.6g} s in its table is time 0 in the equations of \"{}\", which depend on time; "
                    "start = \"as given\" in a sidecar keeps the times of a table, from 0 on",
                    capture.start, family.model));
  }
  return merge_alike(found);
}

void add_capture_warnings(const models::TrajectoryFamily& source, std::span<const Capture> captures,
                          const FitOptions& options, FitResult& result) {
  const models::FamilyInfo& family = source.info();
  std::vector<std::string> known;
  for (const models::FamilyOutput& output : family.outputs) known.push_back(output.name);
  std::map<std::string, std::string> unknown;  // channel -> a capture that has it
  for (const Capture& capture : captures) {
    for (const Channel& channel : capture.channels) {
      if (std::ranges::count(known, channel.quantity) == 0) unknown.try_emplace(channel.quantity, capture.id);
    }
  }
  for (const auto& [channel, id] : unknown) {
    if (!options.compared.outputs.empty()) break;  // chosen by name
    result.warnings.add(WarningKind::captures,
                        fmt::format("capture \"{}\": \"{}\" is no output of \"{}\", and was not compared{}",
                                    id, channel, family.model, suggestion(channel, known)));
  }
  result.warnings.add_all(WarningKind::captures, moved_times(family, captures));
  result.warnings.add_all(warnings_of_early_starts(family, captures, options));
  result.warnings.add_all(WarningKind::captures, suspicions_of_all(captures, falls_in_middle(source)));
}

void add_speed_warnings(const models::TrajectoryFamily& family, std::span<const Capture> captures,
                        FitResult& result) {
  constexpr double kTooFast = 100.0;
  if (family.equations() == nullptr) return;
  std::vector<double> middle;
  for (const models::FamilyCoordinate& c : family.info().coordinates)
    middle.push_back(0.5 * (c.lower + c.upper));
  const double usual = family.equations()->scales(middle).velocity;
  for (const Capture& capture : captures) {
    double fastest = 0.0;
    for (const Channel& channel : capture.channels) {
      const bool is_position = channel.unit == "m" && (channel.quantity == "x" || channel.quantity == "y" ||
                                                       channel.quantity == "z");
      if (!is_position || channel.values.size() != capture.times.size()) continue;
      std::vector<double> speeds;
      for (Eigen::Index k = 1; k < capture.times.size(); ++k) {
        const double speed =
            std::abs(channel.values[k] - channel.values[k - 1]) / (capture.times[k] - capture.times[k - 1]);
        if (std::isfinite(speed)) speeds.push_back(speed);
      }
      if (!speeds.empty()) fastest = std::max(fastest, median(speeds));
    }
    if (!(fastest > kTooFast * usual)) continue;
    result.warnings.add(
        WarningKind::captures,
        fmt::format(
            "capture \"{}\" moves at {:.3g} m/s, {:.2g} times the characteristic speed of the model: are "
            "lengths or times in another unit, or is the body another?",
            capture.id, fastest, fastest / usual));
  }
}

void add_warnings(const FitProblem& problem, const FitPoint& point, const Uncertainty& uncertainty,
                  FitResult& result) {
  constexpr double kOpenJoin = 0.1;
  if (result.join_defect.value_or(0.0) > kOpenJoin) {
    result.warnings.add(
        WarningKind::segments,
        fmt::format(
            "segments do not join: one starts {:.2g} standard deviations of its start away from where "
            "the one before it ends; the model cannot follow the captures, or more stages are needed",
            *result.join_defect));
  }
  warn_about_bounds(result);
  warn_about_priors(problem, point, result);
  warn_about_undetermined(uncertainty, result);
  warn_about_camera(problem, result);
  warn_about_measurement(problem, result);
  warn_about_errors(uncertainty, result);
  warn_about_starts(uncertainty, result);
}

}  // namespace samara::identification
