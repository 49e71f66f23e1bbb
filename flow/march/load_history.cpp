#include "samara/flow/march/load_history.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace samara::flow {

namespace {

/// 97.5 % quantile of Student's distribution.
double student_quantile(std::size_t freedom) {
  constexpr std::array kQuantiles = {12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228,
                                     2.201,  2.179, 2.160, 2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086};
  return freedom <= kQuantiles.size() ? kQuantiles[freedom - 1] : 1.96 + 2.5 / static_cast<double>(freedom);
}

double drag_of_last(const std::vector<PeriodMeans>& periods, std::size_t end, std::size_t count) {
  double sum = 0.0, length = 0.0;
  for (std::size_t i = end - count; i < end; ++i) {
    sum += periods[i].length * periods[i].drag;
    length += periods[i].length;
  }
  return sum / length;
}

double lift_of_last(const std::vector<PeriodMeans>& periods, std::size_t end, std::size_t count) {
  double sum = 0.0, length = 0.0;
  for (std::size_t i = end - count; i < end; ++i) {
    sum += periods[i].length * periods[i].lift;
    length += periods[i].length;
  }
  return sum / length;
}

/// Deviation of the lift over some periods.
double swing_of_last(const std::vector<PeriodMeans>& periods, std::size_t end, std::size_t count) {
  double squared = 0.0, length = 0.0;
  for (std::size_t i = end - count; i < end; ++i) {
    squared += periods[i].length * periods[i].lift_squared;
    length += periods[i].length;
  }
  return std::sqrt(std::max(0.0, squared / length - std::pow(lift_of_last(periods, end, count), 2)));
}

constexpr double kSwing = 0.1,
                 kLeastSwing = 0.02;  // below which the size of a swing says nothing of the drag
/// Of a constant lift: what is left when its square is taken away from the mean of its squares.
constexpr double kRounding = 1e-7;

/// Of the halves of what was averaged: the second less the first.
struct Halves {
  double drag = 0.0;
  bool same_swing = true;
};

Halves halves_of(const std::vector<PeriodMeans>& periods) {
  const std::size_t count = periods.size(), half = count / 2;
  const double drag = drag_of_last(periods, count, half) - drag_of_last(periods, count - half, count - half);
  const double before = swing_of_last(periods, count - half, count - half),
               after = swing_of_last(periods, count, half), larger = std::max(before, after);
  // A swing that says nothing of the drag yet may be the beginning of shedding about a body that was symmetric: it
  // must not grow.
  const double change = larger < kLeastSwing ? after - before : std::abs(after - before);
  return {drag, change <= kSwing * larger + kRounding * std::abs(lift_of_last(periods, count, count))};
}

struct Sample {
  double mean = 0.0, squared_error = 0.0;  ///< of the mean
};

template <class Value>
Sample sample_of(std::span<const PeriodMeans> periods, const Value& value) {
  const auto count = static_cast<double>(periods.size());
  Sample sample;
  for (const PeriodMeans& period : periods) sample.mean += value(period) / count;
  for (const PeriodMeans& period : periods)
    sample.squared_error += std::pow(value(period) - sample.mean, 2) / (count - 1.0) / count;
  return sample;
}

/// Whether the means of both halves are further apart than a share of the larger one and than scatter lets them be.
/// That is asked after every period, and Student's 95 % would come up by chance in a long run: twice that does not.
template <class Value>
bool has_moved(const std::vector<PeriodMeans>& periods, double share, double least, const Value& value) {
  constexpr double kBeyondChance = 2.0;
  const std::span all(periods);
  const std::size_t half = periods.size() / 2;
  const Sample before = sample_of(all.first(periods.size() - half), value),
               after = sample_of(all.last(half), value);
  const double larger = std::max(std::abs(before.mean), std::abs(after.mean));
  const double by_chance =
      student_quantile(periods.size() - 2) * std::sqrt(before.squared_error + after.squared_error);
  return larger >= least &&
         std::abs(after.mean - before.mean) > std::max(share * larger, kBeyondChance * by_chance);
}

}  // namespace

std::optional<PeriodMeans> PeriodCounter::add(const LoadRecord& record) {
  sums_.length += record.step;
  sums_.drag += record.step * record.drag;
  sums_.lift += record.step * record.lift;
  sums_.moment += record.step * record.moment;
  sums_.drag_squared += record.step * record.drag * record.drag;
  sums_.lift_squared += record.step * record.lift * record.lift;

  seen_ += record.step;
  const double share = std::min(1.0, record.step / std::min(kMemory, seen_));
  mean_ += share * (record.lift - mean_);
  const double deviation = record.lift - mean_;
  deviation_squared_ += share * (deviation * deviation - deviation_squared_);

  bool ends, crosses = false;
  if (sheds()) {
    crosses = ends = below_ > 0.0 && deviation >= 0.0;
    if (deviation < -0.3 * std::sqrt(deviation_squared_)) below_ = 1.0;
    // A drift of the lift alone passes its mean once, and then never again.
    ends = ends || sums_.length > kLongest;
  } else {
    ends = sums_.length >= 5.0;
  }
  if (!ends) return std::nullopt;
  below_ = 0.0;
  PeriodMeans means = sums_;
  means.by_crossing = crosses && crossed_ > 0.0;
  crossed_ = crosses ? 1.0 : 0.0;
  for (double* sum : {&means.drag, &means.lift, &means.moment, &means.drag_squared, &means.lift_squared})
    *sum /= means.length;
  sums_ = {};
  return means;
}

