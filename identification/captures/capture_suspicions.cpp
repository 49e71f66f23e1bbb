#include "samara/identification/captures/capture_suspicions.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

using Eigen::Index;

constexpr double kGravity = 9.81;  // m/s^2
constexpr double kSound = 340.0;   // m/s
constexpr Index kFewFrames = 8;
/// Fewer say nothing about order or acceleration.
constexpr Index kFramesForMotion = 10;

struct SeenValues {
  Eigen::VectorXd times;
  Eigen::VectorXd values;

  Index count() const { return values.size(); }
  Eigen::VectorXd steps() const { return values.tail(count() - 1) - values.head(count() - 1); }
  Eigen::VectorXd intervals() const { return times.tail(count() - 1) - times.head(count() - 1); }
};

SeenValues seen_values(const Capture& capture, const Channel& channel) {
  std::vector<double> times;
  std::vector<double> values;
  for (Index i = 0; i < channel.values.size(); ++i) {
    if (!std::isfinite(channel.values[i])) continue;
    times.push_back(capture.times[i]);
    values.push_back(channel.values[i]);
  }
  const auto count = static_cast<Index>(values.size());
  return {Eigen::Map<Eigen::VectorXd>(times.data(), count),
          Eigen::Map<Eigen::VectorXd>(values.data(), count)};
}

bool is_position(const Channel& channel) {
  const std::vector<std::string> names = {"x", "y", "z"};
  return channel.unit == "m" && std::ranges::count(names, channel.quantity) > 0;
}

using Sentences = std::vector<std::string>;

/// @returns whether times increase, so that the rest makes sense
bool suspect_times(const Capture& capture, Sentences& found) {
  const Eigen::VectorXd& times = capture.times;
  if (!times.allFinite()) {
    found.push_back("some times are not finite");
    return false;
  }
  Index backward = 0;
  for (Index k = 1; k < times.size(); ++k) backward += times[k] <= times[k - 1];
  if (backward > 0) {
    found.push_back(
        fmt::format("{} of {} times do not increase: are the rows out of order?", backward, times.size()));
    return false;
  }
  if (times.size() < 3) return false;
  const double interval = median_interval(times);
  if (interval > 1.0)
    found.push_back(fmt::format("frames are {:.3g} s apart: are times in another unit?", interval));
  if (interval < 1e-5)
    found.push_back(fmt::format("frames are {:.3g} s apart: are times in another unit?", interval));
  double missing = 0.0;
  const std::vector<Gap> holes = gaps(capture);
  for (const Gap& gap : holes) missing += static_cast<double>(gap.missing);
  if (missing > 0.0)
    found.push_back(fmt::format("{} frames are missing, in {} gaps of the times", missing, holes.size()));
  return true;
}

/// Of all positions together: one of them may hardly move, and be noise.
void suspect_order(const Capture& capture, Sentences& found) {
  double steps = 0.0;
  double variance = 0.0;
  for (const Channel& channel : capture.channels) {
    const SeenValues seen = seen_values(capture, channel);
    if (!is_position(channel) || seen.count() < kFramesForMotion) continue;
    steps += seen.steps().array().square().mean();
    variance += (seen.values.array() - seen.values.mean()).square().mean();
  }
  // Von Neumann's ratio: 2 for values without order, near 0 for a motion that frames resolve.
  if (steps > variance) {
    found.push_back(
        "the position in a frame has little to do with that in the frame before: are the rows out of order?");
  }
}

void suspect_angle(const Channel& channel, const SeenValues& seen, Sentences& found) {
  const Eigen::VectorXd steps = seen.steps().cwiseAbs();
  const double step = median({steps.begin(), steps.end()});
  if (step > 0.5 * std::numbers::pi) {
    found.push_back(fmt::format("{} turns by {:.3g} rad from frame to frame: are these degrees?",
                                channel.quantity, step));
  }
}

void suspect_speed(const Channel& channel, const SeenValues& seen, Sentences& found) {
  const Eigen::ArrayXd speed = seen.steps().array().abs() / seen.intervals().array();
  Index fastest = 0;
  if (speed.maxCoeff(&fastest) > kSound) {
    found.push_back(fmt::format(
        "{} jumps by {:.3g} m within {:.3g} s (at {:.4g} s): another unit, or a wrong frame?",
        channel.quantity, std::abs(seen.steps()[fastest]), seen.intervals()[fastest], seen.times[fastest]));
  }
}

