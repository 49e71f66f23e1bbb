#include "samara/identification/captures/frame_grid.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

using Eigen::Index;

struct Grid {
  double period;
  double first;  ///< time of place 0
};

std::complex<double> resonance(const Eigen::VectorXd& times, double period) {
  std::complex<double> sum = 0.0;
  for (const double t : times) sum += std::polar(1.0, 2.0 * std::numbers::pi * t / period);
  return sum;
}

/// The frequency near a first one at which times resonate most, searched up to `range` (a share) away in
/// steps of a tenth of a peak's width.
double most_resonant(const Eigen::VectorXd& times, double frequency, double range) {
  constexpr double kStepsPerPeak = 10.0;
  const double duration = times[times.size() - 1] - times[0];
  const int steps = static_cast<int>(std::ceil(kStepsPerPeak * range * frequency * duration)) + 1;
  double best = frequency;
  double strongest = 0.0;
  for (int k = -steps; k <= steps; ++k) {
    const double candidate = frequency * (1.0 + range * k / steps);
    const double strength = std::abs(resonance(times, 1.0 / candidate));
    if (strength > strongest) {
      strongest = strength;
      best = candidate;
    }
  }
  return best;
}

/// Mean of the intervals that are about as long as the median one. Of an even number it is the lower of the two in the
/// middle: between single and double intervals, half of each, there is none.
double common_interval(const Eigen::VectorXd& times) {
  std::vector<double> intervals;
  for (Index k = 1; k < times.size(); ++k) intervals.push_back(times[k] - times[k - 1]);
  const auto lower = intervals.begin() + (std::ssize(intervals) - 1) / 2;
  std::ranges::nth_element(intervals, lower);
  const double middle = *lower;
  double sum = 0.0;
  int count = 0;
  for (Index k = 1; k < times.size(); ++k) {
    const double interval = times[k] - times[k - 1];
    if (std::abs(interval - middle) >= 0.25 * middle) continue;
    sum += interval;
    ++count;
  }
  return sum / count;
}

/// The grid of a period on which times lie best.
Grid grid_of(const Eigen::VectorXd& times, double period) {
  return {period, std::arg(resonance(times, period)) / (2.0 * std::numbers::pi) * period};
}

/// From the first frames to all: the longer the times, the sharper the peak, and the narrower the search.
Grid resonant_grid(const Eigen::VectorXd& times) {
  constexpr double kRange = 0.03;  // the rounding of times takes the median interval off by up to a step
  constexpr Index kFirst = 128;
  constexpr Index kGrowth = 4;
  double frequency = 1.0 / common_interval(times);
  double range = kRange;
  for (Index count = std::min(kFirst, times.size());; count = std::min(kGrowth * count, times.size())) {
    const Eigen::VectorXd part = times.head(count);
    frequency = most_resonant(part, frequency, range);
    if (count == times.size()) break;
    range = 1.0 / (frequency * (part[count - 1] - part[0]));
  }
  return grid_of(times, 1.0 / frequency);
}

/// Places on the grid that increase from frame to frame, with the least sum of distances: what a frame's
/// place exceeds its number by must not decrease, which is an isotonic regression (pool adjacent violators),
/// and with absolute distances its solution may be rounded.
std::vector<long> increasing_places(const Eigen::VectorXd& times, const Grid& grid) {
  struct Block {
    std::vector<double> excess;
    double middle;
  };
  std::vector<Block> blocks;
  for (Index k = 0; k < times.size(); ++k) {
    const double excess = (times[k] - grid.first) / grid.period - static_cast<double>(k);
    blocks.push_back({{excess}, excess});
    while (blocks.size() > 1 &&
           std::lround(blocks[blocks.size() - 2].middle) > std::lround(blocks.back().middle)) {
      Block last = std::move(blocks.back());
      blocks.pop_back();
      Block& pooled = blocks.back();
      pooled.excess.insert(pooled.excess.end(), last.excess.begin(), last.excess.end());
      pooled.middle = median(pooled.excess);
    }
  }
  std::vector<long> places;
  for (const Block& block : blocks) {
    for (std::size_t k = 0; k < block.excess.size(); ++k)
      places.push_back(std::lround(block.middle) + static_cast<long>(places.size()));
  }
  return places;
}

