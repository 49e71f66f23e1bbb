#include "samara/identification/problem/segments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/units.h"
#include "samara/identification/captures/capture_file.h"
#include "samara/identification/problem/known_values.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

/// What a capture holds for the fit, frame by frame.
class Frames {
 public:
  Frames(const FitProblem& problem, const Capture& capture) : capture_(capture) {
    for (const ComparedOutput& output : problem.outputs) {
      channels_.push_back(&compared_channel(capture, output.name, output.unit));
    }
    if (!problem.attitude_scale) return;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::string& name = problem.requested[static_cast<std::size_t>(problem.attitude_column()) + k];
      attitude_.push_back(&compared_channel(capture, name, "1"));
    }
  }

  /// Adds the frame to a segment, if there is something to compare.
  void add(Eigen::Index frame, Segment& segment) const {
    const auto place = static_cast<int>(segment.times.size());
    bool any = false;
    for (std::size_t o = 0; o < channels_.size(); ++o) {
      const double value = channels_[o]->values[frame];
      if (std::isnan(value)) continue;
      segment.observations.push_back({place, static_cast<int>(o), value});
      any = true;
    }
    if (const auto q = attitude(frame)) {
      segment.attitudes.push_back({place, *q});
      any = true;
    }
    if (any) segment.times.push_back(capture_.times[frame] - segment.start);
  }

  bool has_something(Eigen::Index frame) const {
    return attitude(frame) || std::ranges::any_of(channels_, [&](const Channel* channel) {
             return !std::isnan(channel->values[frame]);
           });
  }

 private:
  std::optional<std::array<double, 4>> attitude(Eigen::Index frame) const {
    if (attitude_.empty()) return {};
    std::array<double, 4> q;
    double square = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
      q[k] = attitude_[k]->values[frame];
      square += q[k] * q[k];
    }
    if (std::isnan(square)) return {};
    if (!(square > 0.0)) {
      refuse(capture_.file, fmt::format("capture \"{}\" has a quaternion of length 0 at {} s", capture_.id,
                                        capture_.times[frame]));
    }
    for (double& part : q) part /= std::sqrt(square);
    return q;
  }

  const Capture& capture_;
  std::vector<const Channel*> channels_;
  std::vector<const Channel*> attitude_;
};

void check_times(const models::FamilyInfo& family, const FitProblem& problem, const Motion& motion,
                 Segment& segment) {
  double previous = 0.0;
  const bool averages = segment.interval > 0.0;
  // The end of a segment lies before the last of its frames where the next one starts before its first.
  const std::size_t frames = segment.times.size() - (segment.joined && segment.lead > 0.0 ? 1 : 0);
  for (std::size_t k = 0; k < frames; ++k) {
    const double time = segment.times[k];
    if (!(time >= previous)) {
      refuse(motion.file,
             fmt::format("capture \"{}\" has a frame at {} s; times that begin at 0 or later and do not "
                         "decrease were expected",
                         motion.id, time));
    }
    previous = time;
  }
  const double half_mean = 0.5 * (problem.averaged_frames - 1) * segment.interval;
  previous += half_mean;
  // Rounding may put a frame on the border just after it, as in first().
  const double interval = previous / static_cast<double>(segment.times.size());
  if (problem.delay) {
    const double first = segment.times.empty() ? 0.0 : segment.times.front() - half_mean;
    check_delay(family, problem, motion, {first, previous}, 1e-3 * interval);
    previous = segment.joined ? segment.times.back() : 0.0;  // the end has no delay
  }
  if (previous <= family.end_time) return;
  if (previous > family.end_time + 1e-3 * interval) {
    refuse(motion.file,
           fmt::format(
               "capture \"{}\" lasts {:.9g} s, but the {} ends at {:.9g} s; a `span` of at most that was "
               "expected",
               motion.id, previous, family.source, family.end_time));
  }
  if (!averages) segment.times.back() = family.end_time;
}

