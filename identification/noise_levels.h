#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "samara/identification/capture.h"
#include "samara/identification/fit_options.h"
#include "samara/identification/fit_problem.h"
#include "samara/identification/fit_result.h"
#include "samara/identification/segment_residual.h"

/// Internal to identification/: standard deviations of the noise of outputs, from the residuals of a fit.
namespace samara::identification {

/// Whether the options ask for the noise of this output, or of "attitude".
bool noise_is_estimated(const NoiseOptions& options, const std::string& output);

/// The loss scale over the standard deviation of normal noise at which estimates of location keep 95 % of the
/// efficiency of least squares; 1 where there is no bend.
double efficient_bend(LossKind loss);

/// The median over captures of the scatter of an output's frames about a smooth curve; where no capture has
/// enough of them, a thousandth of its spread.
double frame_scatter(std::span<const Capture> captures, const std::string& output, double period);

/// The levels of a problem. With residuals e, their number n, the trace p of the part of the hat matrix that
/// belongs to them, and a function chi of the loss, the scale s = bend * sigma of a level solves
///
///     sum chi(e/s) = (n - p) E chi(Z/bend),   Z normal,
///
/// chi = r^2 without a loss: sigma^2 = sum e^2/(n - p). Robust losses have a bounded chi.
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