/// m, from each frame (a row) to the next; NaN where a place was not seen, no columns where none was measured.
Eigen::MatrixXd steps_of(const Capture& capture) {
  Eigen::MatrixXd steps(capture.times.size() - 1, 0);
  for (const char* name : {"x", "y", "z"}) {
    if (!capture.has(name) || capture.channel(name).unit != "m") continue;
    const Eigen::VectorXd& place = capture.channel(name).values;
    steps.conservativeResize(Eigen::NoChange, steps.cols() + 1);
    steps.rightCols(1) = place.tail(steps.rows()) - place.head(steps.rows());
  }
  return steps;
}

/// How far vectors may be from a step, as a share of its length, to count as one of the same motion.
constexpr double kAlike = 0.25;

bool is_alike(const Eigen::RowVectorXd& one, const Eigen::RowVectorXd& step) {
  return (one - step).norm() < kAlike * step.norm();
}

/// Mean of the steps around one that are known to be of one interval; nothing where they are not alike on both sides:
/// of a body that turns round or bounces there, a chord does not tell the way.
std::optional<Eigen::RowVectorXd> usual_step(const Eigen::MatrixXd& steps, const std::vector<long>& places,
                                             Index near) {
  constexpr Index kEachSide = 4, kFewest = 2;
  std::vector<Index> around;
  Index before = 0;
  for (Index k = std::max<Index>(near - kEachSide, 0); k <= std::min(near + kEachSide, steps.rows() - 1);
       ++k) {
    const auto at = static_cast<std::size_t>(k);
    if (k == near || places[at + 1] != places[at] + 1 || !steps.row(k).allFinite()) continue;
    around.push_back(k);
    before += k < near ? 1 : 0;
  }
  const Index after = std::ssize(around) - before;
  // Nothing comes before the first frame of a recording, which is often late.
  if (near == 0 ? after < 2 * kFewest : std::min(before, after) < kFewest) return {};
  const Eigen::RowVectorXd mean = steps(around, Eigen::all).colwise().mean();
  for (const Index k : around) {
    if (!is_alike(steps.row(k), mean)) return {};
  }
  return mean;
}

/// A frame that only the clock misses is none: where the body moved on evenly as by one interval, later frames came
/// late. Of longer gaps nothing is told, since a path may bend within them.
/// @returns the frames from which on places were moved
std::vector<Index> close_late_places(const Capture& capture, std::vector<long>& places) {
  std::vector<Index> late_from;
  const Eigen::MatrixXd steps = steps_of(capture);
  if (steps.cols() == 0) return late_from;
  for (Index k = 0; k < steps.rows(); ++k) {
    const auto next = static_cast<std::size_t>(k + 1);
    if (places[next] - places[next - 1] != 2) continue;
    const std::optional<Eigen::RowVectorXd> usual = usual_step(steps, places, k);
    if (!usual || !is_alike(steps.row(k), *usual)) continue;
    for (std::size_t later = next; later < places.size(); ++later) --places[later];
    late_from.push_back(k + 1);
  }
  return late_from;
}

/// Slope of times over places, within the runs of frames between jumps.
double period_of_runs(const Eigen::VectorXd& times, const Eigen::VectorXd& place,
                      const std::vector<Index>& jumps) {
  Eigen::VectorXd centred = place;
  Index first = 0;
  for (std::size_t run = 0; run <= jumps.size(); ++run) {
    const Index end = run < jumps.size() ? jumps[run] : place.size();
    centred.segment(first, end - first).array() -= place.segment(first, end - first).mean();
    first = end;
  }
  return centred.dot(times) / centred.squaredNorm();
}

/// Jumps after which frames stay late by a whole period. Frames that catch up tell the period together with those
/// before.
std::vector<Index> lasting(const Eigen::VectorXd& times, const Eigen::VectorXd& place,
                           const std::vector<Index>& jumps) {
  constexpr double kSlip = 0.1;
  std::vector<Index> kept;
  if (jumps.empty()) return kept;
  const double period = period_of_runs(times, place, jumps);
  const Eigen::VectorXd delay = times - period * place;
  Index before = 0;
  for (std::size_t k = 0; k < jumps.size(); ++k) {
    const Index begin = jumps[k], end = k + 1 < jumps.size() ? jumps[k + 1] : place.size();
    const double late =
        delay.segment(begin, end - begin).mean() - delay.segment(before, begin - before).mean();
    if (std::abs(late - period) <= kSlip * period) kept.push_back(begin);
    before = begin;
  }
  return kept;
}

