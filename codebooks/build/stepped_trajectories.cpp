#include "samara/codebooks/build/stepped_trajectories.h"

#include <algorithm>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "samara/models/batch/batch.h"

namespace samara::codebooks {

SteppedTrajectories::SteppedTrajectories(const models::ParametricModel& model, double step, int threads,
                                         long max_calls, const ProgressCallback& progress)
    : model_(model), step_(step), threads_(threads), max_calls_(max_calls), progress_(progress) {}

void SteppedTrajectories::tell(std::string stage, double fraction) {
  stage_ = {std::move(stage), fraction};
}

Eigen::MatrixXd SteppedTrajectories::operator()(const Eigen::MatrixXd& points,
                                                const std::vector<double>& times) {
  if (calls_ + points.cols() > max_calls_) {
    throw SteppedEnd({Termination::max_calls,
                      fmt::format("{} trajectories of the {} allowed were used, {} more were needed", calls_,
                                  max_calls_, points.cols())});
  }
  if (progress_ && !progress_(stage_)) throw SteppedEnd({Termination::cancelled, "cancelled"});
  calls_ += points.cols();
  models::BatchTrajectories batch =
      models::integrate_batch(model_, points.transpose(), times, {.step = step_, .threads = threads_});
  const auto bad = std::ranges::find_if(
      batch.status, [](models::BatchStatus status) { return status != models::BatchStatus::done; });
  if (bad != batch.status.end()) {
    const Eigen::VectorXd point = points.col(bad - batch.status.begin());
    std::string at;
    for (std::size_t k = 0; k < model_.free().size(); ++k)
      at += fmt::format("{}{} = {:.9g}", k == 0 ? "" : ", ", model_.free()[k].name,
                        point[static_cast<Eigen::Index>(k)]);
    throw SteppedEnd({Termination::not_finite,
                      fmt::format("a trajectory by steps of {:.3g} is not finite at {}", step_, at),
                      {point.begin(), point.end()}});
  }
  Eigen::MatrixXd values = std::move(batch.states);
  values.resize(values.rows() * static_cast<Eigen::Index>(times.size()), points.cols());
  return values;
}

namespace {

/// Over the ranges of the states.
double largest_difference(const Eigen::MatrixXd& fine, const Eigen::MatrixXd& coarse,
                          const pgd::OutputMeasure& measure) {
  const Eigen::Index states = measure.floors.size();
  const auto by_state = fine.reshaped(states, fine.size() / states);
  const Eigen::VectorXd difference =
      (by_state - coarse.reshaped(states, coarse.size() / states)).cwiseAbs().rowwise().maxCoeff();
  const Eigen::VectorXd scales =
      pgd::error_scales(by_state.rowwise().minCoeff(), by_state.rowwise().maxCoeff(), measure);
  return difference.cwiseQuotient(scales).maxCoeff();
}

/// Nothing where a trajectory is not finite: shorter steps may make it so.
std::optional<Eigen::MatrixXd> finite_values(SteppedTrajectories& trajectories, const Eigen::MatrixXd& pilots,
                                             const std::vector<double>& times) {
  try {
    return trajectories(pilots, times);
  } catch (const SteppedEnd& end) {
    if (end.ending.status != Termination::not_finite) throw;
    return {};
  }
}

}  // namespace

/// The finer of two steps is kept. What it errs by follows from how fast differences fall: in the fourth order where f
/// is smooth, slower at kinks.
void choose_step(SteppedTrajectories& trajectories, const Eigen::MatrixXd& pilots, double end,
                 const pgd::OutputMeasure& measure, double tolerance) {
  constexpr int kMostHalvings = 8;
  constexpr double kFourthOrder = 16.0;
  std::vector<double> times;
  for (int i = 0; i <= kFirstSteps; ++i) times.push_back(end * i / kFirstSteps);
  std::optional<Eigen::MatrixXd> coarse = finite_values(trajectories, pilots, times);
  double before = 0.0;
  for (int halvings = 1;; ++halvings) {
    const bool is_last = halvings == kMostHalvings;
    trajectories.set_step(0.5 * trajectories.step());
    std::optional<Eigen::MatrixXd> fine =
        is_last ? trajectories(pilots, times) : finite_values(trajectories, pilots, times);
    double error = std::numeric_limits<double>::infinity(), difference = 0.0;
    if (fine && coarse) {
      difference = largest_difference(*fine, *coarse, measure);
      const double falls = std::min(before / difference, kFourthOrder);
      error = falls > 2.0 ? difference / (falls - 1.0) : difference;
    }
    if (error <= tolerance) return;
    if (is_last) {
      throw SteppedEnd(
          {Termination::not_resolved,
           fmt::format("Runge-Kutta steps of {:.3g} s still err by {:.3g}", trajectories.step(), error)});
    }
    coarse = std::move(fine);
    before = difference;
  }
}

}  // namespace samara::codebooks
