#include "samara/identification/solve/noise_levels.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/base/units.h"
#include "samara/identification/problem/box_bounds.h"
#include "samara/identification/problem/noise_scales.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing.h"
#include "samara/identification/solve/motion_terms.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr const char* kAttitude = "attitude";
/// Fewer values than these beyond the unknowns say nothing.
constexpr double kFewest = 3.0;
/// Residuals below this share of the scale at the start are rounding.
constexpr double kExact = 1e-9;
/// A level so many times the scatter of frames holds more than their noise.
constexpr double kMuchMore = 3.0;

/// s with sum bounded_loss(e/s) = target, which falls from the number of e that are not 0 (from infinity without a
/// loss) to 0; 0 if it begins below.
double solve_scale(LossKind loss, const std::vector<double>& errors, double target) {
  double largest = 0.0;
  for (const double e : errors) largest = std::max(largest, std::abs(e));
  if (!(largest > 0.0)) return 0.0;
  const auto sum = [&](double s) {
    double total = 0.0;
    for (const double e : errors) total += bounded_loss(loss, e / s);
    return total;
  };
  // At the upper end the sum is below target, where it is at most n (largest/s)^2.
  double upper = largest * std::sqrt(static_cast<double>(errors.size()) / target);
  double lower = 1e-12 * largest;
  if (sum(lower) <= target) return 0.0;
  constexpr double kAccuracy = 1e-6;
  while (upper > lower * (1.0 + kAccuracy)) {
    const double middle = std::sqrt(lower * upper);
    (sum(middle) > target ? lower : upper) = middle;
  }
  return std::sqrt(lower * upper);
}

}  // namespace

double& NoiseLevels::scale(FitProblem& problem, int column) {
  const auto at = static_cast<std::size_t>(column);
  return at < problem.outputs.size() ? problem.outputs[at].scale : *problem.attitude_scale;
}

NoiseLevels::NoiseLevels(const NoiseOptions& options, FitProblem& problem) : loss_(problem.loss) {
  if (!options.estimated) return;
  std::vector<std::string> compared;
  for (const ComparedOutput& output : problem.outputs) compared.push_back(output.name);
  if (problem.attitude_scale) compared.emplace_back(kAttitude);
  for (const auto& [name, level] : options.levels) {
    if (std::ranges::count(compared, name) > 0) continue;
    throw ArgumentError(
        fmt::format("noise: \"{}\" is not among what is compared ({})", name, join(compared)));
  }
  std::map<std::string, std::size_t> places;
  for (std::size_t column = 0; column < compared.size(); ++column) {
    if (!noise_is_estimated(options, compared[column])) continue;
    const std::string unit = column < problem.outputs.size() ? problem.outputs[column].unit : "rad";
    const std::string name = options.levels.empty() ? compared[column] : options.levels.at(compared[column]);
    const auto [place, is_new] = places.try_emplace(name, levels_.size());
    if (is_new) levels_.emplace_back();
    Level& level = levels_[place->second];
    if (is_new) level.result.unit = unit;
    if (!same_dimension(level.result.unit, unit)) {
      throw ArgumentError(
          fmt::format("noise: \"{}\" [{}] and \"{}\" [{}] share the level \"{}\"; outputs of one "
                      "unit were expected",
                      level.result.outputs.front(), level.result.unit, compared[column], unit, name));
    }
    level.columns.push_back(static_cast<int>(column));
    level.result.outputs.push_back(compared[column]);
    level.is_scatter =
        level.is_scatter && column < problem.outputs.size() && problem.outputs[column].scale_is_scatter;
  }
  for (Level& level : levels_) {
    double sum = 0.0;
    for (const int column : level.columns) sum += std::log(scale(problem, column));
    level.start = std::exp(sum / static_cast<double>(level.columns.size()));
    level.result.value = level.start / efficient_bend(loss_);
    for (const int column : level.columns) scale(problem, column) = level.start;
  }
}

