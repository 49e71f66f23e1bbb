#include "samara/models/trajectories/averaged_source.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::models {

namespace {

/// Times that differ by less than this share of an interval are one.
constexpr double kSameTime = 1e-6;
/// The share of an interval by which frames may lie after the end of a family.
constexpr double kRounding = 1e-3;

/// A time that rounding has put just before the start, or just after the end of the family, on it.
double within(double end, double interval, double time) {
  if (time > end && time <= end + kRounding * interval) return end;
  return std::max(0.0, time);
}

/// Rows of a family that are averaged for one frame.
using Rows = std::vector<Eigen::Index>;

class AveragedSource final : public TrajectorySource {
 public:
  AveragedSource(std::unique_ptr<TrajectorySource> all, Eigen::Index times, Eigen::Index outputs,
                 Eigen::Index coordinates, std::vector<Rows> rows)
      : all_(std::move(all)),
        rows_(std::move(rows)),
        values_(Eigen::MatrixXd::Zero(times, outputs)),
        derivatives_(Eigen::MatrixXd::Zero(times, outputs * coordinates)) {}

  /// A frame is valid only with all its rows: of a trajectory that ended before the last one, none is kept.
  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    TrajectoryOutcome outcome = all_->evaluate(q, values_, derivatives ? &derivatives_ : nullptr);
    if (!outcome) {
      outcome.reached = -1.0;
      return outcome;
    }
    average(values_, values);
    if (derivatives) average(derivatives_, *derivatives);
    return outcome;
  }

 private:
  void average(const Eigen::MatrixXd& from, Eigen::MatrixXd& to) const {
    for (std::size_t frame = 0; frame < rows_.size(); ++frame) {
      auto row = to.row(static_cast<Eigen::Index>(frame));
      row.setZero();
      for (const Eigen::Index k : rows_[frame]) row += from.row(k);
      row /= static_cast<double>(rows_[frame].size());
    }
  }

  std::unique_ptr<TrajectorySource> all_;
  std::vector<Rows> rows_;
  Eigen::MatrixXd values_, derivatives_;
};

}  // namespace

void check_frame_mean(const FrameMean& mean) {
  if (mean.frames < 1 || mean.frames % 2 == 0) {
    throw ArgumentError(fmt::format("a frame is the mean of {}; an odd number was expected", mean.frames));
  }
  if (mean.frames > 1) require_positive(mean.interval, "the time between frames");
}

std::unique_ptr<TrajectorySource> averaged_source(const TrajectoryFamily& family, const FrameMean& mean,
                                                  const std::vector<double>& times,
                                                  const std::vector<std::string>& outputs,
                                                  const std::vector<int>& wanted) {
  check_frame_mean(mean);
  if (mean.frames == 1 || times.empty()) return family.at(times, outputs, wanted);
  const int half = mean.frames / 2;
  const std::size_t frames = times.size() - (mean.last_is_state ? 1 : 0);
  std::vector<double> instants;
  for (std::size_t k = 0; k < frames; ++k) {
    for (int j = -half; j <= half; ++j) {
      instants.push_back(within(family.info().end_time, mean.interval, times[k] + j * mean.interval));
    }
  }
  if (mean.last_is_state) instants.push_back(times.back());
  std::vector<double> distinct = instants;
  std::ranges::sort(distinct);
  const double margin = kSameTime * mean.interval;
  const auto same = [&](double a, double b) { return b - a < margin; };
  distinct.erase(std::unique(distinct.begin(), distinct.end(), same), distinct.end());

  const auto row_of = [&](double time) {
    const auto nearest =
        std::ranges::min_element(distinct, {}, [&](double other) { return std::abs(other - time); });
    return static_cast<Eigen::Index>(nearest - distinct.begin());
  };
  std::vector<Rows> rows(times.size());
  for (std::size_t k = 0; k < instants.size(); ++k) {
    rows[k / static_cast<std::size_t>(mean.frames)].push_back(row_of(instants[k]));
  }
  return std::make_unique<AveragedSource>(
      family.at(distinct, outputs, wanted), static_cast<Eigen::Index>(distinct.size()),
      static_cast<Eigen::Index>(outputs.size()), static_cast<Eigen::Index>(family.info().coordinates.size()),
      std::move(rows));
}

}  // namespace samara::models
