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
  bool by_crossing = false;  ///< from one crossing of the lift's mean to the next: one period of what sheds
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
  double below_ = 0.0;    ///< 1 after the lift was clearly below its mean
  double crossed_ = 0.0;  ///< 1 if the period that is counted began with a crossing
};

/// Whether the mean drag over the last five periods is within 2 % of that over the five before them.
bool is_settled(const std::vector<PeriodMeans>& periods);
/// Whether the mean drag is known to a share of itself: at least five periods, half the 95 % interval below it,
/// and the means of the first and the second half no further apart, so that no slow drift passes for a mean; nor
/// is the deviation of the lift, which shows shedding that grows long before the drag does, by more than a
/// tenth. Deviations below 0.02 may fall, and not grow: between the start and shedding, a symmetric body may
/// have the drag of its steady flow for 60 l/U.
bool is_known(const std::vector<PeriodMeans>& periods, double share);
/// Whether what was averaged holds the end of a transient, which would stay in the mean for long: at least ten
/// periods, of whose halves the drags are further apart than that share, or the deviations of the lift by more than a
/// tenth, and either by more than twice Student's 95 % of the difference, from the scatter within the halves.
bool holds_transient(const std::vector<PeriodMeans>& periods, double share);

/// Means of the last whole periods of a given length that fit into the second half of a history, or of one that does
/// not fit; with the length 0, of that half as one.
std::vector<PeriodMeans> last_periods(const std::vector<LoadRecord>& history, double period);

/// Of drag over whole periods, weighted by their lengths.
MeanWithError mean_drag(const std::vector<PeriodMeans>& periods);
/// Periods per time; 0 for fewer than three periods from crossing to crossing.
double shedding_frequency(const std::vector<PeriodMeans>& periods);

}  // namespace samara::flow
