#include "samara/identification/captures/impact.h"

#include <algorithm>
#include <limits>
#include <span>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

using Eigen::Index;

constexpr Index kSide = 4;  ///< frames on each side of an impact

/// Frames in which all positions are seen.
struct Path {
  std::vector<Index> frame;
  Eigen::VectorXd times;
  Eigen::MatrixXd positions;  ///< frames x quantities
  Eigen::RowVectorXd gravity;

  Index count() const { return times.size(); }
};

Path seen_path(const Capture& capture, const ImpactOptions& options) {
  const auto quantities = static_cast<Index>(options.quantities.size());
  Eigen::MatrixXd all(capture.times.size(), quantities);
  Path path;
  path.gravity = Eigen::RowVectorXd::Zero(quantities);
  for (Index k = 0; k < quantities; ++k) {
    const std::string& quantity = options.quantities[static_cast<std::size_t>(k)];
    all.col(k) = capture.channel(quantity).values;
    const auto gravity = options.gravity.find(quantity);
    if (gravity != options.gravity.end()) path.gravity[k] = gravity->second;
  }
  for (Index i = 0; i < all.rows(); ++i) {
    if (!all.row(i).array().isNaN().any()) path.frame.push_back(i);
  }
  path.times.resize(static_cast<Index>(path.frame.size()));
  path.positions.resize(path.count(), quantities);
  for (Index k = 0; k < path.count(); ++k) {
    const Index frame = path.frame[static_cast<std::size_t>(k)];
    path.times[k] = capture.times[frame];
    path.positions.row(k) = all.row(frame);
  }
  return path;
}

/// Mean velocity and time of some frames.
struct Slope {
  Eigen::RowVectorXd velocity;
  double time;
};

/// Slope of frames [first, first + kSide) but one (-1: of all). @param clock of all frames
Slope slope(const Path& path, const Eigen::VectorXd& clock, Index first, Index but) {
  Eigen::VectorXd weight = Eigen::VectorXd::Ones(kSide);
  if (but >= first && but < first + kSide) weight[but - first] = 0.0;
  const Eigen::VectorXd times = clock.segment(first, kSide);
  const double middle = weight.dot(times) / weight.sum();
  const Eigen::VectorXd lever = weight.cwiseProduct((times.array() - middle).matrix());
  return {lever.transpose() * path.positions.middleRows(first, kSide) / lever.dot(times), middle};
}

/// Times as if no frame were missing: a few rounded times look like a frame that is not there.
Eigen::VectorXd without_gaps(const Eigen::VectorXd& times) {
  const double interval = median_interval(times);
  Eigen::VectorXd closed = times;
  for (Index k = 1; k < times.size(); ++k)
    closed[k] = closed[k - 1] + std::min(times[k] - times[k - 1], interval);
  return closed;
}

/// Jump of the velocity between frame `last` and the next, m/s, gravity removed; the least that is left when
/// one of the frames is left out, by any of the clocks.
double jump_after(const Path& path, std::span<const Eigen::VectorXd> clocks, Index last) {
  const Index first = last + 1 - kSide;
  double least = std::numeric_limits<double>::infinity();
  for (const Eigen::VectorXd& clock : clocks) {
    for (Index but = first - 1; but < first + 2 * kSide; ++but) {
      const Slope before = slope(path, clock, first, but);
      const Slope after = slope(path, clock, last + 1, but);
      const Eigen::RowVectorXd jump =
          after.velocity - before.velocity - path.gravity * (after.time - before.time);
      least = std::min(least, jump.norm());
    }
  }
  return least;
}

/// A capture's first frames.
Capture head(const Capture& capture, Index count) {
  Capture part = capture;
  part.times.conservativeResize(count);
  for (Channel& channel : part.channels) channel.values.conservativeResize(count);
  return part;
}

}  // namespace

BeforeImpact before_impact(const Capture& capture, const ImpactOptions& options) {
  if (!(options.jump > 0.0))
    throw ArgumentError(fmt::format("a jump is {} m/s; more than 0 was expected", options.jump));
  const Path path = seen_path(capture, options);
  BeforeImpact result{.capture = capture};
  const Eigen::VectorXd clocks[] = {path.times, without_gaps(path.times)};
  std::optional<Index> impact;  // the frame before it
  for (Index last = kSide - 1; last + kSide < path.count(); ++last) {
    if (impact && last > *impact + kSide) break;
    const double jump = jump_after(path, clocks, last);
    if (jump > result.jump) {
      result.jump = jump;
      if (jump > options.jump) impact = last;
    }
  }
  if (!impact) return result;
  const Index before = path.frame[static_cast<std::size_t>(*impact)];
  result.impact_time = 0.5 * (path.times[*impact] + path.times[*impact + 1]);
  if (before < 3) {
    throw ArgumentError(
        fmt::format("capture \"{}\" has an impact at {:.4g} s, which leaves {} frames; at "
                    "least 3 were expected",
                    capture.id, *result.impact_time, before));
  }
  result.capture = head(capture, before);
  result.capture.notes.push_back(
      fmt::format("cut before an impact at {:.4g} s, where the velocity jumps by {:.3g} m/s; {} of {} frames "
                  "are left",
                  *result.impact_time, result.jump, before, capture.frame_count()));
  return result;
}

Capture while_inside(const Capture& capture, const std::string& quantity, double lower, double upper) {
  const Channel& channel = capture.channel(quantity);
  Eigen::Index count = 0;
  while (count < channel.values.size() && !(channel.values[count] < lower) &&
         !(channel.values[count] > upper))
    ++count;
  if (count == channel.values.size()) return capture;
  if (count < 3) {
    throw ArgumentError(fmt::format(
        "capture \"{}\" has {} = {} {} at {} s, outside {} to {}, and {} frames before; at least 3 were "
        "expected",
        capture.id, quantity, channel.values[count], channel.unit, capture.times[count], lower, upper,
        count));
  }
  Capture part = capture;
  part.times.conservativeResize(count);
  for (Channel& one : part.channels) one.values.conservativeResize(count);
  part.notes.push_back(fmt::format("{} frames cut from {:.4g} s on, where {} leaves {:.4g} to {:.4g} {}",
                                   capture.times.size() - count, capture.times[count], quantity, lower, upper,
                                   channel.unit));
  return part;
}

}  // namespace samara::identification