/// Start states are taken from smoothed channels, which have one value at a time.
void check_increase(const Capture& capture, const std::vector<Eigen::Index>& frames) {
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const double time = capture.times[frames[k]];
    const double before = capture.times[frames[k - 1]];
    if (time > before) continue;
    refuse(capture.file,
           fmt::format("capture \"{}\" has a frame at {} s after one at {} s; times that increase were "
                       "expected where captures are cut into segments",
                       capture.id, time, before));
  }
}

/// Trajectories begin at t = 0 of the equations, wherever in the capture that is.
void check_start(const models::FamilyInfo& family, const Motion& motion, const Segment& segment) {
  if (family.autonomous || !family.clock.empty() || segment.start == 0.0) return;
  refuse(
      motion.file,
      fmt::format("the equations of \"{}\" depend on time, but a segment of capture \"{}\" starts at {} s; "
                  "motions from 0 s on, without segments and without means of frames, were expected",
                  family.model, motion.id, segment.start));
}

std::size_t compared_count(const Segment& segment) {
  return segment.observations.size() + 3 * segment.attitudes.size();
}

/// Segments that are joined determine each other.
void check_size(const FitProblem& problem, const Motion& motion) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    count += compared_count(problem.segments[motion.first_segment + k]);
  }
  if (count > static_cast<std::size_t>(problem.own_count())) return;
  refuse(motion.file,
         fmt::format("capture \"{}\" has {} values to compare for {} unknowns of its own; more were expected",
                     motion.id, count, problem.own_count()));
}

/// The first frames of the segments, among those with something to compare.
std::vector<Eigen::Index> segment_starts(const Capture& capture, const std::vector<Eigen::Index>& frames,
                                         double length) {
  const double begin = capture.times[frames.front()];
  const double duration = capture.times[frames.back()] - begin;
  const auto most = static_cast<double>(frames.size());
  const auto count = static_cast<int>(std::clamp(std::round(duration / length), 1.0, most));
  std::vector<Eigen::Index> starts = {frames.front()};
  for (int k = 1; k < count; ++k) {
    const double wanted = begin + duration * k / count;
    const auto nearest = std::ranges::min_element(
        frames, {}, [&](Eigen::Index frame) { return std::abs(capture.times[frame] - wanted); });
    if (*nearest > starts.back() && *nearest < frames.back()) starts.push_back(*nearest);
  }
  return starts;
}

void add_motion(const models::FamilyInfo& family, const Capture& capture, const FitOptions& options,
                FitProblem& problem) {
  const Frames frames(problem, capture);
  std::vector<Eigen::Index> seen;
  for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
    if (frames.has_something(frame)) seen.push_back(frame);
  }
  std::vector<Eigen::Index> starts;
  if (options.segments.length && !seen.empty()) {
    check_increase(capture, seen);
    starts = segment_starts(capture, seen, *options.segments.length);
  }

  Motion motion{.id = capture.id,
                .file = capture.file,
                .checksum = capture.checksum,
                .whole = capture.motion.empty() ? capture.id : capture.motion,
                .labels = capture.labels,
                .notes = capture.notes,
                .known = known_values(family, capture, options),
                .first_segment = problem.segments.size(),
                .segment_count = std::max<std::size_t>(1, starts.size())};
  for (std::size_t k = 0; k < motion.segment_count; ++k) {
    Segment segment{.motion = static_cast<int>(problem.motions.size())};
    segment.joined = k + 1 < motion.segment_count;
    if (!starts.empty()) segment.start = capture.times[starts[k]];
    if (options.compared.averaged_frames > 1 && capture.times.size() > 1) {
      segment.interval = median_interval(capture.times);
      segment.lead = 0.5 * (options.compared.averaged_frames - 1) * segment.interval;
    }
    // Where motions are cut, every segment starts early enough for its first frame.
    if (!starts.empty()) segment.lead += std::max(0.0, -delay_range(problem, motion).lower);
    segment.start -= segment.lead;
    for (const Eigen::Index frame : seen) {
      const bool before = !starts.empty() && frame < starts[k];
      const bool after = segment.joined && frame >= starts[k + 1];
      if (!before && !after) frames.add(frame, segment);
    }
    if (segment.joined) {
      // The next one's state is before its first frame by as much as this one's.
      segment.times.push_back(capture.times[starts[k + 1]] - capture.times[starts[k]]);
    }
    check_start(family, motion, segment);
    check_times(family, problem, motion, segment);
    problem.segments.push_back(std::move(segment));
  }
  check_size(problem, motion);
  problem.motions.push_back(std::move(motion));
}