std::vector<double> PeriodCounter::state() const {
  return {
      sums_.length,       sums_.drag, sums_.lift, sums_.moment, sums_.drag_squared, sums_.lift_squared, mean_,
      deviation_squared_, seen_,      below_,     crossed_};
}

void PeriodCounter::set_state(const std::vector<double>& state) {
  sums_ = {state.at(0), state.at(1), state.at(2), state.at(3), state.at(4), state.at(5), false};
  mean_ = state.at(6);
  deviation_squared_ = state.at(7);
  seen_ = state.at(8);
  below_ = state.at(9);
  crossed_ = state.at(10);
}

bool is_settled(const std::vector<PeriodMeans>& periods) {
  constexpr std::size_t kPeriods = 5;
  constexpr double kMoves = 0.02;
  if (periods.size() < 2 * kPeriods) return false;
  const double now = drag_of_last(periods, periods.size(), kPeriods);
  const double before = drag_of_last(periods, periods.size() - kPeriods, kPeriods);
  return std::abs(now - before) < kMoves * std::abs(now);
}

bool is_known(const std::vector<PeriodMeans>& periods, double share) {
  constexpr std::size_t kLeastPeriods = 5;
  if (periods.size() < kLeastPeriods) return false;
  const MeanWithError drag = mean_drag(periods);
  const double largest = share * std::abs(drag.value);
  const Halves halves = halves_of(periods);
  return drag.half_width < largest && std::abs(halves.drag) < largest && halves.same_swing;
}

bool holds_transient(const std::vector<PeriodMeans>& periods, double share) {
  constexpr std::size_t kLeastPeriods = 10;
  if (periods.size() < kLeastPeriods) return false;
  return has_moved(periods, share, 0.0, [](const PeriodMeans& period) { return period.drag; }) ||
         has_moved(periods, kSwing, kLeastSwing, [](const PeriodMeans& period) {
           return std::sqrt(std::max(0.0, period.lift_squared - period.lift * period.lift));
         });
}

std::vector<PeriodMeans> last_periods(const std::vector<LoadRecord>& history, double period) {
  const double end = history.back().time, half = 0.5 * (end - (history.front().time - history.front().step));
  const double length = period > 0.0 ? period : half;
  const double count = std::max(1.0, std::floor(half / length * (1.0 + 1e-9)));
  std::vector<PeriodMeans> periods(static_cast<std::size_t>(count));
  const auto period_at = [&](double time) {
    return static_cast<std::size_t>(std::clamp(std::floor((time - end) / length + count), 0.0, count - 1.0));
  };
  for (const LoadRecord& record : history) {
    // A step counts in each period by the share of it that lies there.
    const std::size_t last = period_at(record.time);
    for (std::size_t p = period_at(record.time - record.step); p <= last; ++p) {
      const double low = end - length * (count - static_cast<double>(p)), high = low + length;
      const double share = std::min(record.time, high) - std::max(record.time - record.step, low);
      if (share <= 0.0) continue;
      PeriodMeans& sums = periods[p];
      sums.length += share;
      sums.drag += share * record.drag;
      sums.lift += share * record.lift;
      sums.moment += share * record.moment;
      sums.drag_squared += share * record.drag * record.drag;
      sums.lift_squared += share * record.lift * record.lift;
    }
  }
  for (PeriodMeans& means : periods) {
    for (double* sum : {&means.drag, &means.lift, &means.moment, &means.drag_squared, &means.lift_squared})
      *sum /= means.length;
  }
  return periods;
}

double shedding_frequency(const std::vector<PeriodMeans>& periods) {
  constexpr double kLeastPeriods = 3.0;
  double count = 0.0, length = 0.0;
  for (const PeriodMeans& period : periods) {
    if (!period.by_crossing) continue;
    count += 1.0;
    length += period.length;
  }
  return count >= kLeastPeriods ? count / length : 0.0;
}

MeanWithError mean_drag(const std::vector<PeriodMeans>& periods) {
  if (periods.empty()) return {};
  MeanWithError mean{drag_of_last(periods, periods.size(), periods.size()), INFINITY};
  if (periods.size() < 2) return mean;
  double squared = 0.0;
  for (const PeriodMeans& period : periods) squared += std::pow(period.drag - mean.value, 2);
  const auto count = static_cast<double>(periods.size());
  mean.half_width = student_quantile(periods.size() - 1) * std::sqrt(squared / (count - 1.0) / count);
  return mean;
}

}  // namespace samara::flow
