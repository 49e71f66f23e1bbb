#include "samara/identification/segments.h"

#include <cmath>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/units.h"

namespace samara::identification {

namespace {

/// What is wrong with a capture is wrong with the file it came from, if it came from one.
[[noreturn]] void refuse(const std::string& file, const std::string& sentence) {
  if (file.empty()) throw ArgumentError(sentence);
  throw InputError(file, sentence);
}

/// The channels of the compared outputs, in their order and units.
std::vector<const Channel*> compared_channels(const FitProblem& problem, const Capture& capture) {
  std::vector<const Channel*> channels;
  for (const ComparedOutput& output : problem.outputs) {
    if (!capture.has(output.name)) {
      std::vector<std::string> known;
      for (const Channel& candidate : capture.channels) known.push_back(candidate.quantity);
      refuse(capture.file, fmt::format("capture \"{}\" does not measure \"{}\"{}", capture.id, output.name,
                                       suggestion(output.name, known)));
    }
    const Channel& channel = capture.channel(output.name);
    if (!io::same_dimension(channel.unit, output.unit)) {
      refuse(capture.file, fmt::format("capture \"{}\" measures \"{}\" in {}; {} was expected{}", capture.id,
                                       output.name, channel.unit, output.unit,
                                       channel.unit == "px" ? ", from a [scale] in its sidecar" : ""));
    }
    if (channel.values.size() != capture.times.size()) {
      refuse(capture.file,
             fmt::format("capture \"{}\" has {} values of \"{}\"; one for each of its {} frames was expected",
                         capture.id, channel.values.size(), output.name, capture.times.size()));
    }
    if (channel.values.array().isInf().any()) {
      refuse(capture.file,
             fmt::format("capture \"{}\" has an infinite value of \"{}\"; finite numbers, or NaN for a "
                         "missing one, were expected",
                         capture.id, output.name));
    }
    channels.push_back(&channel);
  }
  return channels;
}

Segment make_segment(const FitProblem& problem, const Capture& capture) {
  Segment segment{capture.id, capture.file, capture.labels, 0, {}, {}};
  const std::vector<const Channel*> channels = compared_channels(problem, capture);
  for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
    const auto place = static_cast<int>(segment.times.size());
    const std::size_t before = segment.observations.size();
    for (std::size_t o = 0; o < channels.size(); ++o) {
      const double value = channels[o]->values[frame];
      if (!std::isnan(value)) segment.observations.push_back({place, static_cast<int>(o), value});
    }
    if (segment.observations.size() > before) segment.times.push_back(capture.times[frame]);
  }
  return segment;
}

void check_times(const FamilyInfo& family, Segment& segment) {
  double previous = 0.0;
  for (const double time : segment.times) {
    if (!(time >= previous)) {
      refuse(segment.file,
             fmt::format("capture \"{}\" has a frame at {} s; times that begin at 0 or later and do not "
                         "decrease were expected",
                         segment.id, time));
    }
    previous = time;
  }
  if (previous <= family.end_time) return;
  // Rounding may put a frame on the border just behind it, as in first().
  const double interval = previous / static_cast<double>(segment.times.size());
  if (previous > family.end_time + 1e-3 * interval) {
    refuse(segment.file,
           fmt::format("capture \"{}\" lasts {} s, but the {} ends at {} s; a `window` of at most that was "
                       "expected",
                       segment.id, previous, family.source, family.end_time));
  }
  segment.times.back() = family.end_time;
}

void check_size(const FitProblem& problem, const Segment& segment) {
  if (segment.observations.size() > static_cast<std::size_t>(problem.own_count())) return;
  refuse(segment.file,
         fmt::format("capture \"{}\" has {} values to compare for {} unknowns of its own; more were expected",
                     segment.id, segment.observations.size(), problem.own_count()));
}

/// Numbers the clusters in the order in which they appear.
void find_clusters(const std::vector<std::string>& cluster_by, FitProblem& problem) {
  std::map<std::vector<std::string>, int> clusters;
  for (Segment& segment : problem.segments) {
    std::vector<std::string> key;
    for (const std::string& label : cluster_by) {
      const auto found = segment.labels.find(label);
      if (found == segment.labels.end()) {
        std::vector<std::string> known;
        for (const auto& [name, value] : segment.labels) known.push_back(name);
        throw ArgumentError(fmt::format("cluster_by: capture \"{}\" has no label \"{}\"{}", segment.id, label,
                                        known.empty() ? "; it has none" : suggestion(label, known)));
      }
      key.push_back(found->second);
    }
    if (cluster_by.empty()) key = {segment.file, segment.id};
    segment.cluster = clusters.try_emplace(key, static_cast<int>(clusters.size())).first->second;
  }
  problem.cluster_count = static_cast<int>(clusters.size());
}

}  // namespace

void add_segments(const FamilyInfo& family, std::span<const Capture> captures, const FitOptions& options,
                  FitProblem& problem) {
  std::set<std::pair<std::string, std::string>> seen;
  for (const Capture& capture : captures) {
    if (!seen.insert({capture.file, capture.id}).second) {
      throw ArgumentError(fmt::format("capture \"{}\" of \"{}\" is given twice", capture.id, capture.file));
    }
    problem.segments.push_back(
        make_segment(problem, options.window ? first(capture, *options.window) : capture));
    check_times(family, problem.segments.back());
    check_size(problem, problem.segments.back());
  }
  find_clusters(options.cluster_by, problem);
}

}  // namespace samara::identification