/// Segments of as many frames, equally far apart, take the times of the first of them to the last bit: rounding alone
/// tells them apart, and families prepare what belongs to the same times once.
void share_times(std::vector<Segment>& segments, std::size_t first) {
  // Of the duration: far above rounding, and no motion shows it.
  constexpr double kSameShare = 1e-9;
  for (std::size_t k = first; k < segments.size(); ++k) {
    const auto same_times = [&](const Segment& other) {
      const auto same = [&](double a, double b) {
        return std::abs(a - b) <= kSameShare * other.times.back();
      };
      return std::ranges::equal(segments[k].times, other.times, same);
    };
    const auto end = segments.begin() + static_cast<std::ptrdiff_t>(k);
    const auto like = std::find_if(segments.begin(), end, same_times);
    if (like != end) segments[k].times = like->times;
  }
}

/// How far a value lies outside the interval; on a circle, the nearest of its places counts.
double outside(double value, const models::FamilyCoordinate& box, double period) {
  const double middle = 0.5 * (box.lower + box.upper);
  const double from_middle = period > 0.0 ? std::remainder(value - middle, period) : value - middle;
  return std::abs(from_middle) - 0.5 * (box.upper - box.lower);
}

/// Whether the first frame is more than an interval of frames later than the state.
bool begins_late(const Segment& segment) {
  const std::vector<double>& t = segment.times;
  const double interval = (t.back() - t.front()) / static_cast<double>(t.size());
  return t.front() > segment.lead + interval;
}

/// Start states that were measured must be possible: all of a segment's first frames outside the box are no
/// noise. With a delay the start is not at the first frame, nor in a segment whose frames begin later, and with a gain
/// it is not what was measured.
void check_boxes(const FitProblem& problem, const Motion& motion) {
  if (problem.delay) return;
  constexpr int kFrames = 3;
  constexpr double kScales = 5.0;
  for (const models::FamilyCoordinate& own : problem.own) {
    const auto output = std::ranges::find_if(problem.outputs, [&](const ComparedOutput& o) {
      return own.is_initial && !o.offset && !o.gain && own.name == fmt::format("{}(0)", o.name);
    });
    if (output == problem.outputs.end()) continue;
    const auto index = static_cast<int>(output - problem.outputs.begin());
    const double margin = std::min(kScales * output->scale, own.upper - own.lower);
    for (std::size_t k = 0; k < motion.segment_count; ++k) {
      const Segment& segment = problem.segments[motion.first_segment + k];
      if (segment.times.empty() || begins_late(segment)) continue;
      int seen = 0;
      bool any_inside = false;
      for (const Observation& o : segment.observations) {
        if (o.output != index || seen == kFrames) continue;
        ++seen;
        any_inside = any_inside || outside(o.value, own, output->period) <= margin;
      }
      if (seen < kFrames || any_inside) continue;
      const auto first = std::ranges::find(segment.observations, index, &Observation::output);
      refuse(
          motion.file,
          fmt::format("capture \"{}\" has {} = {} at {} s, but the box of \"{}\" goes from {} to {}; one "
                      "that holds what was measured was expected",
                      motion.id, output->name, first->value, segment.start, own.name, own.lower, own.upper));
    }
  }
}

