#include "samara/motion/patterns/labelled_segments.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/delimited_table.h"
#include "samara/motion/records/even_frames.h"

namespace samara::motion {

namespace {

using identification::Capture;

/// Each pattern by its own name.
PatternClasses own_names() {
  PatternClasses classes;
  for (const std::string& name : pattern_names()) classes[name] = {pattern_of(name)};
  return classes;
}

/// The rule's answer is one word.
void require_one_word_each(const PatternClasses& classes) {
  std::map<Pattern, std::string> words;
  for (const auto& [word, patterns] : classes) {
    for (const Pattern pattern : patterns) {
      const auto [first, is_new] = words.try_emplace(pattern, word);
      if (!is_new && first->second != word)
        throw ArgumentError(fmt::format("the pattern {} is given to \"{}\" and to \"{}\", expected one word",
                                        to_string(pattern), first->second, word));
    }
  }
}

/// Before or after a slash.
bool is_part_of_id(const Capture& capture, const std::string& name) {
  return capture.id.ends_with("/" + name) || capture.id.starts_with(name + "/");
}

/// What is wrong with a segment is wrong with the line it came from, if it came from one.
[[noreturn]] void refuse_segment(const LabelledSegment& segment, const std::string& sentence) {
  if (segment.file.empty()) throw ArgumentError(sentence);
  throw InputError(segment.file, segment.line, sentence);
}

std::string files_of(const std::vector<const Capture*>& captures) {
  std::vector<std::string> files;
  for (const Capture* capture : captures)
    files.push_back(capture->file.empty() ? "of no file" : capture->file);
  return join(files);
}

const Capture& capture_of(const LabelledSegment& segment, const std::vector<Capture>& captures) {
  std::vector<const Capture*> named, fitting;
  for (const Capture& capture : captures) {
    if (capture.id == segment.capture) named.push_back(&capture);
    if (is_part_of_id(capture, segment.capture)) fitting.push_back(&capture);
  }
  if (named.size() == 1) return *named.front();
  if (named.size() > 1) {
    refuse_segment(segment,
                   fmt::format("labels name the capture \"{}\", which {} captures are called ({}); one "
                               "was expected",
                               segment.capture, named.size(), files_of(named)));
  }
  if (fitting.size() == 1) return *fitting.front();
  if (fitting.size() > 1) {
    refuse_segment(segment, fmt::format("labels name the capture \"{}\", which may be \"{}\" or \"{}\"",
                                        segment.capture, fitting[0]->id, fitting[1]->id));
  }
  std::vector<std::string> known;
  for (const Capture& capture : captures) known.push_back(capture.id);
  // One that is near is named whichever it is; only where none is, a few stand for all.
  if (known.size() > 6 && nearest_name(segment.capture, known).empty()) known.resize(6);
  refuse_segment(segment, fmt::format("labels name the capture \"{}\", which is not among those given{}",
                                      segment.capture, suggestion(segment.capture, known)));
}

Eigen::Index frame_number(const io::DelimitedTable& table, std::size_t row, double value) {
  constexpr double kMost = 1e9;
  if (value >= 0.0 && value <= kMost && value == std::floor(value)) return static_cast<Eigen::Index>(value);
  throw table.error(row, fmt::format("has the frame {}, expected a whole number from 0 on", value));
}

}  // namespace

PatternClasses pattern_classes(const std::vector<std::string>& texts) {
  PatternClasses classes;
  for (const std::string& text : texts) {
    const std::size_t sign = text.find('=');
    if (sign == std::string::npos || sign == 0 || sign + 1 == text.size())
      throw ArgumentError(fmt::format("the class \"{}\" has no form WORD=PATTERN+PATTERN", text));
    std::vector<Pattern>& patterns = classes[text.substr(0, sign)];
    std::size_t from = sign + 1;
    while (from <= text.size()) {
      const std::size_t plus = std::min(text.find('+', from), text.size());
      patterns.push_back(pattern_of(text.substr(from, plus - from)));
      from = plus + 1;
    }
  }
  require_one_word_each(classes);
  return classes;
}

std::vector<LabelledSegment> read_labelled_segments(const std::filesystem::path& path,
                                                    const PatternClasses& classes) {
  const PatternClasses words = classes.empty() ? own_names() : classes;
  const io::DelimitedTable table = io::DelimitedTable::read(path);
  const auto captures = table.texts(table.has("traj") ? "traj" : "capture");
  const auto labels = table.texts(table.has("human") ? "human" : "label");
  const Eigen::VectorXd first = table.numbers("first_frame"), last = table.numbers("last_frame");
  std::vector<std::string> known;
  for (const auto& [word, patterns] : words) known.push_back(word);
  std::vector<LabelledSegment> segments;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const auto k = static_cast<Eigen::Index>(row);
    LabelledSegment segment = {captures[row],
                               frame_number(table, row, first[k]),
                               frame_number(table, row, last[k]),
                               labels[row],
                               table.file(),
                               table.line_of_row(row)};
    if (segment.last <= segment.first)
      throw table.error(row,
                        fmt::format("ends at frame {}, expected one after {}", segment.last, segment.first));
    if (!words.contains(segment.label))
      throw table.error(
          row, fmt::format("has the label \"{}\"{}", segment.label, suggestion(segment.label, known)));
    segments.push_back(std::move(segment));
  }
  if (segments.empty()) throw InputError(table.file(), "has no segments, expected at least one");
  return segments;
}

