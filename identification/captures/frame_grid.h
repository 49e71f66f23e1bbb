#pragma once

#include <optional>

#include "samara/identification/captures/capture.h"

namespace samara::identification {

struct FrameGrid {
  Capture capture;             ///< its times are whole multiples of the period after the first
  double period = 0.0;         ///< s
  double rms_shift = 0.0;      ///< s, between times as given and on the grid
  double largest_shift = 0.0;  ///< s
  int dropped_frames = 0;      ///< places of the grid between frames that no frame holds
};

/// For a camera with a steady rate whose times are rounded, or are those at which a frame arrived: the frame
/// period is fitted to the times of the capture, and each frame set to its place on the grid.
///
/// The period is the one for which exp(2 pi i t / period) adds up best over the frames, within 3 % of the median
/// interval; each frame then takes the place that is nearest, such that places increase (isotonic regression), and
/// the grid is fitted to them by least squares. A single place that the clock leaves free is closed where the body
/// (x, y, z in m) moved on as in one interval, and evenly before and after: later frames came late. Where
/// they stay late by a whole period, the clock jumped, and the period is that of the frames on each side of the jump.
/// Longer gaps stay.
///
/// Times of n frames that are rounded to r leave the fitted period an error of about r n^-1.5. Of few frames that is
/// much: all speeds and, twice as much, all accelerations are off by its share. Whoever knows the camera's period says
/// it.
/// @param known_period s, which is not fitted then
/// @throws ArgumentError if the capture has fewer than 4 frames, or times that do not increase or jump by more than ten
/// million intervals, and for a period that is not finite, not above 0, or
/// does not go into the common interval a whole number of times (within a tenth)
FrameGrid on_frame_grid(const Capture& capture, std::optional<double> known_period = {});

}  // namespace samara::identification
