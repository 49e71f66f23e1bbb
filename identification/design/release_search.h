#pragma once

#include <vector>

#include "samara/identification/design/capture_evaluator.h"

/// Internal to identification/: where captures are to be released.
namespace samara::identification {

struct FoundReleases {
  std::vector<Release> releases = {};
  double random_error = 1.0;  ///< as Design::random_error
};

/// The steps of design.h: Sobol' points, added one by one, exchanged, and moved in turns.
/// @throws NoResultError if none of the points has a trajectory.
FoundReleases search_releases(CaptureEvaluator& evaluator, const Experiment& experiment,
                              const Precision& precision, const DesignOptions& options);

}  // namespace samara::identification
