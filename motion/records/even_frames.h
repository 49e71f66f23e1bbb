#pragma once

#include <optional>

#include "samara/motion/records/motion_record.h"

namespace samara::motion {

/// Longest gap that is bridged, in frames.
inline constexpr Eigen::Index kLongestGap = 10;

/// The record with frames put in where some are missing, between those beside a gap by straight lines, so that frame
/// numbers measure time: what counts frames (noise, recurrence) asks for it. None where nothing is missing: all
/// intervals are below 1.5 times their median.
/// @throws ArgumentError naming a gap of more than kLongestGap frames: how a body moved there nobody knows.
std::optional<MotionRecord> bridged(const MotionRecord& record);

}  // namespace samara::motion