/// Steps of all positions together.
void suspect_breaks(const Capture& capture, Sentences& found) {
  constexpr double kTimes = 4.0;  // as fast as nine frames in ten
  std::vector<double> speeds;
  std::vector<double> times;
  std::optional<std::pair<double, Eigen::VectorXd>> before;
  for (Index i = 0; i < capture.times.size(); ++i) {
    std::vector<double> position;
    for (const Channel& channel : capture.channels) {
      if (is_position(channel)) position.push_back(channel.values[i]);
    }
    const Eigen::VectorXd here =
        Eigen::Map<Eigen::VectorXd>(position.data(), static_cast<Index>(position.size()));
    if (position.empty() || !here.allFinite()) continue;
    if (before) {
      speeds.push_back((here - before->second).norm() / (capture.times[i] - before->first));
      times.push_back(capture.times[i]);
    }
    before = {capture.times[i], here};
  }
  if (speeds.size() < static_cast<std::size_t>(kFramesForMotion)) return;
  std::vector<double> sorted = speeds;
  std::ranges::sort(sorted);
  const double usual = sorted[9 * sorted.size() / 10];
  const auto fastest = std::ranges::max_element(speeds);
  if (*fastest <= kTimes * usual || *fastest > kSound) return;
  found.push_back(
      fmt::format("the position moves at {:.3g} m/s before {:.4g} s, {:.{}f} times what it otherwise does: "
                  "another body, or a wrong frame?",
                  *fastest, times[static_cast<std::size_t>(fastest - speeds.begin())], *fastest / usual,
                  *fastest < 10.0 * usual ? 1 : 0));
}

void suspect_span(const Channel& channel, const SeenValues& seen, Sentences& found) {
  const double span = seen.values.maxCoeff() - seen.values.minCoeff();
  if (span < 1e-4) {
    found.push_back(
        fmt::format("{} moves by {:.2g} m in all: is it in another unit?", channel.quantity, span));
  }
}

/// Of the positions together, over frames.
struct Acceleration {
  double size = 0.0;   ///< m/s^2: the median length
  double error = 0.0;  ///< m/s^2: the median of its standard error
  double range = 1.0;  ///< over the middle half of the frames: the largest length over the smallest
};

Acceleration acceleration_of(const Capture& capture, SmoothingOptions options) {
  // The bandwidth is wide: accelerations at some of the frames are enough, and much faster.
  constexpr Index kFrames = 24;
  const Index stride = 1 + capture.times.size() / kFrames;
  const Eigen::VectorXd times = capture.times(Eigen::seq(0, capture.times.size() - 1, stride));
  options.degree = 2;
  options.bandwidth = 0.25 * (capture.times[capture.times.size() - 1] - capture.times[0]);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(times.size());
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(times.size());
  for (const Channel& channel : capture.channels) {
    const Eigen::VectorXd values = channel.values(Eigen::seq(0, channel.values.size() - 1, stride));
    if (!is_position(channel) || values.size() - values.array().isNaN().count() < kFramesForMotion) continue;
    if (values.array().isInf().any()) continue;
    const Smoothed s = smooth(times, values, times, options);
    squares += s.acceleration.col(0).cwiseAbs2();
    errors += s.acceleration_error.col(0).cwiseAbs2();
  }
  std::ranges::sort(squares);
  const Index quarter = squares.size() / 4;
  return {.size = std::sqrt(median({squares.begin(), squares.end()})),
          .error = std::sqrt(median({errors.begin(), errors.end()})),
          .range = std::sqrt(squares[squares.size() - 1 - quarter] / squares[quarter])};
}

/// One for all positions: the length of the acceleration says it, whatever the axes.
void suspect_acceleration(const Capture& capture, bool falls, Sentences& found) {
  constexpr double kMost = 5.0;  // times gravity
  // Finding outliers takes most of the time: it is left out where a look without shows the acceleration of a falling
  // body.
  constexpr double kLeastUsual = 0.1, kMostUsual = 3.0;  // times gravity
  const SmoothingOptions plain{.noise = 0.0, .outlier_threshold = std::numeric_limits<double>::infinity()};
  const double look = acceleration_of(capture, plain).size / kGravity;
  if (look > kLeastUsual && look < kMostUsual) return;
  const auto [size, error, range] = acceleration_of(capture, {});
  if (!(size > 5.0 * error)) return;
  // Near its final speed a body accelerates by any small share of gravity, which soon is another one.
  constexpr double kConstant = 1.1;
  const double power = std::log10(size / kGravity);
  const bool is_power =
      std::abs(power - std::round(power)) < 0.02 && std::abs(power) > 1.5 && std::abs(power) < 4.5;
  if (is_power && (power > 0.0 || (falls && range < kConstant))) {
    found.push_back(
        fmt::format("positions accelerate by {:.3g} m/s^2, gravity times 10^{:.0f}: are lengths or times "
                    "in another unit?",
                    size, power));
  } else if (size > kMost * kGravity) {
    found.push_back(
        fmt::format("positions accelerate by {:.3g} m/s^2 most of the time, {:.2g} times gravity: are "
                    "lengths or times in another unit?",
                    size, size / kGravity));
  }
}