std::vector<NoiseLevels::Column> NoiseLevels::columns(const FitProblem& problem,
                                                      std::vector<SegmentResidual>& residuals,
                                                      const FitPoint& point) const {
  evaluate_all(residuals, point);
  const double slope = mean_slope(problem, residuals);
  std::vector<MotionTerms> terms;
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(problem.shared_count(), problem.shared_count());
  for (const Motion& motion : problem.motions) {
    terms.push_back(
        motion_terms(problem, motion, residuals, point, slope, free_directions(problem, motion, point)));
    normal += terms.back().normal;
  }
  normal += prior_terms(problem, point).information / std::max(slope, kLeastSlope);
  const std::vector<int> free = free_indices(at_bounds(problem.shared, problem.shared_chart, point.shared));
  const Eigen::MatrixXd inverse =
      invert_determined(normal(free, free), Eigen::VectorXd::Zero(static_cast<Eigen::Index>(free.size())))
          .inverse;

  std::vector<Column> result(problem.outputs.size() + (problem.attitude_scale ? 1 : 0));
  for (std::size_t c = 0; c < terms.size(); ++c) {
    const Motion& motion = problem.motions[c];
    const MotionEquations equations = motion_equations(problem, motion, residuals, point);
    const Eigen::MatrixXd by_own = equations.by_own(Eigen::all, terms[c].own_free);
    const Eigen::MatrixXd rest = (equations.by_shared - by_own * terms[c].projection)(Eigen::all, free);
    const Eigen::VectorXd leverage =
        (by_own * terms[c].own_inverse.inverse).cwiseProduct(by_own).rowwise().sum() +
        (rest * inverse).cwiseProduct(rest).rowwise().sum();
    Eigen::Index first = 0;
    for (std::size_t k = motion.first_segment; k < motion.first_segment + motion.segment_count; ++k) {
      const std::vector<Observation>& observations = problem.segments[k].observations;
      for (Eigen::Index row = 0; row < residuals[k].data_size(); ++row) {
        const auto at = static_cast<std::size_t>(row);
        const bool is_output = at < observations.size();
        const std::size_t column =
            is_output ? static_cast<std::size_t>(observations[at].output) : problem.outputs.size();
        const double unit = is_output ? problem.outputs[column].scale : *problem.attitude_scale;
        result[column].errors.push_back(residuals[k].residual()[row] * unit);
        result[column].leverage += leverage[first + row];
      }
      first += residuals[k].size();
    }
  }
  return result;
}

double NoiseLevels::update(FitProblem& problem, std::vector<SegmentResidual>& residuals,
                           const FitPoint& point) {
  const std::vector<Column> all = columns(problem, residuals, point);
  const double bend = efficient_bend(loss_);
  double change = 0.0;
  for (Level& level : levels_) {
    Column pooled;
    for (const int column : level.columns) {
      const Column& one = all[static_cast<std::size_t>(column)];
      pooled.errors.insert(pooled.errors.end(), one.errors.begin(), one.errors.end());
      pooled.leverage += one.leverage;
    }
    level.count = static_cast<double>(pooled.errors.size());
    level.result.degrees_of_freedom = level.count - pooled.leverage;
    if (level.state != State::estimated) continue;
    double found = 0.0;
    if (level.result.degrees_of_freedom < kFewest) {
      level.state = State::too_few;
    } else {
      found =
          solve_scale(loss_, pooled.errors, level.result.degrees_of_freedom * expected_bounded_loss(loss_));
      if (found <= kExact * level.start) level.state = State::exact;
    }
    level.result.estimated = level.state == State::estimated;
    const double next = level.result.estimated ? found : level.start;
    change = std::max(change, std::abs(next / (bend * level.result.value) - 1.0));
    level.result.value = next / bend;
    for (const int column : level.columns) scale(problem, column) = next;
  }
  return change;
}

void NoiseLevels::report(const FitProblem& problem, FitResult& result) const {
  for (const Level& level : levels_) {
    result.noise.push_back(level.result);
    const NoiseLevel& found = level.result;
    const std::string names = join(found.outputs);
    const std::string kept =
        fmt::format("its loss scale stays at {:.3g}{}", level.start, unit_suffix(found.unit));
    if (level.state == State::exact) {
      result.warnings.add(
          WarningKind::noise,
          fmt::format("the model meets {} exactly: its noise cannot be estimated, and {}", names, kept));
    } else if (level.state == State::too_few) {
      result.warnings.add(
          WarningKind::noise,
          fmt::format("{} has {} values for the {:.3g} unknowns that they determine: its noise cannot be "
                      "estimated, and {}",
                      names, level.count, level.count - found.degrees_of_freedom, kept));
    } else if (level.is_scatter && problem.averaged_frames == 1 &&
               found.value * efficient_bend(loss_) > kMuchMore * level.start) {
      result.warnings.add(WarningKind::noise,
                          fmt::format("the noise level of {}, {:.3g}{}, is {:.2g} times the scatter of its "
                                      "frames about a smooth curve: most of it is what the model misses",
                                      names, found.value, unit_suffix(found.unit),
                                      found.value * efficient_bend(loss_) / level.start));
    }
  }
}

}  // namespace samara::identification
