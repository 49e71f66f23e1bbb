#pragma once

#include <span>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/series/coefficient_series.h"
#include "samara/identification/series/series_knots.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to identification/.
namespace samara::identification {

/// The captures as a series sees them.
struct SeriesSpans {
  std::vector<Capture> captures;  ///< whole, if spans are joined; else one for each span
  SeriesKnots knots;
  double spacing = 0.0;  ///< s, between spans
  double overlap = 1.0;  ///< in how many spans a frame lies, in the mean
  int count = 0;
  bool joined = true;
};

/// @throws ArgumentError if spans are longer than half of the captures, or there are more than a fit can
///   hold.
SeriesSpans series_spans(std::span<const Capture> captures, const FitOptions& options,
                         const SeriesOptions& series);

/// For spans that slide: what is said of the start of a capture holds for none of them but the first.
/// @param spans not joined
/// @param options of the spans
/// @throws ArgumentError if a state is not free in each span (what the motion does not depend on may have an
///   offset instead, or not be compared), for other coordinates of each capture, priors of initial values,
///   and a camera.
void check_sliding(const models::FamilyInfo& family, const SeriesSpans& spans, const FitOptions& options);

}  // namespace samara::identification
