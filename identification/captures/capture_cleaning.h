#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/smoothing.h"

/// Cleaning captures before a fit. Every step returns a new capture and says what it did: as numbers,
/// and as a sentence in `capture.notes`.
///
/// A flight of a ball that bounces, with rounded times:
///
///     Capture flight = on_frame_grid(capture).capture;
///     flight = before_impact(flight, {.jump = 1.2}).capture;
///     flight = without_outliers(flight, {.bandwidth = 0.1}).capture;
///
/// An impact comes before outliers: frames beside a bounce are outliers of every smooth curve.
namespace samara::identification {

/// A stretch without frames, or without a seen quantity.
struct Gap {
  double begin = 0.0;  ///< s, the last frame before it
  double end = 0.0;    ///< s, the first frame after it
  long missing = 0;    ///< frames, by the median interval; 10^18 at most
};

/// Intervals between seen frames that are longer than 1.5 median intervals.
/// @param quantity a channel; empty: any
/// @throws ArgumentError if there is no such channel
std::vector<Gap> gaps(const Capture& capture, const std::string& quantity = "");

struct PartOptions {
  std::vector<std::string> quantities = {"x", "y", "z"};  ///< positions that count
  double longest_gap = 0.1;                               ///< s between frames in which all of them are seen
  double fastest = 0.0;                                   ///< m/s from one such frame to the next; 0: any
  int least_frames = 8;
};

/// The parts of a capture without gaps and without jumps (a tracker that went on with another body), in
/// order. They keep the times of the capture, and its id with "#1", "#2", ... where there are several.
/// @throws ArgumentError if a quantity is not measured, or an option is out of its range
std::vector<Capture> continuous_parts(const Capture& capture, const PartOptions& options = {});

/// The channels of an attitude: all four are set to NaN together.
inline const std::vector<std::string> kQuaternionChannels = {"qw", "qx", "qy", "qz"};

struct WithoutOutliers {
  Capture capture;  ///< outliers are NaN
  /// Frames of each quantity ("attitude" for a quaternion) that were taken out; none: not listed.
  std::map<std::string, std::vector<int>> frames;
};

/// Replaces values that lie far from their neighbours by NaN: see smoothing.h. Quantities seen in too few
/// frames to tell are left alone.
/// @param periods of angles, by quantity, rad: such a channel is unwrapped to be judged, and stays as it is
WithoutOutliers without_outliers(const Capture& capture, const SmoothingOptions& options = {},
                                 const std::map<std::string, double>& periods = {});

}  // namespace samara::identification
