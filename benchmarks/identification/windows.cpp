#include "windows.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iostream>
#include <limits>

#include <fmt/format.h>

#include "real_data.h"
#include "samara/identification/fit.h"
#include "samara/identification/fitted_motion.h"
#include "samara/pgd/random.h"

namespace samara::benchmarks::identification {

using samara::identification::Baseline;
using samara::identification::Capture;
using samara::identification::FitOptions;
using samara::identification::FitResult;

std::vector<Window> cut(const Capture& motion, int frames, int ahead) {
  const Eigen::MatrixX3d positions = positions_of(motion);
  std::vector<Window> windows;
  for (int first = 0; first + frames + ahead <= motion.frame_count(); first += frames) {
    const int next = first + frames - 1 + ahead;
    Window window;
    window.next_time = motion.times[next] - motion.times[first];
    window.next = positions.row(next);
    window.capture = frames_of(motion, first, frames, motion.times[first]);
    window.capture.id = fmt::format("{} from {}", motion.id, first);
    if (positions.middleRows(first, frames + ahead).allFinite()) windows.push_back(std::move(window));
  }
  return windows;
}

std::vector<Capture> captures_of(std::span<const Window> windows) {
  std::vector<Capture> captures;
  for (const Window& window : windows) captures.push_back(window.capture);
  return captures;
}

FitOptions with_coefficients(FitOptions options, const FitResult& result) {
  for (const auto& coefficient : result.coefficients) options.fixed[coefficient.name] = coefficient.value;
  options.shared.clear();
  options.log_scale.clear();
  options.priors.clear();
  options.initial.clear();
  return options;
}

std::vector<double> model_errors(const samara::identification::TrajectoryFamily& family,
                                 const FitOptions& options, const FitResult& result,
                                 std::span<const Window> windows) {
  std::vector<double> errors;
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const auto predicted = samara::identification::fitted_motion(family, options, result, k,
                                                                 {windows[k].next_time}, {"x", "y", "z"});
    errors.push_back(predicted ? (predicted->row(0) - windows[k].next).norm()
                               : std::numeric_limits<double>::infinity());
  }
  return errors;
}

std::vector<double> baseline_errors(Baseline baseline, std::span<const Window> windows) {
  std::vector<double> errors;
  for (const Window& window : windows) {
    const Eigen::VectorXd time = Eigen::VectorXd::Constant(1, window.next_time);
    const Eigen::MatrixXd predicted = samara::identification::predict(
        baseline, {.times = window.capture.times, .positions = positions_of(window.capture)}, time);
    errors.push_back((predicted.row(0) - window.next).norm());
  }
  return errors;
}

std::vector<double> window_misfits(const FitResult& result) {
  std::vector<double> misfits;
  for (const auto& capture : result.captures) {
    misfits.push_back(
        std::sqrt((capture.measured - capture.model).leftCols<3>().rowwise().squaredNorm().mean()));
  }
  return misfits;
}

std::map<std::string, double> bootstrap_errors(const samara::identification::TrajectoryFamily& family,
                                               FitOptions options, const FitResult& fitted,
                                               std::span<const Window> windows, const std::string& label,
                                               int repeats) {
  options.rounds = 1;
  for (const auto& c : fitted.coefficients) options.initial[c.name] = c.value;
  std::map<std::string, std::vector<const Capture*>> drops;
  for (const Window& window : windows) drops[window.capture.labels.at(label)].push_back(&window.capture);
  std::map<std::string, std::vector<double>> logs;
  pgd::Random random(1);
  for (int repeat = 0; repeat < repeats; ++repeat) {
    std::vector<Capture> drawn;
    for (std::size_t k = 0; k < drops.size(); ++k) {
      const auto which = static_cast<std::ptrdiff_t>(random.uniform() * static_cast<double>(drops.size()));
      for (const Capture* capture : std::next(drops.begin(), which)->second) {
        drawn.push_back(*capture);
        drawn.back().id += fmt::format(", {}", k);
      }
    }
    for (const auto& c : samara::identification::fit(family, drawn, options).coefficients) {
      logs[c.name].push_back(std::log(c.value));
    }
  }
  std::map<std::string, double> errors;
  for (const auto& [name, values] : logs) {
    const auto count = static_cast<Eigen::Index>(values.size());
    const Eigen::Map<const Eigen::ArrayXd> all(values.data(), count);
    errors[name] = std::sqrt((all - all.mean()).square().sum() / static_cast<double>(count - 1));
  }
  return errors;
}

}  // namespace samara::benchmarks::identification