/// @param known the period, if it is not to be fitted
/// @param late_from frames from which on places were moved
Grid fitted_grid(const Eigen::VectorXd& times, const std::vector<long>& places, std::optional<double> known,
                 const std::vector<Index>& late_from = {}) {
  Eigen::VectorXd place(times.size());
  for (Index k = 0; k < place.size(); ++k)
    place[k] = static_cast<double>(places[static_cast<std::size_t>(k)]);
  const double period = known ? *known : period_of_runs(times, place, lasting(times, place, late_from));
  return {period, times.mean() - period * place.mean()};
}

/// @throws ArgumentError where the times have no common interval, or a jump that no frames lie in
void check_times(const Capture& capture) {
  const Eigen::VectorXd& times = capture.times;
  const double interval = times.allFinite() ? common_interval(times) : std::nan("");
  if (!(interval > 0.0 && std::isfinite(interval))) {
    throw ArgumentError(fmt::format(
        "capture \"{}\" has frames {} s apart; finite times that increase were expected for a grid",
        capture.id, interval));
  }
  // The search for the period takes steps by their number.
  constexpr double kMostPlaces = 1e7;
  const double duration = times[times.size() - 1] - times[0];
  if (!(duration <= kMostPlaces * interval)) {
    throw ArgumentError(fmt::format(
        "capture \"{}\" has {} frames {:.5g} ms apart over {:.6g} s: a grid of more than {:.0e} places; "
        "times without such a jump were expected",
        capture.id, times.size(), 1e3 * interval, duration, kMostPlaces));
  }
}

/// @throws ArgumentError where frames do not lie whole periods apart
void check_known(const Capture& capture, double period) {
  if (!(period > 0.0 && std::isfinite(period))) {
    throw ArgumentError(
        fmt::format("a frame period is {} s; a finite one of more than 0 was expected", period));
  }
  // Of more of them, as of a period whose unit is wrong, one always fits.
  constexpr double kSlip = 0.1, kMostPeriods = 100.0;
  const double interval = common_interval(capture.times);
  const double periods = interval / period;
  if (periods < 1.0 - kSlip || std::round(periods) > kMostPeriods ||
      std::abs(periods - std::round(periods)) > kSlip * std::clamp(std::round(periods), 1.0, 3.0)) {
    throw ArgumentError(
        fmt::format("capture \"{}\" has frames {:.5g} ms apart, and a frame period of {:.5g} ms was given; "
                    "one that goes into it a whole number of times, at most {:.0f}, was expected",
                    capture.id, 1e3 * interval, 1e3 * period, kMostPeriods));
  }
}

}  // namespace

FrameGrid on_frame_grid(const Capture& capture, std::optional<double> known_period) {
  const Eigen::VectorXd& times = capture.times;
  if (times.size() < 4) {
    throw ArgumentError(fmt::format("capture \"{}\" has {} frames; at least 4 were expected for a grid",
                                    capture.id, times.size()));
  }
  check_times(capture);
  if (known_period) check_known(capture, *known_period);
  Grid grid = known_period ? grid_of(times, *known_period) : resonant_grid(times);
  std::vector<long> places = increasing_places(times, grid);
  grid = fitted_grid(times, places, known_period);
  places = increasing_places(times, grid);
  const std::vector<Index> late_from = close_late_places(capture, places);
  grid = fitted_grid(times, places, known_period, late_from);

  FrameGrid result{.capture = capture, .period = grid.period};
  Eigen::VectorXd shifts(times.size());
  for (Index k = 0; k < times.size(); ++k) {
    const long since = places[static_cast<std::size_t>(k)] - places[0];
    const double fitted = grid.first + grid.period * static_cast<double>(places[static_cast<std::size_t>(k)]);
    shifts[k] = fitted - times[k];
    result.capture.times[k] = times[0] + grid.period * static_cast<double>(since);
  }
  result.rms_shift = std::sqrt(shifts.squaredNorm() / static_cast<double>(shifts.size()));
  result.largest_shift = shifts.cwiseAbs().maxCoeff();
  result.dropped_frames = static_cast<int>(places.back() - places.front() + 1 - times.size());
  result.capture.notes.push_back(fmt::format(
      "times set to multiples of {:.5g} ms (shifts: rms {:.2g} ms, largest {:.2g} ms); {} frames are missing",
      1e3 * result.period, 1e3 * result.rms_shift, 1e3 * result.largest_shift, result.dropped_frames));
  return result;
}

}  // namespace samara::identification
