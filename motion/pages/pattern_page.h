#pragma once

#include <optional>
#include <string>
#include <vector>

#include "samara/motion/patterns/disc_phase_diagram.h"
#include "samara/motion/sweeps/sweep.h"

/// The page for the browser that `samara patterns --report` writes, complete in one file: the diagram of Re and I* with
/// its boundaries and the body, slices of the pattern map, any two features against each other, which pattern follows
/// which, with intervals; tables beside, patterns by shape and colour. It holds its data, style, scripts and the
/// charts' library (uPlot, MIT), loads nothing, and forbids itself the network. What came from files is only ever
/// shown as text. Of the measured discs it shows where they were, and the boundaries between them: the points
/// themselves are not ours to give.
namespace samara::motion {

/// Most falls whose features, and most points whose Re and I*, a page holds; of more it draws so many, and says so.
inline constexpr long kMostShownFalls = 4000, kMostShownBodies = 400;

/// Of a sweep. Probabilities are those of PatternMap; which pattern follows which is known where the sweep keeps
/// trajectories.
std::string pattern_html(const Sweep& sweep);

/// A capture and what its windows are called.
struct LabelledMotion {
  std::string id;
  MotionRecord record;
  std::vector<LabelledWindow> windows;
};

/// Of captures. @param body in the diagram, if it is known
std::string pattern_html(const std::vector<LabelledMotion>& motions, const PatternThresholds& thresholds,
                         const std::optional<FallNumbers>& body = {});

/// The sequence of patterns of each fall whose trajectory a sweep keeps. @throws InputError if its plan cannot be read
std::vector<std::vector<Pattern>> kept_sequences(const Sweep& sweep);

}  // namespace samara::motion
