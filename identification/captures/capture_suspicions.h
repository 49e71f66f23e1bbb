#pragma once

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "samara/identification/captures/capture.h"

namespace samara::identification {

// clang-format off
/// What looks wrong with a capture, as sentences for a report. None is an error: a capture may be strange and
/// right. Looked for are
///  - few frames, or frames that see little; values that are infinite;
///  - times that do not increase, are not finite, or whose intervals (above 1 s, below 10 us) suggest another
///    unit;
///  - gaps;
///  - positions and angles that never change;
///  - positions that have nothing to do with those before them: rows out of order;
///  - positions whose steps are faster than sound in air, whose acceleration is most of the time above 5 g,
///    or is g times a power of ten (where it is less than g, and stays so: drag makes it fade), or that move by
///    less than 0.1 mm: another unit;
///  - a step much faster than the others: the track of another body, or a wrong frame;
///  - angles that turn by more than a right angle from frame to frame: degrees taken for radians, or a motion
///    that the frame rate cannot resolve;
///  - quaternions that are not of unit length.
/// Positions are x, y, z in m; angles are theta, phi, psi, roll, pitch, yaw in rad. Other quantities may be
/// constant, or jump.
/// @throws as check_sizes()
// clang-format on
std::vector<std::string> suspicions(const Capture& capture, bool falls = true);

/// What is suspicious about captures, each sentence with the id of its capture. Sentences that differ in
/// their numbers alone are said of the first capture, with the ids of the others.
/// @param falls whether a body of the model that is let go falls: one in balance accelerates by far
/// less than g, and its lengths are right
std::vector<std::string> suspicions_of_all(std::span<const Capture> captures, bool falls = true);

/// @param sentences each with the id of its capture
/// @returns them in this form
std::vector<std::string> merge_alike(const std::vector<std::pair<std::string, std::string>>& sentences);

}  // namespace samara::identification
