#pragma once

#include <optional>
#include <vector>

namespace samara::flow {

/// Coefficients of the loads after a step: force over U^2 l/2 (over U^2 l^2/2 in space), moment about the body's centre
/// with one l more.
struct LoadRecord {
  double time = 0.0, step = 0.0;
  double drag = 0.0, lift = 0.0, moment = 0.0;
};

/// Means over one period.
struct PeriodMeans {
  double length = 0.0;
  double drag = 0.0, lift = 0.0, moment = 0.0;
  double drag_squared = 0.0, lift_squared = 0.0;
};

/// A mean of period means, with half the width of its 95 % interval (Student's, periods taken for independent).
struct MeanWithError {
  double value = 0.0, half_width = 0.0;
};

/// Cuts the loads into periods: where the lift passes upwards through its own mean, after it was clearly below. Where
/// nothing sheds (deviations of the lift below 1e-3), a period is 5 l/U.
class PeriodCounter {
 public:
  /// @returns the means of a period that ends with this step
  std::optional<PeriodMeans> add(const LoadRecord& record);
  bool sheds() const { return deviation_squared_ > kStill * kStill; }

  /// All that the next step needs, for checkpoints.
  std::vector<double> state() const;
  void set_state(const std::vector<double>& state);

 private:
  static constexpr double kStill = 1e-3, kMemory = 10.0, kLongest = 30.0;

  PeriodMeans sums_;
  double mean_ = 0.0, deviation_squared_ = 0.0;  ///< of the lift, of the last ten l/U
  double seen_ = 0.0;
  double below_ = 0.0;  ///< 1 after the lift was clearly below its mean
};

/// Whether the mean drag over the last five periods moves by less than 2 %: from that of two periods before.
bool is_settled(const std::vector<PeriodMeans>& periods);

/// Of drag over whole periods, weighted by their lengths.
MeanWithError mean_drag(const std::vector<PeriodMeans>& periods);

}  // namespace samara::flow
