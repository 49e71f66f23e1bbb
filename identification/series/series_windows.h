#pragma once

#include <span>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/identification/series/series_knots.h"
#include "samara/identification/trajectories/trajectory_source.h"

/// Internal to identification/.
namespace samara::identification {

/// The captures as a series sees them.
struct SeriesWindows {
  std::vector<Capture> captures;  ///< whole, if windows are joined; else one for each window
  SeriesKnots knots;
  double spacing = 0.0;  ///< s, between windows
  double overlap = 1.0;  ///< in how many windows a frame lies, in the mean
  int count = 0;
  bool joined = true;
};

/// @throws ArgumentError if windows are longer than half of the captures, or there are more than a fit can
///   hold.
SeriesWindows series_windows(std::span<const Capture> captures, const FitOptions& options,
                             const SeriesOptions& series);

/// For windows that slide: what is said of the start of a capture holds for none of them but the first.
/// @param windows not joined  @param options of the windows
/// @throws ArgumentError if a state is not free in each window (what the motion does not depend on may have
/// an
///   offset instead, or not be compared), for other coordinates of each capture, priors of initial values,
///   and a camera.
void check_sliding(const FamilyInfo& family, const SeriesWindows& windows, const FitOptions& options);

}  // namespace samara::identification
