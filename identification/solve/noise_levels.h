#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/segment_residual.h"

/// Internal to identification/: standard deviations of the noise of outputs, from the residuals of a fit.
namespace samara::identification {

/// The levels of a problem. With residuals e, their number n, the trace p of the part of the hat matrix that
/// belongs to them, and chi the bounded_loss() of statistics/loss.h, the scale s = bend * sigma of a level solves
///
///     sum chi(e/s) = (n - p) E chi(Z/bend),   Z normal,
///
/// chi = r^2 without a loss: sigma^2 = sum e^2/(n - p).
class NoiseLevels {
 public:
  /// Levels that share outputs of different scales begin with the geometric mean of these.
  /// @throws ArgumentError for levels of what is not compared, and of outputs with different units.
  NoiseLevels(const NoiseOptions& options, FitProblem& problem);

  bool empty() const { return levels_.empty(); }

  /// Puts new scales into the problem.
  /// @param residuals of the problem; scratch
  /// @param point a minimum with the old scales
  /// @returns the largest change of a level, as a share of it
  double update(FitProblem& problem, std::vector<SegmentResidual>& residuals, const FitPoint& point);

  /// Levels, and warnings about those that could not be estimated or hold more than noise.
  void report(const FitProblem& problem, FitResult& result) const;

 private:
  enum class State { estimated, exact, too_few };
  struct Level {
    std::vector<int> columns = {};  ///< compared outputs; their number for the attitude
    NoiseLevel result = {};
    double start = 0.0;      ///< loss scale before the first fit
    bool is_scatter = true;  ///< that start is the scatter of frames
    double count = 0.0;
    State state = State::estimated;
  };
  /// What is left over in one column.
  struct Column {
    std::vector<double> errors = {};  ///< measured - model, SI
    double leverage = 0.0;
  };
  std::vector<Column> columns(const FitProblem& problem, std::vector<SegmentResidual>& residuals,
                              const FitPoint& point) const;
  static double& scale(FitProblem& problem, int column);

  LossKind loss_;
  std::vector<Level> levels_;
};

}  // namespace samara::identification
