#include "samara/codebooks/build/stepped_trajectories.h"

#include <algorithm>

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

}  // namespace samara::codebooks
