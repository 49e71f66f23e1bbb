#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/motion/patterns/agreement.h"
#include "samara/motion/patterns/pattern_rules.h"

/// A person's labels of parts of captures, and how far the rule agrees with them.
namespace samara::motion {

struct LabelledSegment {
  std::string capture;  ///< its id, or the part of it before or after a slash, if that is of one only
  Eigen::Index first = 0, last = 0;  ///< frames of the capture, from 0, both of the segment
  std::string label;                 ///< the person's word
  std::string file = {};             ///< of labels that were read; empty if made in memory
  int line = 0;                      ///< there

  Eigen::Index frame_count() const { return last - first + 1; }
};

/// Which patterns a person's word stands for.
using PatternClasses = std::map<std::string, std::vector<Pattern>>;

/// "tumbling=autorotation", "3=steady+zigzag". @throws ArgumentError for another form, an unknown pattern, or one that
/// two words stand for
PatternClasses pattern_classes(const std::vector<std::string>& texts);

/// A table with the columns capture (or traj), first_frame, last_frame and label (or human).
/// @param classes words that may stand there; empty: the names of patterns
/// @throws InputError, with the line, for columns that are missing, frames that are no whole numbers or do not
/// increase, a word that stands for nothing.
std::vector<LabelledSegment> read_labelled_segments(const std::filesystem::path& path,
                                                    const PatternClasses& classes = {});

struct SegmentAgreement {
  std::vector<std::string> words;    ///< of the person, and "other": what the rule calls by none of these
  Agreement agreement;               ///< by these
  std::vector<PatternLabel> labels;  ///< of the rule, per segment
};

/// The rule on each segment by itself, without settling time.
/// @param length m, of the body; 0: not known
/// @throws InputError with the line of a segment that was read, of others ArgumentError: for one of an
/// unknown capture (the nearest is named), of several, or beyond its frames, and for a word that stands for
/// nothing; as record_of() of a capture; ArgumentError for a pattern that two words stand for.
SegmentAgreement compare(const std::vector<LabelledSegment>& segments,
                         const std::vector<identification::Capture>& captures,
                         const PatternClasses& classes = {}, double length = 0.0,
                         const PatternThresholds& thresholds = {});

/// The rule on one segment; unresolved if it has fewer than kFewestFrames.
PatternLabel label_of(const LabelledSegment& segment, const std::vector<identification::Capture>& captures,
                      double length = 0.0, const PatternThresholds& thresholds = {});

/// The frames of a segment as a record. @throws as compare()
MotionRecord record_of(const LabelledSegment& segment, const std::vector<identification::Capture>& captures,
                       double length = 0.0);

}  // namespace samara::motion
