#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "samara/models/batch/batch_tasks.h"
#include "samara/models/batch/lanes.h"
#include "samara/models/stochastic/ensemble.h"
#include "samara/models/stochastic/ensemble_sums.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::models {

/// What all realisations of an ensemble share.
struct RealisationPlan {
  ParametricModel model;  ///< with gusts of zero, which every kernel takes for given
  std::span<const double> point;
  const AirSource& air;
  std::vector<double> times;
  double step = 1e-3;
  std::optional<double> ground;
  bool antithetic = false;
  std::vector<int> states;  ///< whose statistics are kept
  GustLayout layout;
  Eigen::Matrix3d follows;  ///< BodyOnPath::follows, in body axes
};

/// What became of one realisation.
struct RealisationRecord {
  RealisationStatus status = RealisationStatus::flying;
  Landing landing;
  int half_turns = 0;
  /// World, from the start to the landing or the last time; empty: it came to neither.
  Eigen::VectorXd displacement;
  Eigen::MatrixXd chosen;  ///< times x chosen states; NaN after its end
  Eigen::MatrixXd all;     ///< times x states, where it is kept
};

/// What became of several.
struct FlownRealisations {
  std::vector<RealisationRecord> records;  ///< in order; empty if it was cancelled
  StepCounts steps;                        ///< of all
};

/// Flies realisations first to last - 1 side by side. Keeps the trajectories of those with numbers below `keep`.
FlownRealisations fly_realisations(const RealisationPlan& plan, long first, long last, long keep,
                                   SharedProgress& progress);

}  // namespace samara::models
