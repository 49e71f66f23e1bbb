#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"

namespace samara::identification {

struct ImpactOptions {
  /// Positions that count.
  std::vector<std::string> quantities = {"x", "y", "z"};
  /// Acceleration that is no impact, by quantity, m/s^2.
  std::map<std::string, double> gravity = {{"z", -9.81}};
  double jump = 1.2;  ///< m/s, of the velocity from one frame to the next
};

struct BeforeImpact {
  Capture capture;                         ///< the frames before it; all if there was none
  std::optional<double> impact_time = {};  ///< s, between the frames where the velocity jumps most
  double jump = 0.0;                       ///< m/s, there; the largest of all if there was no impact
};

/// Cuts a capture before its first impact: where the slope of four frames differs from that of the next four,
/// gravity removed, by more than a jump, whichever one of the eight frames is left out (so that one wrong
/// frame is no impact), and whether or not frames are missing among them (nor is a frame that rounded times seem
/// to lack). The frame just before the impact goes, too: it may be the moment of contact.
/// @throws ArgumentError if a quantity is not measured, or fewer than 3 frames are left
BeforeImpact before_impact(const Capture& capture, const ImpactOptions& options = {});

/// The frames before the first in which a quantity lies outside an interval (of its unit): a body that comes
/// near the floor. A frame in which it was not seen lies inside.
/// @throws ArgumentError if it is not measured, or fewer than 3 frames are left
Capture while_inside(const Capture& capture, const std::string& quantity, double lower, double upper);

}  // namespace samara::identification
