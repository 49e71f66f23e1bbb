#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "samara/motion/patterns/features.h"

/// Patterns of falling: rules on named features.
///
///   const PatternLabel label = motion::label(motion::features(record));
///   label.pattern, label.margin, label.why        // zigzag, 0.6, "2 half turns over ..."
///
/// In this order: unresolved (fewer than 3 swings, noise that hides the answer, too few frames for its turns); steady
/// (tilt); spiral and helix (revolutions of the place); zigzag (hardly a half turn); autorotation (half turns the same
/// way); chaotic (neighbours part, or the path does not come back to itself); mixed, if nothing fits, such as a
/// periodic motion with full turns between swings. From positions alone, sway stands for the tilt and reversals of
/// the horizontal velocity for half turns; autorotation walks straight on.
///
/// Evidence, and what the rule confuses: docs/explanation/pattern_names.md.
namespace samara::motion {

enum class Pattern { steady, zigzag, autorotation, chaotic, spiral, helix, mixed, unresolved };

inline constexpr std::size_t kPatterns = 8;

/// In the order of Pattern.
const std::vector<std::string>& pattern_names();
std::string to_string(Pattern pattern);
/// @throws ArgumentError naming the nearest.
Pattern pattern_of(std::string_view name);

/// Of what a record shows: in a plane, in space, or positions alone.
struct PatternThresholds {
  double fewest_swings = 3.0;
  double noise_factor = 3.0;    ///< a signal that noise alone could take for another must be so much larger
  double steady_tilt = 0.2;     ///< rad
  double steady_sway = 0.1;     ///< positions alone
  double steady_lengths = 3.0;  ///< fewest lengths of the body fallen in the settled part, of steady descent
  double frame_angle = 1.05;    ///< rad, most between two frames
  double winding = 0.8, turns = 1.2, wobble = 0.13;
  double straightness = 0.9;  ///< positions alone: of autorotation, which walks onward
  double flips_plane = 1.5, flips_space = 2.5, veers = 2.5;
  double coherence_plane = 0.75, coherence_space = 0.8;
  double recurrence_plane = 0.3, recurrence_space = 0.35, recurrence_positions = 0.35;
  double spread = 0.03;  ///< where it is known it overrules recurrence
};

/// One threshold by its name.
struct NamedThreshold {
  std::string name;
  double PatternThresholds::*value;
};
const std::vector<NamedThreshold>& named_thresholds();
/// @throws ArgumentError for an unknown name (the nearest is named), or a value that is not positive and finite.
void set_threshold(PatternThresholds& thresholds, const std::string& name, double value);

struct PatternLabel {
  Pattern pattern = Pattern::unresolved;
  /// Distance to the nearest threshold that was asked, over that threshold: 0 at the border.
  double margin = 0.0;
  std::string why;  ///< in one phrase, with the deciding number
};

PatternLabel label(const Features& features, const PatternThresholds& thresholds = {});

/// Part of a fall with one label.
struct LabelledWindow {
  double from = 0.0, to = 0.0;  ///< s
  PatternLabel label;           ///< that of the first of the windows that were merged, with the least margin
  int windows = 1;              ///< merged
};

struct WindowOptions {
  double swings = 4.0;   ///< of a window; whole ones are taken
  double overlap = 0.5;  ///< of neighbours, a share
};

/// A fall as a sequence of patterns: windows of some swings that overlap, equal neighbours merged. The pattern of the
/// fall is its last. One window where the record is shorter, or has no swings; one that is unresolved where frames
/// are missing for too long (long_gap() of even_frames.h).
/// @throws ArgumentError as check() of the record, and for options outside their meaning.
std::vector<LabelledWindow> label_windows(const MotionRecord& record, const WindowOptions& options = {},
                                          const PatternThresholds& thresholds = {});

}  // namespace samara::motion
