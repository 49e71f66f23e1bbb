#include "samara/identification/forecasts/recent_motion.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include <Eigen/QR>
#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

constexpr double kUnseen = std::numeric_limits<double>::quiet_NaN();
constexpr int kCubicFrames = 9;  ///< through which rates are taken
constexpr std::size_t kFewestFrames = 4;

/// Those that show every component.
std::vector<Eigen::Index> complete_frames(const SeenMotion& seen) {
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < seen.times.size(); ++k) {
    if (seen.positions.row(k).allFinite()) frames.push_back(k);
  }
  return frames;
}

}  // namespace

std::vector<int> others_of(const Components& components, Eigen::Index count) {
  std::vector<int> others;
  for (int c = 0; c < count; ++c) {
    if (std::ranges::count(components.level, c) == 0) others.push_back(c);
  }
  return others;
}

Eigen::MatrixXd recent_rates(const SeenMotion& seen) {
  const std::vector<Eigen::Index> frames = complete_frames(seen);
  if (frames.size() < kFewestFrames) return Eigen::MatrixXd::Constant(3, seen.positions.cols(), kUnseen);
  const Eigen::VectorXd times = seen.times(frames);
  const Eigen::Index count = std::min<Eigen::Index>(kCubicFrames, times.size());
  Eigen::MatrixXd powers(count, 4);
  powers.col(0).setOnes();
  const Eigen::ArrayXd since = (times.tail(count).array() - times[times.size() - 1]) / median_interval(times);
  for (Eigen::Index k = 1; k < 4; ++k) powers.col(k) = powers.col(k - 1).array() * since;
  const Eigen::MatrixXd positions = seen.positions(frames, Eigen::all);
  return powers.colPivHouseholderQr().solve(positions.bottomRows(count)).bottomRows(3);
}

std::optional<RecentMotion> recent_motion(const SeenMotion& seen) {
  const std::vector<Eigen::Index> frames = complete_frames(seen);
  if (frames.size() < kFewestFrames) return {};
  const Eigen::VectorXd times = seen.times(frames);
  RecentMotion recent{.last = seen.positions.row(frames.back()), .rates = recent_rates(seen)};
  recent.places = places_back(
      seen, Eigen::VectorXd::LinSpaced(RecentMotion::kPlaces - 1, 1.0, RecentMotion::kPlaces - 1.0));
  recent.seen_for = (times[times.size() - 1] - times[0]) / median_interval(times);
  return recent;
}

double way_back(const std::vector<double>& seen_for) {
  constexpr double kFarthest = 24.0;
  return std::min(median(seen_for), kFarthest);
}

Eigen::MatrixXd places_back(const SeenMotion& seen, const Eigen::VectorXd& intervals) {
  const std::vector<Eigen::Index> frames = complete_frames(seen);
  Eigen::MatrixXd places = Eigen::MatrixXd::Constant(intervals.size(), seen.positions.cols(), kUnseen);
  if (frames.size() < 2) return places;
  const Eigen::VectorXd times = seen.times(frames);
  const Eigen::MatrixXd positions = seen.positions(frames, Eigen::all);
  const double interval = median_interval(times);
  const Eigen::Index newest = times.size() - 1;
  for (Eigen::Index k = 0; k < intervals.size(); ++k) {
    const double at = times[newest] - intervals[k] * interval;
    Eigen::Index after = newest;
    while (after > 1 && times[after - 1] >= at) --after;
    const double part = (at - times[after - 1]) / (times[after] - times[after - 1]);
    places.row(k) = positions.row(after - 1) + part * (positions.row(after) - positions.row(after - 1)) -
                    positions.row(newest);
  }
  return places;
}

Eigen::MatrixXcd views_back(const SeenMotion& seen, const Eigen::VectorXd& intervals) {
  if (seen.views.cols() > 0 && seen.views.rows() != seen.times.size()) {
    throw ArgumentError(fmt::format("a motion of {} times has {} frames of views; as many were expected",
                                    seen.times.size(), seen.views.rows()));
  }
  Eigen::MatrixXcd views = Eigen::MatrixXcd::Constant(intervals.size(), seen.views.cols(), kUnseen);
  const std::vector<Eigen::Index> placed = complete_frames(seen);
  std::vector<Eigen::Index> frames;
  for (Eigen::Index k = 0; k < seen.views.rows(); ++k) {
    if (seen.views.row(k).allFinite()) frames.push_back(k);
  }
  if (placed.size() < 2 || frames.empty()) return views;
  const double interval = median_interval(seen.times(placed));
  for (Eigen::Index k = 0; k < intervals.size(); ++k) {
    const double at = seen.times[placed.back()] - intervals[k] * interval;
    const auto after =
        std::ranges::lower_bound(frames, at, {}, [&](Eigen::Index f) { return seen.times[f]; });
    const Eigen::Index right = after == frames.end() ? frames.back() : *after,
                       left = after == frames.begin() ? right : *std::prev(after);
    const double apart = seen.times[right] - seen.times[left];
    const double part = apart > 0.0 ? std::min((at - seen.times[left]) / apart, 1.0) : 0.0;
    views.row(k) = (1.0 - part) * seen.views.row(left) + part * seen.views.row(right);
  }
  return views;
}

LevelFrame::LevelFrame(const Components& components, const Eigen::RowVectorXd& velocity)
    : level_(components.level), others_(others_of(components, velocity.size())) {
  if (level_.size() != 2) return;
  const Eigen::RowVector2d level = velocity(level_);
  if (level.norm() > 0.0) along_ = level.normalized();
}

Mirrored LevelFrame::split(const Eigen::MatrixXd& displacements) const {
  const auto others = std::ssize(others_), in_frame = level_.size() == 2 ? std::ssize(others_) + 1 : others;
  const Eigen::Index odd = level_.empty() ? 0 : 1;
  Mirrored numbers{Eigen::VectorXd(displacements.rows() * in_frame),
                   Eigen::VectorXd(displacements.rows() * odd)};
  for (Eigen::Index row = 0; row < displacements.rows(); ++row) {
    const Eigen::RowVectorXd one = displacements.row(row);
    numbers.even.segment(row * in_frame, others) = one(others_).transpose();
    if (level_.size() == 1) numbers.odd[row] = one[level_[0]];
    if (level_.size() != 2) continue;
    const Eigen::RowVector2d level = one(level_);
    numbers.even[row * in_frame + others] = along_.dot(level);
    numbers.odd[row] = along_[0] * level[1] - along_[1] * level[0];
  }
  return numbers;
}

Eigen::RowVectorXd LevelFrame::joined(const Mirrored& numbers) const {
  Eigen::RowVectorXd displacement(std::ssize(others_) + std::ssize(level_));
  for (std::size_t k = 0; k < others_.size(); ++k)
    displacement[others_[k]] = numbers.even[static_cast<Eigen::Index>(k)];
  if (level_.size() == 1) displacement[level_[0]] = numbers.odd[0];
  if (level_.size() != 2) return displacement;
  const double along = numbers.even[std::ssize(others_)], across = numbers.odd[0];
  displacement[level_[0]] = along_[0] * along - along_[1] * across;
  displacement[level_[1]] = along_[1] * along + along_[0] * across;
  return displacement;
}

}  // namespace samara::identification
