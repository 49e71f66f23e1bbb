#include "samara/models/batch/batch.h"

#include <algorithm>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// Positions among the free coordinates.
std::vector<int> positions_of(const std::vector<std::string>& names, const ParametricModel& model) {
  std::vector<int> positions;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(model.free(), name, &FreeCoordinate::name);
    if (found == model.free().end()) {
      throw ArgumentError(
          fmt::format("tangents by \"{}\" were asked for; a free coordinate was expected", name));
    }
    positions.push_back(static_cast<int>(found - model.free().begin()));
  }
  return positions;
}

/// How many tangents a pass carries, of `wanted`.
int directions_per_pass(const Model& model, int wanted) {
  const StepKernels* kernels = model.step_kernels();
  return kernels == nullptr ? wanted : std::min(wanted, kernels->pack_tangents->directions());
}

/// Fills the columns of BatchTrajectories, pack by pack.
class TimesRun {
 public:
  TimesRun(const ParametricModel& model, const Eigen::Ref<const Eigen::MatrixXd>& points,
           const BatchOptions& options, SharedProgress& progress, BatchTrajectories& result)
      : model_(model),
        points_(points),
        step_(options.step),
        directions_(positions_of(options.tangents, model)),
        progress_(progress),
        result_(result) {}

  /// Trajectories first to last - 1, with all tangents, a few directions at a time.
  void operator()(Eigen::Index first, Eigen::Index last) const {
    const auto count = static_cast<int>(directions_.size());
    int from = 0;
    do {
      const int directions = directions_per_pass(model_.model(), count - from);
      const PassKernel kernel(model_.model(), directions);
      Lanes lanes(model_, *kernel,
                  std::span(directions_)
                      .subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(directions)));
      for (Eigen::Index pack = first; pack < last; pack += lanes.width()) {
        const Eigen::Index end = std::min(last, pack + lanes.width());
        if (run_pack(lanes, pack, end, from, directions)) continue;
        // Passes go over the whole task: only in the last one are the packs before this one finished.
        return give_up(from + directions < count ? first : pack, last);
      }
      from += directions;
    } while (from < count);
  }

  /// Nothing is kept of trajectories that were not finished.
  void give_up(Eigen::Index first, Eigen::Index last) const {
    const Eigen::Index columns = (last - first) * result_.times.size();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    result_.states.middleCols(result_.column(first, 0), columns).setConstant(nan);
    for (Eigen::MatrixXd& tangents : result_.tangents) {
      tangents.middleCols(result_.column(first, 0), columns).setConstant(nan);
    }
    result_.reached.segment(first, last - first).setZero();
    for (Eigen::Index n = first; n < last; ++n) {
      result_.status[static_cast<std::size_t>(n)] = BatchStatus::cancelled;
    }
  }

 private:
  /// @returns false if it was cancelled on the way
  bool run_pack(Lanes& lanes, Eigen::Index first, Eigen::Index last, int from, int directions) const {
    Point point(points_);
    // Lanes without a trajectory of their own repeat the last one.
    for (int lane = 0; lane < lanes.width(); ++lane)
      lanes.load(lane, point(std::min(first + lane, last - 1)));
    lanes.complete();
    std::vector<double> t(static_cast<std::size_t>(lanes.width()), 0.0);
    for (Eigen::Index k = 0; k < result_.times.size(); ++k) {
      if (!progress_.goes_on()) return false;
      const EqualSteps steps = equal_steps(t[0], result_.times[k], step_);
      lanes.advance(t, steps.length, steps.count);
      std::ranges::fill(t, result_.times[k]);
      for (Eigen::Index n = first; n < last; ++n) {
        write(lanes, static_cast<int>(n - first), n, k, from, directions);
      }
    }
    return true;
  }

  void write(const Lanes& lanes, int lane, Eigen::Index n, Eigen::Index k, int from, int directions) const {
    const auto column_of = [&](Eigen::MatrixXd& matrix) {
      return std::span(matrix.col(result_.column(n, k)).data(), static_cast<std::size_t>(matrix.rows()));
    };
    BatchStatus& status = result_.status[static_cast<std::size_t>(n)];
    if (status == BatchStatus::not_finite && !(result_.times[k] <= result_.reached[n])) return;
    const std::span<double> state = column_of(result_.states);
    lanes.read(lane, state);
    if (!all_finite(state)) {
      std::ranges::fill(state, std::numeric_limits<double>::quiet_NaN());
      status = BatchStatus::not_finite;
      return;
    }
    result_.reached[n] = result_.times[k];
    for (int d = 0; d < directions; ++d) {
      lanes.read_tangent(lane, d, column_of(result_.tangents[static_cast<std::size_t>(from + d)]));
    }
  }

  const ParametricModel& model_;
  const Eigen::Ref<const Eigen::MatrixXd>& points_;
  double step_;
  std::vector<int> directions_;
  SharedProgress& progress_;
  BatchTrajectories& result_;
};

}  // namespace

BatchTrajectories integrate_batch(const ParametricModel& model,
                                  const Eigen::Ref<const Eigen::MatrixXd>& points,
                                  std::span<const double> times, const BatchOptions& options) {
  check_step(options.step);
  check_max_steps(options.max_steps);
  check_times(times);
  check_points(model, points);
  BatchTrajectories result;
  result.times = Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  result.states.setConstant(model.state_count(), points.rows() * result.times.size(),
                            std::numeric_limits<double>::quiet_NaN());
  result.tangents.assign(options.tangents.size(), result.states);
  result.status.assign(static_cast<std::size_t>(points.rows()), BatchStatus::done);
  result.reached.setZero(points.rows());
  if (are_too_many(times, options.step, options.max_steps)) {
    std::ranges::fill(result.status, BatchStatus::too_many_steps);
    return result;
  }
  SharedProgress progress = progress_of(options.progress, model.model(), points.rows());
  in_tasks(model.model(), points.rows(), options.threads, progress,
           TimesRun(model, points, options, progress, result));
  return result;
}

}  // namespace samara::models
