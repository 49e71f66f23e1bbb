#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/fit/capture_prediction.h"
#include "samara/identification/fit/prediction.h"
#include "samara/identification/forecasts/trained_forecasts.h"

/// Forecasts of captures by what training captures showed; internal to identification/.
namespace samara::identification {

/// Outputs that are compared as one: all lengths, all velocities, all rates, or a single other one; or the
/// attitude.
struct Quantity {
  std::string name, unit;
  double period = 0.0;  ///< 0: on the line
  std::vector<int> columns = {};
  bool is_attitude = false;
  /// Of the columns: those that are level, and the one that is up. A position in space, x, y and z, has them.
  Components components = {};
  Eigen::Index up = -1;
  double net_weight = kStandardG;  ///< m/s^2, as SeenMotion
};

/// What was seen of a quantity.
SeenMotion seen_of(const CapturePrediction& one, const Quantity& quantity);

/// Of each quantity but the attitude and those with a period, for each horizon by itself: frames that lie equally far
/// beyond the last one seen, to half of the shortest frame interval. Horizons that fewer than half as many training
/// frames show as the best of them are left out. Of the others the first 16 are trained, then only those a seventh
/// farther than the one before, and the last: hundreds cost no more than dozens.
///
/// A frame between two horizons is forecast by both: the autoregression's mean velocity on the way there is
/// interpolated (exact where motions have constant accelerations), and so are the mixtures and all distributions. A
/// frame outside is forecast by the nearest one.
class MotionForecasts {
 public:
  /// @param predictions of training captures, each by a fit that has not seen it; those without a model teach the
  ///   autoregression alone
  MotionForecasts(std::span<const Quantity> compared, std::span<const CapturePrediction> predictions,
                  const PredictionOptions& prediction);

  /// What every predictor says of a frame ahead, in the order of TrainedForecasts::say(); nothing for
  /// quantities without forecasts.
  std::vector<SaidForecast> say(std::size_t quantity, const CapturePrediction& one, Eigen::Index frame) const;

  /// s, those that are trained.
  std::vector<double> horizons(std::size_t quantity) const;

  /// Sentences: which mixtures say nothing, have no distributions, or have learned of nearer frames alone, and why.
  /// @param reach s, of the last frame that is asked about
  std::vector<std::string> lacks(double reach) const;

  /// A sentence with the shares at the end of the way, or as far as anything was learned, and whether views that are
  /// given count; empty if there are none.
  std::string shares(std::size_t quantity) const;

 private:
  struct Horizon {
    double ahead = 0.0;  ///< s
    TrainedForecasts trained = {};
  };

  std::vector<Quantity> compared_;
  PredictionOptions prediction_;
  std::vector<std::vector<Horizon>> trained_;  ///< by quantity, the nearest first; empty: no forecasts
};

}  // namespace samara::identification
