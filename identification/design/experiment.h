#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/design/design.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/known_so_far.h"

/// Internal to identification/: one capture more as the next fit will see it, with all names resolved.
namespace samara::identification {

/// One kind of what is seen.
struct SeenOutput {
  std::string name = {};  ///< of the output, or "attitude"
  std::string unit = {};
  double noise = 0.0;  ///< standard deviation, SI
};

struct Experiment {
  /// Of the next fit: outputs over their noise, which is raised by KnownSoFar::inflation.
  FitOptions options = {};
  Capture capture = {};  ///< its times and channels; values mean nothing
  std::vector<SeenOutput> outputs = {};
  /// Each capture's own ones first, then known ones, both in the order of the fit's problem.
  std::vector<ReleaseCoordinate> coordinates = {};
  std::size_t own_count = 0;
  double duration = 0.0;  ///< s
  int frames = 0;
};

/// Whether a fit can be gone on with: what is wrong here is wrong with the fit, not with what is asked of it.
/// @throws ArgumentError as design_experiment()
void check_fitted(const models::FamilyInfo& family, const FitResult& fitted);

/// @throws ArgumentError as design_experiment()
Experiment make_experiment(const models::TrajectoryFamily& family, const FitResult& fitted,
                           const KnownSoFar& known, const DesignOptions& options);

}  // namespace samara::identification
