#include "samara/models/stochastic/ensemble_sums.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::models {

void Spread::add(const Eigen::VectorXd& x) {
  ++count_;
  const Eigen::VectorXd before = x - mean_;
  mean_ += before / static_cast<double>(count_);
  squares_ += before.cwiseProduct(x - mean_);
}

void Spread::merge(const Spread& other) {
  if (other.count_ == 0) return;
  const auto n = static_cast<double>(count_), m = static_cast<double>(other.count_);
  const Eigen::VectorXd apart = other.mean_ - mean_;
  mean_ += m / (n + m) * apart;
  squares_ += other.squares_ + n * m / (n + m) * apart.cwiseAbs2();
  count_ += other.count_;
}

Eigen::VectorXd Spread::error_of_mean() const {
  if (count_ < 2) return Eigen::VectorXd::Constant(mean_.size(), std::numeric_limits<double>::quiet_NaN());
  const auto n = static_cast<double>(count_);
  return (squares_ / (n * (n - 1.0))).cwiseSqrt();
}

void Moments::add(const Eigen::VectorXd& x) {
  ++count_;
  const Eigen::VectorXd before = x - mean_;
  mean_ += before / static_cast<double>(count_);
  squares_.selfadjointView<Eigen::Lower>().rankUpdate(before, 1.0 - 1.0 / static_cast<double>(count_));
}

void Moments::merge(const Moments& other) {
  if (other.count_ == 0) return;
  const auto n = static_cast<double>(count_), m = static_cast<double>(other.count_);
  const Eigen::VectorXd apart = other.mean_ - mean_;
  mean_ += m / (n + m) * apart;
  squares_ += other.squares_;
  squares_.selfadjointView<Eigen::Lower>().rankUpdate(apart, n * m / (n + m));
  count_ += other.count_;
}

Eigen::MatrixXd Moments::covariance() const {
  if (count_ < 2)
    return Eigen::MatrixXd::Constant(mean_.size(), mean_.size(), std::numeric_limits<double>::quiet_NaN());
  const Eigen::MatrixXd all = squares_.selfadjointView<Eigen::Lower>();
  return all / static_cast<double>(count_ - 1);
}

void TimeSums::merge(const TimeSums& other) {
  single.merge(other.single);
  independent.merge(other.independent);
  groups.merge(other.groups);
}

void TimeSums::close_group() {
  if (single.count() >= 2) groups.add(single.covariance().reshaped());
}

void StepCounts::merge(const StepCounts& other) {
  steps_ += other.steps_;
  beyond_tenth_ += other.beyond_tenth_;
  beyond_third_ += other.beyond_third_;
  for (std::size_t bin = 0; bin < by_scale_.size(); ++bin) by_scale_[bin] += other.by_scale_[bin];
}

double StepCounts::scale_below(double share) const {
  long below = 0;
  for (int bin = 0; bin < kBins - 1; ++bin) {
    below += by_scale_[static_cast<std::size_t>(bin)];
    if (static_cast<double>(below) >= share * static_cast<double>(steps_) && below > 0)
      return std::ldexp(1.0 + static_cast<double>(bin % kPerOctave) / kPerOctave,
                        (bin + kLeast - bin % kPerOctave) / kPerOctave);
  }
  return std::numeric_limits<double>::infinity();
}

void EnsembleSums::merge(const EnsembleSums& other) {
  for (std::size_t k = 0; k < at.size(); ++k) at[k].merge(other.at[k]);
  half_turns.merge(other.half_turns);
  displacement.merge(other.displacement);
  way.merge(other.way);
  steps.merge(other.steps);
}

double EnsembleSums::relative_error() const {
  return displacement.error_of_mean().norm() / std::sqrt(way.mean()[0]);
}

}  // namespace samara::models
