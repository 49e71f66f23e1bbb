#include "samara/pgd/sampling/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "samara/pgd/sampling/chebyshev_field.h"
#include "samara/pgd/sampling/error_climb.h"
#include "samara/pgd/sampling/field_decay.h"
#include "samara/pgd/sampling/growing_cross.h"
#include "samara/pgd/sampling/leja.h"
#include "samara/pgd/sampling/noise_level.h"
#include "samara/pgd/sampling/off_grid_check.h"
#include "samara/pgd/sampling/sample_table.h"
#include "samara/pgd/sampling/sampling_checks.h"
#include "samara/pgd/sampling/transform_trial.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

namespace {

constexpr std::size_t kGuardPivots = 2;
constexpr std::size_t kRefutedPivots = 8;  // of a claim that fresh points refute
constexpr int kGuardPoints = 25;           // fresh ones in every round
constexpr int kCheckPoints = 100;          // of the first claim, beside its exploration
constexpr int kLaterCheckPoints = 50;      // of later ones, and as many uniform points
constexpr int kPartOfGrid = 8;             // by which an axis of a whole grid grows
constexpr int kMostChallenges = 20;
constexpr int kMostElsewhere = 3;  // challenges that find wrong what the cross has right
constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Sampling {
 public:
  Sampling(const std::vector<SampledCoordinate>& coordinates, const std::vector<OutputLabel>& outputs,
           const PointsFunction& function, const SamplingOptions& options)
      : coordinates_(coordinates),
        outputs_(outputs),
        options_(options),
        function_(coordinates, outputs, function, options),
        random_(options.seed),
        check_(coordinates, function_, random_.bits()),
        tolerance_(kShare * options.tolerance) {
    result_.error = result_.root_mean_square_error = kInfinity;
  }

  SamplingResult run() {
    try {
      start();
      while (!round()) continue;
    } catch (const SamplingStopped& stopped) {
      result_.status = stopped.ending.status;
      result_.message = stopped.ending.message;
      result_.bad_point = stopped.ending.where;
    }
    finish();
    return std::move(result_);
  }

 private:
  void start() {
    std::vector<CoordinateMap> maps;
    const std::vector<Transform> transforms = try_transforms(coordinates_, function_, random_.bits());
    for (std::size_t k = 0; k < coordinates_.size(); ++k) {
      maps.emplace_back(coordinates_[k].lower, coordinates_[k].upper, transforms[k]);
    }
    table_.emplace(function_, std::move(maps));
    start_cross();
  }

  void start_cross() {
    cross_.emplace(*table_, std::vector<int>(coordinates_.size(), kFewestNodes), options_.max_rank,
                   random_.bits());
    for (Eigen::Index j = 0; j < options_.start.cols(); ++j) {
      cross_->add_pivot(nearest_node(options_.start.col(j)), tolerance_);
    }
  }

  /// @returns true if the work is done, with status and message set
  bool round() {
    // Ranks that run away, as in noise, must not use up all calls before anybody looks.
    constexpr long kMore = 2;
    constexpr long kFew = 500;
    cross_->grow(tolerance_, kFew + kMore * function_.calls());
    std::optional<TrainField> before = std::move(latest_);
    latest_ = on_chebyshev_axes(coordinates_, table_->maps(), outputs_, cross_->train());
    const TrainField& field = *latest_;
    const TrainField& other = before ? *before : field;
    call_off_grid(kGuardPoints / 2, kGuardPoints - kGuardPoints / 2, field, other);
    // Every point off the grid that was ever called counts, not only this round's.
    const PointErrors errors = check_.errors(field, check_.count());
    keep_if_best(field, errors);
    if (looks_noisy()) return restart_above_noise();
    const std::vector<int> rough = rough_coordinates(field);
    int pivots = 0;
    if (errors.worst() <= margin() * options_.tolerance && rough.empty()) {
      if (holds_at_fresh_points(field, other)) return true;
      pivots = add_worst(check_.errors(field, check_.count()), kRefutedPivots);
    } else {
      pivots = add_worst(errors, kGuardPivots);
    }
    const bool finer = refine(rough);
    if (pivots == 0 && !finer) {
      if (cross_->ranks_are_exhausted() || nodes_are_exhausted()) {
        return stop(Termination::exhausted, "the ranks or nodes allowed are used up");
      }
      be_stricter();
    }
    return stagnated();
  }

  void keep_if_best(const TrainField& field, const PointErrors& errors) {
    result_.history.push_back({function_.calls(), errors.worst(), cross_->ranks(), cross_->nodes()});
    function_.report(std::clamp(std::log(errors.worst()) / std::log(options_.tolerance), 0.0, 1.0));
    // The field kept before is measured at the points that came since, too.
    if (result_.field) {
      const PointErrors of_kept = check_.errors(*result_.field, check_.count());
      if (!(errors.worst() < of_kept.worst())) {
        measure(of_kept);
        return;
      }
    }
    keep(field, errors);
  }

  void keep(const TrainField& field, const PointErrors& errors) {
    result_.field = field;
    measure(errors);
    calls_of_best_ = function_.calls();
  }

  void measure(const PointErrors& errors) {
    result_.error = errors.worst();
    result_.root_mean_square_error = errors.root_mean_square;
    result_.points_checked = static_cast<int>(errors.largest.size());
    Eigen::Index worst = 0;
    errors.largest.maxCoeff(&worst);
    const Eigen::VectorXd point = check_.points().rightCols(errors.largest.size()).col(worst);
    result_.worst_point.assign(point.begin(), point.end());
  }

  /// The claim: nothing that has been called errs, nor do fresh points, climbs or the challenge.
  bool holds_at_fresh_points(const TrainField& field, const TrainField& other) {
    if (has_explored_) {
      call_off_grid(kLaterCheckPoints, kLaterCheckPoints, field, other);
    } else {
      call_off_grid(kCheckPoints, exploration_points(), field, other);
    }
    has_explored_ = true;
    if (!holds_where_called(field) || !holds_after_climbs(field)) return false;
    const double error = result_.error;
    if (!holds_against_challenge()) return is_refuted();
    return stop(Termination::converged,
                fmt::format("largest error {:.3g} <= {:.3g} at {} points of the check", error,
                            options_.tolerance, result_.points_checked));
  }

  int exploration_points() const {
    constexpr int kPerCoordinate = 30;
    constexpr long kShareOfCalls = 200;
    if (options_.exploration_points > 0) return options_.exploration_points;
    constexpr long kMost = 100'000;
    const long of_calls = std::min(options_.max_calls / kShareOfCalls, kMost);
    return kPerCoordinate * function_.coordinates() + static_cast<int>(of_calls);
  }

  bool holds_where_called(const TrainField& field) {
    const PointErrors errors = check_.errors(field, check_.count());
    const PointErrors of_kept = check_.errors(*result_.field, check_.count());
    const bool holds = errors.worst() <= margin() * options_.tolerance;
    if (holds || errors.worst() < of_kept.worst()) {
      keep(field, errors);
    } else {
      measure(of_kept);
    }
    return holds;
  }

  double margin() const { return least_tolerance_ > 0.0 ? kMarginAboveNoise : kMargin; }

  /// Where a few errors stand out, small as they are, climbs go to see what they belong to.
  bool holds_after_climbs(const TrainField& field) {
    constexpr int kClimbs = 3;
    constexpr double kFarAbove = 10.0;
    const Eigen::MatrixXd points = check_.uniform_points();
    const Eigen::VectorXd errors = check_.uniform_errors(field);
    if (!(errors.maxCoeff() > kNegligible * options_.tolerance) || !has_outliers(errors, kFarAbove))
      return true;
    const ErrorsAt errors_at = [&](const Eigen::MatrixXd& at) { return check_.errors_at(field, at); };
    Eigen::VectorXd lower(points.rows()), upper(points.rows());
    for (Eigen::Index k = 0; k < points.rows(); ++k) {
      lower[k] = coordinates_[static_cast<std::size_t>(k)].lower;
      upper[k] = coordinates_[static_cast<std::size_t>(k)].upper;
    }
    check_.call(climb_from_worst(lower, upper, errors_at, points, errors, kClimbs).points);
    return holds_where_called(field);
  }

  bool holds_against_challenge() {
    if (!options_.challenge) return true;
    result_.calls = function_.calls();
    result_.range = function_.range();
    result_.scale = function_.scale();
    result_.pivots = cross_->pivots();
    const Eigen::MatrixXd wrong = options_.challenge(result_);
    if (wrong.cols() == 0) return true;
    ++refutations_;
    check_.call(wrong);
    if (holds_where_called(*latest_)) ++refuted_elsewhere_;
    return false;
  }

  bool is_refuted() {
    if (refuted_elsewhere_ >= kMostElsewhere) {
      return stop(Termination::refuted,
                  fmt::format("fresh points found the field wrong {} times where the sample has it right",
                              refuted_elsewhere_));
    }
    if (refutations_ < kMostChallenges) return false;
    return stop(Termination::refuted,
                fmt::format("fresh points found the field wrong {} times", refutations_));
  }

  void call_off_grid(int suspicious, int uniform, const TrainField& field, const TrainField& other) {
    const Eigen::MatrixXd first = check_.suspicious_points(suspicious, field, other, cross_->pivots());
    Eigen::MatrixXd points(first.rows(), first.cols() + uniform);
    points << first, check_.random_points(uniform);
    check_.call(points, uniform);
  }

  /// Makes the points with the largest errors pivots. @returns how many bonds took one
  int add_worst(const PointErrors& errors, std::size_t most) {
    const std::vector<Eigen::Index> order = errors.descending();
    int added = 0;
    for (std::size_t j = 0; j < order.size() && j < most; ++j) {
      if (!(errors.largest[order[j]] > tolerance_)) break;
      added += cross_->add_pivot(nearest_node(check_.points().col(order[j])), tolerance_);
    }
    return added;
  }

  Eigen::VectorXi nearest_node(const Eigen::VectorXd& x) const {
    Eigen::VectorXi node(x.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const double u =
          table_->maps()[i].to_unit(std::clamp(x[k], coordinates_[i].lower, coordinates_[i].upper));
      (leja_points(cross_->nodes()[i]).array() - u).abs().minCoeff(&node[k]);
    }
    return node;
  }

  /// Coordinates along which the last coefficients of the interpolant are not small yet. The lines go through
  /// random points and, where narrow features are, through pivots.
  std::vector<int> rough_coordinates(const TrainField& field) {
    constexpr int kLines = 30;
    constexpr double kSmall = 0.25;
    const Eigen::MatrixXd pivots = cross_->pivots();
    Eigen::MatrixXd points = check_.random_points(kLines);
    for (Eigen::Index j = 1; j < kLines; j += 2) {
      points.col(j) = pivots.col(random_.below(static_cast<int>(pivots.cols())));
    }
    tails_ = coefficient_tails(field, function_.scale(), points);
    std::vector<int> rough;
    for (std::size_t k = 0; k < tails_.size(); ++k) {
      if (tails_[k] > std::max(kSmall * options_.tolerance, 0.5 * least_tolerance_))
        rough.push_back(static_cast<int>(k));
    }
    return rough;
  }

  bool refine(const std::vector<int>& rough) {
    bool finer = false;
    for (const int k : rough) {
      const auto i = static_cast<std::size_t>(k);
      const int step = std::max(tails_[i] < 10.0 * tolerance_ ? 1 : 2,
                                cross_->has_whole_grid() ? cross_->nodes()[i] / kPartOfGrid : 0);
      const int count = std::min(cross_->nodes()[i] + step, options_.max_nodes);
      finer = finer || count > cross_->nodes()[i];
      cross_->set_nodes(k, count);
    }
    return finer;
  }

  bool nodes_are_exhausted() const {
    return std::ranges::all_of(cross_->nodes(), [&](int n) { return n >= options_.max_nodes; });
  }

  /// The guard sees errors, but neither search nor decay does: a stricter search, and in turn finer grids.
  void be_stricter() {
    std::vector<int> all;
    for (int k = 0; k < function_.coordinates(); ++k) all.push_back(k);
    refine(all);
    if (tolerance_ > 0.01 * options_.tolerance) tolerance_ = std::max(0.5 * tolerance_, least_tolerance_);
  }

  /// Once, where many more calls have not helped.
  bool looks_noisy() {
    constexpr double kMore = 1.5;
    constexpr double kNoise = 1e-3;  // of the tolerance
    if (result_.noise || static_cast<double>(function_.calls()) < kMore * static_cast<double>(calls_of_best_))
      return false;
    result_.noise = noise_level(coordinates_, function_, random_);
    return *result_.noise > kNoise * options_.tolerance;
  }

  /// Pivots that follow noise spoil all others: the search begins again, and stays above the noise.
  bool restart_above_noise() {
    least_tolerance_ = kNoiseDeviations * *result_.noise;
    if (attainable_error() > options_.tolerance) return stop(Termination::noise, noise_described());
    tolerance_ = std::max(kShare * options_.tolerance, least_tolerance_);
    latest_.reset();
    start_cross();
    return false;
  }

  /// Among some hundred values of noise one is about twice its root mean square, whatever its distribution.
  double attainable_error() const { return 2.0 * *result_.noise; }

  std::string noise_described() const {
    return fmt::format(
        "the values carry noise of {:.2g} of the range (root mean square), with which errors below about "
        "{:.2g} cannot be reached",
        *result_.noise, attainable_error());
  }

  bool stagnated() {
    constexpr std::size_t kRounds = 24;
    constexpr std::size_t kRoundsInNoise = 8;
    constexpr long kManyMore = 3;
    const bool is_noisy = least_tolerance_ > 0.0;
    if (result_.history.size() < (is_noisy ? kRoundsInNoise : kRounds) ||
        function_.calls() < kManyMore * calls_of_best_)
      return false;
    const std::string sentence =
        fmt::format("three times as many calls did not lower the error of {:.3g}", result_.error);
    if (is_noisy) return stop(Termination::noise, noise_described() + ", and " + sentence);
    return stop(Termination::stagnated, sentence);
  }

  bool stop(Termination status, std::string message) {
    result_.status = status;
    result_.message = std::move(message);
    return true;
  }

  void finish() {
    result_.calls = function_.calls();
    result_.seconds = function_.seconds();
    result_.range = function_.range();
    result_.scale = function_.scale();
    if (cross_) {
      result_.grid_size = 1.0;
      for (const int n : cross_->nodes()) result_.grid_size *= n;
      result_.pivots = cross_->pivots();
    }
    if (result_.status == Termination::converged) {
      result_.message += fmt::format(", with {} calls", result_.calls);
    } else if (result_.field) {
      const bool small = result_.error <= options_.tolerance;
      const Eigen::Map<const Eigen::VectorXd> worst(result_.worst_point.data(), function_.coordinates());
      result_.message += fmt::format(
          "; the best after {} calls errs by {:.3g} at {} points, {} {:.3g}{}", result_.calls, result_.error,
          result_.points_checked, small ? "within" : "more than", options_.tolerance,
          small ? (refutations_ > 0 ? " but refuted at fresh ones" : " but unchecked at fresh ones")
                : ", most at " + function_.described(worst));
    }
  }

  /// The search works to this share of the tolerance, the rest is for what it does not see.
  static constexpr double kShare = 0.5;
  /// What the points called must show: a few hundred points do not see the largest error of all.
  static constexpr double kMargin = 0.6;
  /// Of errors that are mostly noise hundreds of points see nearly the largest.
  static constexpr double kMarginAboveNoise = 0.9;
  /// The largest of some hundred values of noise, over its root mean square.
  static constexpr double kNoiseDeviations = 4.0;
  /// Errors below this share of the tolerance are of no interest, however they are distributed.
  static constexpr double kNegligible = 1e-3;

  const std::vector<SampledCoordinate>& coordinates_;
  const std::vector<OutputLabel>& outputs_;
  const SamplingOptions& options_;
  SampledFunction function_;
  Random random_;
  OffGridCheck check_;
  double tolerance_;              ///< of the search
  double least_tolerance_ = 0.0;  ///< of the search, where there is noise
  std::optional<SampleTable> table_;
  std::optional<GrowingCross> cross_;
  std::optional<TrainField> latest_;
  bool has_explored_ = false;
  int refutations_ = 0;        ///< by the challenge
  int refuted_elsewhere_ = 0;  ///< of these, where the sample itself has no error
  std::vector<double> tails_;  ///< per coordinate, see rough_coordinates()
  long calls_of_best_ = 0;
  SamplingResult result_;
};

}  // namespace

SamplingResult sample(const std::vector<SampledCoordinate>& coordinates,
                      const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                      const SamplingOptions& options) {
  check_sampling(coordinates, outputs, function, options);
  return Sampling(coordinates, outputs, function, options).run();
}

}  // namespace samara::pgd
