#include "samara/identification/averaged_source.h"

#include <algorithm>
#include <cmath>

namespace samara::identification {

namespace {

/// Times that differ by less than this share of an interval are one.
constexpr double kSameTime = 1e-6;

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

  bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) override {
    if (!all_->evaluate(q, values_, derivatives ? &derivatives_ : nullptr)) return false;
    average(values_, values);
    if (derivatives) average(derivatives_, *derivatives);
    return true;
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

std::unique_ptr<TrajectorySource> averaged_source(const TrajectoryFamily& family, const FitProblem& problem,
                                                  const Segment& segment, const std::vector<int>& wanted) {
  if (problem.averaged_frames == 1) return family.at(segment.times, problem.requested, wanted);
  const int half = problem.averaged_frames / 2;
  const std::size_t frames = segment.times.size() - (segment.joined ? 1 : 0);
  std::vector<double> times;
  for (std::size_t k = 0; k < frames; ++k) {
    for (int j = -half; j <= half; ++j) {
      // The start may come out a rounding before 0.
      times.push_back(std::max(0.0, segment.times[k] + j * segment.interval));
    }
  }
  if (segment.joined) times.push_back(segment.times.back());
  std::vector<double> distinct = times;
  std::ranges::sort(distinct);
  const double margin = kSameTime * segment.interval;
  const auto same = [&](double a, double b) { return b - a < margin; };
  distinct.erase(std::unique(distinct.begin(), distinct.end(), same), distinct.end());

  const auto row_of = [&](double time) {
    const auto nearest =
        std::ranges::min_element(distinct, {}, [&](double other) { return std::abs(other - time); });
    return static_cast<Eigen::Index>(nearest - distinct.begin());
  };
  std::vector<Rows> rows(segment.times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    rows[k / static_cast<std::size_t>(problem.averaged_frames)].push_back(row_of(times[k]));
  }
  return std::make_unique<AveragedSource>(family.at(distinct, problem.requested, wanted),
                                          static_cast<Eigen::Index>(distinct.size()),
                                          static_cast<Eigen::Index>(problem.requested.size()),
                                          static_cast<Eigen::Index>(problem.slots.size()), std::move(rows));
}

}  // namespace samara::identification