void suspect_quaternion(const Capture& capture, Sentences& found) {
  if (!std::ranges::all_of(kQuaternionChannels, [&](const std::string& q) { return capture.has(q); })) return;
  constexpr double kTolerance = 0.01;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(capture.times.size());
  for (const std::string& q : kQuaternionChannels) squares += capture.channel(q).values.cwiseAbs2();
  Index wrong = 0;
  for (const double square : squares) wrong += std::abs(std::sqrt(square) - 1.0) > kTolerance;
  if (wrong > 0)
    found.push_back(fmt::format("{} of {} quaternions are not of unit length", wrong, capture.frame_count()));
}

void suspect_channel(const Capture& capture, const Channel& channel, bool ordered, Sentences& found) {
  if (channel.values.array().isInf().any())
    found.push_back(fmt::format("some values of {} are infinite", channel.quantity));
  const SeenValues seen = seen_values(capture, channel);
  if (2 * seen.count() < channel.values.size()) {
    found.push_back(
        fmt::format("{} is seen in {} of {} frames", channel.quantity, seen.count(), channel.values.size()));
  }
  if (seen.count() < 3) return;
  if ((is_position(channel) || is_angle(channel)) && (seen.values.array() == seen.values[0]).all()) {
    found.push_back(fmt::format("{} never changes over {} frames", channel.quantity, seen.count()));
    return;
  }
  if (!ordered) return;
  if (is_angle(channel)) suspect_angle(channel, seen, found);
  if (is_position(channel)) {
    suspect_speed(channel, seen, found);
    suspect_span(channel, seen, found);
  }
}

/// "3 frames are missing" and "12 frames are missing" are alike, and "it has 1 frame" is, too.
std::string without_numbers(const std::string& sentence) {
  std::string kept;
  for (std::size_t k = 0; k < sentence.size(); ++k) {
    const bool is_exponent = sentence[k] == 'e' && k + 1 < sentence.size() && !kept.empty() &&
                             kept.back() == '#' && (sentence[k + 1] == '-' || sentence[k + 1] == '+');
    if (is_exponent) ++k;
    const bool is_number = is_exponent || std::isdigit(static_cast<unsigned char>(sentence[k])) != 0 ||
                           (sentence[k] == '.' && !kept.empty() && kept.back() == '#');
    if (!is_number) {
      kept.push_back(sentence[k]);
    } else if (kept.empty() || kept.back() != '#') {
      kept.push_back('#');
    }
  }
  return kept;
}

}  // namespace

std::vector<std::string> suspicions(const Capture& capture, bool falls) {
  check_sizes(capture);
  Sentences found;
  if (capture.times.size() < kFewFrames)
    found.push_back(
        fmt::format("it has {} frame{}", capture.times.size(), capture.times.size() == 1 ? "" : "s"));
  const bool ordered = suspect_times(capture, found);
  for (const Channel& channel : capture.channels) suspect_channel(capture, channel, ordered, found);
  suspect_quaternion(capture, found);
  if (ordered && capture.times.size() >= kFramesForMotion) {
    suspect_order(capture, found);
    suspect_breaks(capture, found);
    suspect_acceleration(capture, falls, found);
  }
  return found;
}

std::vector<std::string> suspicions_of_all(std::span<const Capture> captures, bool falls) {
  std::vector<Sentences> found(captures.size());
  parallel_for(captures.size(), [&](std::size_t k) { found[k] = suspicions(captures[k], falls); });
  std::vector<std::pair<std::string, std::string>> all;
  for (std::size_t k = 0; k < found.size(); ++k) {
    for (std::string& sentence : found[k]) all.emplace_back(captures[k].id, std::move(sentence));
  }
  return merge_alike(all);
}

std::vector<std::string> merge_alike(const std::vector<std::pair<std::string, std::string>>& sentences) {
  struct Kind {
    std::string without_numbers, first;
    std::vector<std::string> others = {};  ///< ids
  };
  std::vector<Kind> kinds;
  for (const auto& [id, sentence] : sentences) {
    const std::string kind = without_numbers(sentence);
    const auto found = std::ranges::find(kinds, kind, &Kind::without_numbers);
    if (found == kinds.end()) {
      kinds.push_back({kind, fmt::format("capture \"{}\": {}", id, sentence)});
    } else {
      found->others.push_back(fmt::format("\"{}\"", id));
    }
  }
  Sentences all;
  for (Kind& kind : kinds) {
    constexpr std::size_t kNamed = 5;
    const std::size_t count = kind.others.size();
    std::string more;
    if (count > 0) {
      kind.others.resize(std::min(count, kNamed));
      more = fmt::format("; likewise {} more: {}{}", count, fmt::join(kind.others, ", "),
                         count > kNamed ? ", .." : "");
    }
    all.push_back(kind.first + more);
  }
  return all;
}

}  // namespace samara::identification
