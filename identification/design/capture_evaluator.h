#pragma once

#include <memory>
#include <vector>

#include "samara/identification/design/capture_rows.h"
#include "samara/identification/design/precision.h"

/// Internal to identification/.
namespace samara::identification {

using Release = std::vector<double>;  ///< in the order of Experiment::coordinates, SI

/// What captures at many releases say, for every draw of the coefficients, side by side on threads.
class CaptureEvaluator {
 public:
  /// @param draws coefficients x draws, SI
  CaptureEvaluator(const models::TrajectoryFamily& family, const Experiment& experiment,
                   const KnownSoFar& known, Eigen::MatrixXd draws);

  /// Of each release; zero where there is no trajectory.
  std::vector<Informations> informations(const std::vector<Release>& releases);
  RowsOfCaptures rows(const std::vector<Release>& releases);

  long evaluations() const;

 private:
  /// use(release, draw, rows) for all of them; rows are null where there is no trajectory.
  template <class Use>
  void for_all(const std::vector<Release>& releases, const Use& use);

  Eigen::MatrixXd draws_;
  std::vector<std::unique_ptr<NextCapture>> workers_;
};

}  // namespace samara::identification
