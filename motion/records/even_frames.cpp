#include "samara/motion/records/even_frames.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::motion {

namespace {

/// Where a frame of the bridged record lies: after a frame of the old one, by a share of the way to the next.
struct BetweenFrames {
  Eigen::Index before = 0;
  double share = 0.0;
};

double median_interval(const Eigen::VectorXd& times) {
  std::vector<double> intervals;
  for (Eigen::Index k = 1; k < times.size(); ++k) intervals.push_back(times[k] - times[k - 1]);
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(intervals.size() / 2);
  std::ranges::nth_element(intervals, middle);
  return *middle;
}

std::vector<BetweenFrames> frames_of(const Eigen::VectorXd& times, double interval) {
  std::vector<BetweenFrames> frames;
  for (Eigen::Index k = 0; k < times.size(); ++k) {
    frames.push_back({k, 0.0});
    if (k + 1 == times.size()) break;
    const double steps = (times[k + 1] - times[k]) / interval;
    if (steps < 1.5) continue;
    if (steps > static_cast<double>(kLongestGap) + 1.5) {
      throw ArgumentError(fmt::format(
          "the record has no frames from {:.6g} to {:.6g} s, {:.0f} at its rate, expected at most {}: "
          "its parts may be records of their own",
          times[k], times[k + 1], steps - 1.0, kLongestGap));
    }
    const auto pieces = std::lround(steps);
    for (long piece = 1; piece < pieces; ++piece)
      frames.push_back({k, static_cast<double>(piece) / static_cast<double>(pieces)});
  }
  return frames;
}

Eigen::MatrixXd between(const Eigen::MatrixXd& values, const std::vector<BetweenFrames>& frames) {
  Eigen::MatrixXd all(static_cast<Eigen::Index>(frames.size()), values.cols());
  for (std::size_t n = 0; n < frames.size(); ++n) {
    const auto& [k, share] = frames[n];
    all.row(static_cast<Eigen::Index>(n)) = values.row(k);
    if (share > 0.0) all.row(static_cast<Eigen::Index>(n)) += share * (values.row(k + 1) - values.row(k));
  }
  return all;
}

}  // namespace

std::optional<MotionRecord> bridged(const MotionRecord& record) {
  const std::vector<BetweenFrames> frames = frames_of(record.times, median_interval(record.times));
  if (static_cast<Eigen::Index>(frames.size()) == record.frame_count()) return {};
  MotionRecord all = record;
  all.times = between(record.times, frames);
  all.positions = between(record.positions, frames);
  if (record.angles.size() > 0) all.angles = between(record.angles, frames);
  if (record.normals.rows() > 0) all.normals = between(record.normals, frames).rowwise().normalized();
  return all;
}

}  // namespace samara::motion