namespace {

/// The whole capture of a segment. @throws ArgumentError if it has no such frames
Capture checked_capture(const LabelledSegment& segment, const std::vector<Capture>& captures) {
  Capture capture = capture_of(segment, captures);
  if (segment.last >= capture.frame_count()) {
    refuse_segment(segment, fmt::format("a label of capture \"{}\" ends at frame {}, expected at most {}",
                                        capture.id, segment.last, capture.frame_count() - 1));
  }
  return capture;
}

}  // namespace

MotionRecord record_of(const LabelledSegment& segment, const std::vector<Capture>& captures, double length) {
  Capture capture = checked_capture(segment, captures);
  const Eigen::Index count = segment.frame_count();
  capture.times = capture.times.segment(segment.first, count).eval();
  for (identification::Channel& channel : capture.channels)
    channel.values = channel.values.segment(segment.first, count).eval();
  return record_of(capture, length);
}

PatternLabel label_of(const LabelledSegment& segment, const std::vector<Capture>& captures, double length,
                      const PatternThresholds& thresholds) {
  if (segment.frame_count() < kFewestFrames) {
    checked_capture(segment, captures);
    return {Pattern::unresolved, 0.0,
            fmt::format("{} frames, fewer than {}", segment.frame_count(), kFewestFrames)};
  }
  const MotionRecord record = record_of(segment, captures, length);
  if (const std::string gap = long_gap(record.times); !gap.empty()) return {Pattern::unresolved, 0.0, gap};
  return label(features(record, {.settle_share = 0.0}), thresholds);
}

SegmentAgreement compare(const std::vector<LabelledSegment>& segments, const std::vector<Capture>& captures,
                         const PatternClasses& classes, double length, const PatternThresholds& thresholds) {
  require_one_word_each(classes);
  const PatternClasses words = classes.empty() ? own_names() : classes;
  SegmentAgreement result;
  for (const auto& [word, patterns] : words) result.words.push_back(word);
  result.words.emplace_back("other");
  std::vector<int> truth, answer;
  const std::vector<std::string> known(result.words.begin(), result.words.end() - 1);
  for (const LabelledSegment& segment : segments) {
    if (!words.contains(segment.label))
      refuse_segment(segment, fmt::format("a label of capture \"{}\" is \"{}\", which stands for nothing{}",
                                          segment.capture, segment.label, suggestion(segment.label, known)));
    const PatternLabel label = label_of(segment, captures, length, thresholds);
    int theirs = 0, ours = static_cast<int>(words.size()), k = 0;
    for (const auto& [word, patterns] : words) {
      if (word == segment.label) theirs = k;
      if (std::ranges::find(patterns, label.pattern) != patterns.end()) ours = k;
      ++k;
    }
    truth.push_back(theirs);
    answer.push_back(ours);
    result.labels.push_back(label);
  }
  result.agreement = agreement(truth, answer, static_cast<int>(result.words.size()));
  return result;
}

}  // namespace samara::motion
