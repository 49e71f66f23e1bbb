#include "windows.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <fmt/format.h>

#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"

namespace samara::benchmarks::identification {

using samara::identification::Baseline;
using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::identification::FitResult;

std::vector<Window> cut(const Capture& motion, int frames, int ahead, int stride) {
  const Eigen::MatrixX3d positions = positions_of(motion);
  std::vector<Window> windows;
  for (int first = 0; first + frames + ahead <= motion.frame_count(); first += stride > 0 ? stride : frames) {
    const int next = first + frames - 1 + ahead;
    Window window;
    window.next_time = motion.times[next] - motion.times[first];
    window.next = positions.row(next);
    window.first = first;
    window.capture = frames_of(motion, first, frames, motion.times[first]);
    window.capture.id = fmt::format("{} from {}", motion.id, first);
    if (positions.middleRows(first, frames + ahead).allFinite()) windows.push_back(std::move(window));
  }
  return windows;
}

std::vector<Window> cut_as_known(const Capture& motion, int frames, int ahead, int stride) {
  std::vector<Window> windows;
  for (Window& window : cut(motion, frames, ahead, stride)) {
    const double end = motion.times[window.first + frames - 1] - motion.times[0];
    const Capture known = samara::identification::known_at(motion, end);
    if (known.frame_count() < frames) continue;
    const Eigen::Index first = known.frame_count() - frames;
    const std::string id = window.capture.id;
    window.capture = frames_of(known, first, frames, known.times[first]);
    window.capture.id = id;
    if (positions_of(window.capture).allFinite()) windows.push_back(std::move(window));
  }
  return windows;
}

std::vector<Capture> captures_of(std::span<const Window> windows) {
  std::vector<Capture> captures;
  for (const Window& window : windows) captures.push_back(window.capture);
  return captures;
}

FitOptions with_coefficients(FitOptions options, const Coefficients& coefficients) {
  for (const auto& [name, value] : coefficients) options.unknowns.fixed[name] = value;
  options.unknowns.shared.clear();
  options.unknowns.log_scale.clear();
  options.priors.coordinates.clear();
  options.starts.initial.clear();
  options.uncertainty.bootstrap.replicates = 0;
  options.starts.rounds = 1;
  options.solver.max_iterations = 15;  // they stand alone, and have found their states already
  return options;
}

Prediction predict_unseen(const samara::models::TrajectoryFamily& family, const FitOptions& options,
                          const Coefficients& coefficients, std::span<const Window> unseen) {
  const FitOptions held = with_coefficients(options, coefficients);
  Prediction result{.fit = samara::identification::fit(family, captures_of(unseen), held)};
  if (result.fit.captures.empty()) throw std::runtime_error(result.fit.message);
  result.next = model_next(family, held, result.fit, unseen);
  result.errors = errors_of(result.next, unseen);
  return result;
}

Eigen::MatrixX3d model_next(const samara::models::TrajectoryFamily& family, const FitOptions& options,
                            const FitResult& result, std::span<const Window> windows) {
  Eigen::MatrixX3d next(std::ssize(windows), 3);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const auto predicted = samara::identification::fitted_motion(family, options, result, k,
                                                                 {windows[k].next_time}, {"x", "y", "z"});
    const auto row = static_cast<Eigen::Index>(k);
    next.row(row).setConstant(std::numeric_limits<double>::infinity());
    if (predicted) next.row(row) = predicted->row(0);
  }
  return next;
}

Eigen::MatrixX3d baseline_next(Baseline baseline, std::span<const Window> windows) {
  Eigen::MatrixX3d next(std::ssize(windows), 3);
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const Capture& seen = windows[k].capture;
    next.row(static_cast<Eigen::Index>(k)) =
        samara::identification::predict(baseline, {.times = seen.times, .positions = positions_of(seen)},
                                        Eigen::VectorXd::Constant(1, windows[k].next_time));
  }
  return next;
}

std::vector<double> errors_of(const Eigen::MatrixX3d& next, std::span<const Window> windows) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    errors.push_back((next.row(static_cast<Eigen::Index>(k)) - windows[k].next).norm());
  }
  return errors;
}

std::vector<double> baseline_errors(Baseline baseline, std::span<const Window> windows) {
  return errors_of(baseline_next(baseline, windows), windows);
}

BestBaseline best_baseline(std::span<const Window> windows) {
  BestBaseline best{.median = std::numeric_limits<double>::infinity()};
  for (const Baseline baseline : samara::identification::all_baselines()) {
    if (baseline == Baseline::measured_velocity || baseline == Baseline::point_with_drag) continue;
    const double median = median_of(baseline_errors(baseline, windows));
    if (median < best.median) best = {to_string(baseline), median};
  }
  return best;
}

std::vector<double> window_misfits(const FitResult& result) {
  std::vector<double> misfits;
  for (const auto& capture : result.captures) {
    misfits.push_back(
        std::sqrt((capture.measured - capture.model).leftCols<3>().rowwise().squaredNorm().mean()));
  }
  return misfits;
}

void say_coefficients(const FitResult& result) {
  for (std::size_t k = 0; k < result.coefficients.size(); ++k) {
    const auto& c = result.coefficients[k];
    fmt::print(stderr, "  {} {:.3g} +- {:.2g}", c.name, c.value, error_of(result, c.name));
    if (result.bootstrap) fmt::print(stderr, ", bootstrap {:.2g}", result.bootstrap->standard_errors[k]);
    fmt::print(stderr, ": {}\n", verdict(result, c));
  }
  if (result.bootstrap) {
    fmt::print(stderr, "  {} of {} fits of the bootstrap converged\n", result.bootstrap->converged,
               result.bootstrap->replicates);
  }
}

}  // namespace samara::benchmarks::identification