/// So many steps would take days: a unit is wrong.
void check_steps(const FitProblem& problem, double step) {
  constexpr double kMostSteps = 1e7;
  double seconds = 0.0;
  for (const Segment& segment : problem.segments) {
    if (!segment.times.empty()) seconds += segment.times.back();
  }
  if (seconds / step <= kMostSteps) return;
  throw ArgumentError(
      fmt::format("step: the captures last {:.4g} s, which takes {:.3g} steps of {:.4g} s in each iteration; "
                  "at most {:.0e} were expected: are times or step in another unit?",
                  seconds, seconds / step, step, kMostSteps));
}

/// "flight 98", or the capture that is a cluster of its own.
std::string cluster_name(const std::vector<std::string>& cluster_by, const Motion& motion) {
  if (cluster_by.empty()) return motion.whole;
  std::vector<std::string> parts;
  for (const std::string& label : cluster_by)
    parts.push_back(fmt::format("{} {}", label, motion.labels.at(label)));
  return join(parts);
}

/// Tells clusters apart.
std::vector<std::string> cluster_key(const std::string& id, const std::string& file,
                                     const std::map<std::string, std::string>& labels,
                                     const std::vector<std::string>& cluster_by) {
  if (cluster_by.empty()) return {file, id};
  std::vector<std::string> key;
  for (const std::string& label : cluster_by) {
    const auto found = labels.find(label);
    if (found == labels.end()) {
      std::vector<std::string> known;
      for (const auto& [name, value] : labels) known.push_back(name);
      throw ArgumentError(fmt::format("cluster_by: capture \"{}\" has no label \"{}\"{}", id, label,
                                      known.empty() ? "; it has none" : suggestion(label, known)));
    }
    key.push_back(found->second);
  }
  return key;
}

/// In the order in which they appear.
std::vector<int> numbered(const std::vector<std::vector<std::string>>& keys) {
  std::map<std::vector<std::string>, int> places;
  std::vector<int> numbers;
  for (const auto& key : keys)
    numbers.push_back(places.try_emplace(key, static_cast<int>(places.size())).first->second);
  return numbers;
}

void find_clusters(const std::vector<std::string>& cluster_by, FitProblem& problem) {
  std::vector<std::vector<std::string>> keys;
  for (const Motion& motion : problem.motions)
    keys.push_back(cluster_key(motion.whole, motion.file, motion.labels, cluster_by));
  const std::vector<int> clusters = numbered(keys);
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    problem.motions[k].cluster = clusters[k];
    if (clusters[k] < problem.cluster_count) continue;
    problem.cluster_count = clusters[k] + 1;
    problem.cluster_names.push_back(cluster_name(cluster_by, problem.motions[k]));
  }
}

/// Whether it does not matter to which time the value of a state belongs.
bool is_any_time(const models::FamilyInfo& family, const std::string& state, const FitOptions& options) {
  const auto& offsets = options.unknowns.offsets;
  if (std::ranges::count(family.translations, state) > 0 && (!offsets || contains(*offsets, state)))
    return true;
  const auto output = std::ranges::find(family.outputs, state, &models::FamilyOutput::name);
  const bool is_rate = output != family.outputs.end() && (output->unit == "rad/s" || output->unit == "1/s");
  return options.starts.round_body && is_rate;
}

/// Initial values of which something is known, and what, in words.
std::map<std::string, std::string> known_starts(const models::FamilyInfo& family, const FitOptions& options) {
  constexpr std::string_view kInitial = "(0)";
  std::map<std::string, std::string> found;
  const auto add = [&](const std::string& name, const std::string& what) {
    if (name.ends_with(kInitial)) found.emplace(name, what);
  };
  const auto add_held = [&](const std::string& name, const std::string& what) {
    if (!is_any_time(family, name.substr(0, name.size() - std::min(name.size(), kInitial.size())), options))
      add(name, what);
  };
  for (const auto& held : {options.unknowns.fixed, family.fixed}) {
    for (const auto& [name, value] : held) add_held(name, fmt::format("is fixed at {:.6g}", value));
  }
  for (const auto& [name, known] : options.unknowns.known) add_held(name, "is known of each capture");
  for (const std::string& name : options.unknowns.shared) add(name, "is one for all captures");
  for (const auto& [name, prior] : options.priors.coordinates) {
    if (!options.unknowns.known.contains(name)) add(name, "has a prior");
  }
  return found;
}

}  // namespace

