#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

/// Statistics gathered while realisations run, in one pass and mergeable (B. P. Welford, Technometrics 4 (1962)
/// 419-420; merged as by T. F. Chan, G. H. Golub, R. J. LeVeque, Am. Stat. 37 (1983) 242-247).
namespace samara::models {

/// Mean and variance of each entry of vectors.
class Spread {
 public:
  explicit Spread(Eigen::Index size) : mean_(Eigen::VectorXd::Zero(size)), squares_(mean_) {}

  void add(const Eigen::VectorXd& x);
  void merge(const Spread& other);

  long count() const { return count_; }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// Standard error of the mean where what was added is independent; NaN for fewer than two.
  Eigen::VectorXd error_of_mean() const;

  /// Visits all that it holds: numbers, vectors and matrices, whose sizes stay. Likewise below.
  template <class Visit>
  void visit(Visit& visit) {
    visit(count_);
    visit(mean_);
    visit(squares_);
  }

 private:
  long count_ = 0;
  Eigen::VectorXd mean_, squares_;
};

/// Mean and covariance of vectors.
class Moments {
 public:
  explicit Moments(Eigen::Index size)
      : mean_(Eigen::VectorXd::Zero(size)), squares_(Eigen::MatrixXd::Zero(size, size)) {}

  void add(const Eigen::VectorXd& x);
  void merge(const Moments& other);

  long count() const { return count_; }
  const Eigen::VectorXd& mean() const { return mean_; }
  /// NaN for fewer than two.
  Eigen::MatrixXd covariance() const;

  template <class Visit>
  void visit(Visit& visit) {
    visit(count_);
    visit(mean_);
    visit(squares_);
  }

 private:
  long count_ = 0;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd squares_;  ///< the lower half
};

/// Of a quantity at one time.
struct TimeSums {
  explicit TimeSums(Eigen::Index size) : single(size), independent(size), groups(size * size) {}

  Moments single;      ///< over realisations
  Spread independent;  ///< over what is independent: realisations, or means of pairs
  Spread groups;       ///< over covariances of groups of realisations, flattened

  void merge(const TimeSums& other);
  /// Takes the realisations so far for a group.
  void close_group();
};

/// How long the steps were, beside what the air changes in.
class StepCounts {
 public:
  void add(double h, double time_scale);
  void merge(const StepCounts& other);

  long steps() const { return steps_; }
  long beyond_tenth() const { return beyond_tenth_; }
  long beyond_third() const { return beyond_third_; }
  template <class Visit>
  void visit(Visit& visit) {
    for (long* count : {&steps_, &beyond_tenth_, &beyond_third_}) visit(*count);
    for (long& count : by_scale_) visit(count);
  }

  /// The scale that a share of the steps stays below [s], to a fifth of itself; infinite where the air changes in none.
  double scale_below(double share) const;

 private:
  static constexpr int kPerOctave = 4;
  static constexpr int kLeast = -40 * kPerOctave;  ///< 2^-40 s
  static constexpr int kBins = 80 * kPerOctave;

  long steps_ = 0, beyond_tenth_ = 0, beyond_third_ = 0;
  std::array<long, kBins> by_scale_ = {};
};

inline void StepCounts::add(double h, double time_scale) {
  ++steps_;
  if (h > 0.1 * time_scale * (1.0 + 1e-9)) ++beyond_tenth_;
  if (h >= 0.3 * time_scale) ++beyond_third_;
  // The exponent of a double and the first two bits after it are quarters of octaves, in order.
  // Infinite ones are longer than all others.
  static_assert(kPerOctave == 4);
  constexpr std::int64_t kOfOne = 1023 * kPerOctave;
  const std::int64_t quarter = (std::bit_cast<std::int64_t>(time_scale) >> 50) - kOfOne;
  const bool is_number = time_scale >= 0.0;  // what is none counts as the longest
  ++by_scale_[static_cast<std::size_t>(is_number ? std::clamp<std::int64_t>(quarter - kLeast, 0, kBins - 1)
                                                 : kBins - 1)];
}

/// All that is summed over realisations.
class EnsembleSums {
 public:
  EnsembleSums(std::size_t times, Eigen::Index states)
      : at(times, TimeSums(states)), half_turns(1), displacement(3), way(1) {}

  void merge(const EnsembleSums& other);
  template <class Visit>
  void visit(Visit& visit) {
    for (TimeSums& sums : at) {
      sums.single.visit(visit);
      sums.independent.visit(visit);
      sums.groups.visit(visit);
    }
    for (Spread* spread : {&half_turns, &displacement, &way}) spread->visit(visit);
    steps.visit(visit);
  }

  /// Standard error of the mean displacement over the root mean square displacement.
  double relative_error() const;

  std::vector<TimeSums> at;  ///< by time
  Spread half_turns;         ///< over what is independent
  Spread displacement;       ///< from the start to the last place, over what is independent
  Spread way;                ///< its square, over realisations
  StepCounts steps;
};

}  // namespace samara::models
