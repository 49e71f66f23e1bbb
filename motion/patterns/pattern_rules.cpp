#include "samara/motion/patterns/pattern_rules.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/motion/records/even_frames.h"

namespace samara::motion {

namespace {

/// Asks features against thresholds one after another, and remembers how near it came to one.
class Decision {
 public:
  explicit Decision(const Features& features) : features_(features) {}

  bool is_below(Feature feature, double threshold) {
    const double value = features_[feature];
    margin_ = std::min(margin_, std::abs(value - threshold) / threshold);
    asked_ = fmt::format("{} {:.3g} is {} {:.3g}", feature_infos()[static_cast<std::size_t>(feature)].name,
                         value, value < threshold ? "below" : "not below", threshold);
    return value < threshold;
  }
  bool is_above(Feature feature, double threshold) {
    const bool above = !is_below(feature, threshold);
    return above && features_.knows(feature);
  }

  PatternLabel is(Pattern pattern) const { return {pattern, margin_, asked_}; }

  static PatternLabel unresolved(std::string why) { return {Pattern::unresolved, 0.0, std::move(why)}; }

 private:
  const Features& features_;
  double margin_ = std::numeric_limits<double>::infinity();
  std::string asked_;
};

/// Noise alone looks like more than the threshold, and the signal is not clearly more than the noise.
bool is_hidden(double signal, double noise, double threshold, double factor) {
  return noise > threshold && signal < factor * noise;
}

bool goes_round(Decision& decision, const Features& f, const PatternThresholds& limits) {
  if (!f.knows(Feature::winding) || !f.knows(Feature::wobble)) return false;
  if (f.seen == Seen::space && !(f[Feature::flips] < limits.flips_space)) return false;
  // Nothing that goes there and back comes near to these: they count for the margin of revolutions alone.
  if (f[Feature::winding] < limits.winding || f[Feature::turns] < limits.turns) return false;
  return decision.is_above(Feature::winding, limits.winding) &&
         decision.is_above(Feature::turns, limits.turns);
}

PatternLabel label_attitude(const Features& f, const PatternThresholds& limits) {
  if (f[Feature::frame_angle] > limits.frame_angle) {
    return Decision::unresolved(fmt::format("it turns {:.2g} rad between two frames, more than {:.2g}",
                                            f[Feature::frame_angle], limits.frame_angle));
  }
  if (is_hidden(f[Feature::tilt], f[Feature::tilt_noise], limits.steady_tilt, limits.noise_factor)) {
    return Decision::unresolved(fmt::format("a tilt of {:.2g} rad is under {:g} times its noise, {:.2g}",
                                            f[Feature::tilt], limits.noise_factor, f[Feature::tilt_noise]));
  }
  const bool planar = f.seen == Seen::plane;
  Decision decision(f);
  const bool steady = decision.is_below(Feature::tilt, limits.steady_tilt);
  if (steady && !(f[Feature::lengths] < limits.steady_lengths)) return decision.is(Pattern::steady);
  if (!planar && goes_round(decision, f, limits))
    return decision.is(decision.is_below(Feature::wobble, limits.wobble) ? Pattern::spiral : Pattern::helix);
  if (steady || f[Feature::swings] < limits.fewest_swings) {
    return Decision::unresolved(
        steady ? fmt::format("steady so far, over {:.2g} lengths of the body", f[Feature::lengths])
               : fmt::format("{} swings, fewer than {:g}", f[Feature::swings], limits.fewest_swings));
  }
  if (decision.is_below(Feature::flips, planar ? limits.flips_plane : limits.flips_space))
    return decision.is(Pattern::zigzag);
  if (decision.is_above(Feature::coherence, planar ? limits.coherence_plane : limits.coherence_space))
    return decision.is(Pattern::autorotation);
  const bool chaotic = f.knows(Feature::spread)
                           ? decision.is_above(Feature::spread, limits.spread)
                           : decision.is_above(Feature::recurrence,
                                               planar ? limits.recurrence_plane : limits.recurrence_space);
  return decision.is(chaotic ? Pattern::chaotic : Pattern::mixed);
}

PatternLabel label_positions(const Features& f, const PatternThresholds& limits) {
  if (is_hidden(f[Feature::sway], f[Feature::sway_noise], limits.steady_sway, limits.noise_factor)) {
    return Decision::unresolved(fmt::format("a sway of {:.2g} is under {:g} times its noise, {:.2g}",
                                            f[Feature::sway], limits.noise_factor, f[Feature::sway_noise]));
  }
  Decision decision(f);
  const bool steady = decision.is_below(Feature::sway, limits.steady_sway);
  if (steady && !(f[Feature::lengths] < limits.steady_lengths)) return decision.is(Pattern::steady);
  if (steady)
    return Decision::unresolved(
        fmt::format("steady so far, over {:.2g} lengths of the body", f[Feature::lengths]));
  if (goes_round(decision, f, limits))
    return decision.is(decision.is_below(Feature::wobble, limits.wobble) ? Pattern::spiral : Pattern::helix);
  const bool onward = f[Feature::veers] < limits.veers && !(f[Feature::straightness] < limits.straightness);
  // Of what walks straight on, a swing is half a turn, and one less is enough.
  const double fewest = onward ? limits.fewest_swings - 1.0 : limits.fewest_swings;
  if (f[Feature::swings] < fewest)
    return Decision::unresolved(fmt::format("{} swings, fewer than {:g}", f[Feature::swings], fewest));
  if (onward && decision.is_above(Feature::straightness, limits.straightness))
    return decision.is(Pattern::autorotation);
  const bool chaotic = f.knows(Feature::spread)
                           ? decision.is_above(Feature::spread, limits.spread)
                           : decision.is_above(Feature::recurrence, limits.recurrence_positions);
  if (chaotic) return decision.is(Pattern::chaotic);
  return decision.is(decision.is_below(Feature::veers, limits.veers) ? Pattern::autorotation
                                                                     : Pattern::zigzag);
}

/// Frames of a window: the first, and how many.
struct WindowFrames {
  Eigen::Index first = 0, count = 0;
};

/// Borders lie half way between swings.
std::vector<WindowFrames> window_frames(const SmoothedMotion& motion, const WindowOptions& options) {
  const Eigen::Index frames = motion.frame_count();
  const std::vector<Eigen::Index> swings = swing_frames(motion);
  const auto width = static_cast<std::size_t>(std::lround(options.swings));
  const auto stride =
      std::max<std::size_t>(1, static_cast<std::size_t>((1.0 - options.overlap) * options.swings));
  if (swings.size() <= width) return {{0, frames}};
  const auto border = [&](std::size_t before) {
    if (before == 0) return Eigen::Index{0};
    return before >= swings.size() ? frames : (swings[before - 1] + swings[before]) / 2;
  };
  std::vector<WindowFrames> windows;
  for (std::size_t first = 0; first + width <= swings.size(); first += stride) {
    const Eigen::Index count = std::max(kFewestFrames, border(first + width) - border(first));
    windows.push_back({std::min(border(first), frames - count), count});
  }
  windows.back().count = frames - windows.back().first;  // with what is left at the end
  return windows;
}

}  // namespace

const std::vector<std::string>& pattern_names() {
  static const std::vector<std::string> names = {"steady", "zigzag", "autorotation", "chaotic",
                                                 "spiral", "helix",  "mixed",        "unresolved"};
  return names;
}

std::string to_string(Pattern pattern) {
  return pattern_names().at(static_cast<std::size_t>(pattern));
}

Pattern pattern_of(std::string_view name) {
  const auto it = std::ranges::find(pattern_names(), name);
  if (it != pattern_names().end()) return static_cast<Pattern>(it - pattern_names().begin());
  throw ArgumentError(fmt::format("there is no pattern \"{}\"{}", name, suggestion(name, pattern_names())));
}

const std::vector<NamedThreshold>& named_thresholds() {
  using T = PatternThresholds;
  static const std::vector<NamedThreshold> all = {
      {"fewest_swings", &T::fewest_swings},
      {"noise_factor", &T::noise_factor},
      {"steady_tilt", &T::steady_tilt},
      {"steady_sway", &T::steady_sway},
      {"steady_lengths", &T::steady_lengths},
      {"frame_angle", &T::frame_angle},
      {"winding", &T::winding},
      {"turns", &T::turns},
      {"wobble", &T::wobble},
      {"straightness", &T::straightness},
      {"flips_plane", &T::flips_plane},
      {"flips_space", &T::flips_space},
      {"veers", &T::veers},
      {"coherence_plane", &T::coherence_plane},
      {"coherence_space", &T::coherence_space},
      {"recurrence_plane", &T::recurrence_plane},
      {"recurrence_space", &T::recurrence_space},
      {"recurrence_positions", &T::recurrence_positions},
      {"spread", &T::spread},
  };
  return all;
}

void set_threshold(PatternThresholds& thresholds, const std::string& name, double value) {
  std::vector<std::string> known;
  for (const NamedThreshold& one : named_thresholds()) {
    known.push_back(one.name);
    if (one.name != name) continue;
    require_positive(value, name);
    thresholds.*one.value = value;
    return;
  }
  throw ArgumentError(fmt::format("there is no threshold \"{}\"{}", name, suggestion(name, known)));
}

PatternLabel label(const Features& features, const PatternThresholds& thresholds) {
  if (!features.knows(Feature::fall)) return Decision::unresolved("nothing is known of its fall");
  return features.seen == Seen::positions ? label_positions(features, thresholds)
                                          : label_attitude(features, thresholds);
}

std::vector<LabelledWindow> label_windows(const MotionRecord& record, const WindowOptions& options,
                                          const PatternThresholds& thresholds) {
  require(options.swings >= 1.0 && options.swings <= 1000.0, "swings", options.swings,
          "a number from 1 to 1000");
  require(options.overlap >= 0.0 && options.overlap < 1.0, "overlap", options.overlap,
          "a number from 0 to below 1");
  check(record);
  if (const std::string gap = long_gap(record.times); !gap.empty()) {
    const double end = record.times[record.frame_count() - 1];
    return {{record.times[0], end, {Pattern::unresolved, 0.0, gap}, 1}};
  }
  const SmoothedMotion motion = smoothed(record);
  const FeatureOptions all = {.settle_share = 0.0};
  std::vector<LabelledWindow> sequence;
  for (const auto& [first, count] : window_frames(motion, options)) {
    const SmoothedMotion piece = part(motion, first, count);
    LabelledWindow window = {piece.times[0], piece.times[count - 1],
                             label(features(piece, record.length, all), thresholds), 1};
    if (sequence.empty() || sequence.back().label.pattern != window.label.pattern) {
      sequence.push_back(std::move(window));
      continue;
    }
    LabelledWindow& before = sequence.back();
    before.to = window.to;
    before.label.margin = std::min(before.label.margin, window.label.margin);
    ++before.windows;
  }
  return sequence;
}

}  // namespace samara::motion