Warnings warnings_of_early_starts(const models::FamilyInfo& family, std::span<const Capture> captures,
                                  const FitOptions& options) {
  Warnings warnings;
  if (options.compared.averaged_frames == 1) return warnings;
  std::set<double> leads;
  for (const Capture& capture : captures) {
    if (capture.times.size() > 1)
      leads.insert(0.5 * (options.compared.averaged_frames - 1) * median_interval(capture.times));
  }
  if (leads.empty()) return warnings;
  std::string before = fmt::format("{:.3g}", *leads.begin());
  const std::string most = fmt::format("{:.3g}", *leads.rbegin());
  if (most != before) before += " to " + most;
  for (const auto& [name, what] : known_starts(family, options)) {
    warnings.add(WarningKind::model,
                 fmt::format("{} {}: since frames are means of {}, it is taken for the value {} s before the "
                             "first frame",
                             name, what, options.compared.averaged_frames, before));
  }
  return warnings;
}

void add_segments(const models::FamilyInfo& family, std::span<const Capture> captures,
                  const FitOptions& options, FitProblem& problem) {
  refuse_repeated(captures, "given");
  std::set<std::string> in_memory;
  for (const Capture& capture : captures) {
    if (capture.file.empty() && !in_memory.insert(capture.id).second)
      throw ArgumentError(fmt::format("capture \"{}\" is given twice; each once was expected", capture.id));
    add_motion(family, options.compared.span ? first(capture, *options.compared.span) : capture, options,
               problem);
    share_times(problem.segments, problem.motions.back().first_segment);
    check_boxes(problem, problem.motions.back());
  }
  if (options.solver.step) check_steps(problem, *options.solver.step);
  find_clusters(options.uncertainty.cluster_by, problem);
}

const Channel& compared_channel(const Capture& capture, const std::string& name, const std::string& unit) {
  if (!capture.has(name)) {
    std::vector<std::string> known;
    for (const Channel& candidate : capture.channels) known.push_back(candidate.quantity);
    refuse(capture.file, fmt::format("capture \"{}\" does not measure \"{}\"{}", capture.id, name,
                                     suggestion(name, known)));
  }
  const Channel& channel = capture.channel(name);
  if (!same_dimension(channel.unit, unit)) {
    refuse(capture.file,
           fmt::format("capture \"{}\" measures \"{}\" in {}; {} was expected{}", capture.id, name,
                       channel.unit, unit, channel.unit == "px" ? ", from a [scale] in its sidecar" : ""));
  }
  if (channel.values.size() != capture.times.size()) {
    refuse(capture.file,
           fmt::format("capture \"{}\" has {} values of \"{}\"; one for each of its {} frames was expected",
                       capture.id, channel.values.size(), name, capture.times.size()));
  }
  if (channel.values.array().isInf().any()) {
    refuse(capture.file,
           fmt::format("capture \"{}\" has an infinite value of \"{}\"; finite numbers, or NaN for a "
                       "missing one, were expected",
                       capture.id, name));
  }
  return channel;
}

void check_capture(const Capture& capture, const FitProblem& problem) {
  const Frames measured(problem, capture);
}

std::vector<int> clusters_of(std::span<const Capture> captures, const std::vector<std::string>& cluster_by) {
  std::vector<std::vector<std::string>> keys;
  for (const Capture& capture : captures) {
    keys.push_back(cluster_key(capture.motion.empty() ? capture.id : capture.motion, capture.file,
                               capture.labels, cluster_by));
  }
  return numbered(keys);
}

}  // namespace samara::identification
