#include "samara/identification/solve/posterior.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/base/streams.h"
#include "samara/identification/solve/posterior_density.h"
#include "samara/identification/statistics/chains.h"

namespace samara::identification {

namespace {

constexpr int kChains = 4;
/// Proposals of the warm-up: after each part but the last, directions are set anew by the draws of its second half.
constexpr std::array kWarmUp = {120, 200, 100};
/// Mean length of a trajectory in directions of deviation one: a quarter of a period forgets the start.
constexpr double kLength = 0.5 * std::numbers::pi;
/// Share of proposals to be taken, which the warm-up sets steps for.
constexpr double kWantedAcceptance = 0.8;
/// An energy that the leapfrog has lost altogether.
constexpr double kDivergent = 1000.0;
constexpr int kMostSteps = 200;
/// Directions that dense matrices serve: more would take minutes for each change of directions.
constexpr int kMostDirections = 2000;

/// A place of a chain.
struct Place {
  FitPoint point;
  double potential = std::numeric_limits<double>::infinity();
  Eigen::VectorXd slope;  ///< by the directions of the chain
};

struct ChainResult {
  Eigen::MatrixXd draws;  ///< draws x unknowns
  double acceptance = 0.0;
  int divergences = 0;
  long evaluations = 0;
};

/// Sets the step by how many proposals are taken.
class StepSize {
 public:
  double value() const { return std::exp(log_step_); }
  void learn(double acceptance) {
    ++count_;
    const double share = 1.0 / (count_ + 10.0);
    shortfall_ = (1.0 - share) * shortfall_ + share * (kWantedAcceptance - acceptance);
    log_step_ = kStart - std::sqrt(count_) / 0.05 * shortfall_;
    log_step_ = std::clamp(log_step_, -12.0, std::log(kLength));
    const double newer = std::pow(count_, -0.75);
    log_mean_ = newer * log_step_ + (1.0 - newer) * log_mean_;
  }
  void settle() { log_step_ = log_mean_; }

 private:
  static constexpr double kStart = 0.0;
  double log_step_ = -0.5, log_mean_ = 0.0, shortfall_ = 0.0, count_ = 0.0;
};

class Chain {
 public:
  /// @param directions of curvature one at the answer, in columns
  Chain(PosteriorDensity density, const FitProblem& problem, const Eigen::MatrixXd& directions, Stream random)
      : density_(std::move(density)), problem_(problem), directions_(directions), random_(random) {}

  ChainResult run(const FitPoint& answer, int draws) {
    begin(answer);
    for (const int proposals : kWarmUp) {
      Eigen::MatrixXd seen(directions_.rows(), proposals - proposals / 2);
      for (int k = 0; k < proposals; ++k) {
        step_.learn(propose());
        if (k >= proposals / 2) seen.col(k - proposals / 2) = steps_from(answer);
      }
      step_.settle();
      if (proposals != kWarmUp.back()) set_directions(seen);
    }
    divergences_ = 0;
    ChainResult result;
    result.draws.resize(draws, unknowns());
    for (int k = 0; k < draws; ++k) {
      result.acceptance += propose() / draws;
      result.draws.row(k) = packed(place_.point);
    }
    result.divergences = divergences_;
    result.evaluations = density_.evaluations();
    return result;
  }

 private:
  Eigen::Index unknowns() const {
    return problem_.shared_count() +
           static_cast<Eigen::Index>(problem_.segments.size()) * problem_.own_count();
  }

  Eigen::RowVectorXd packed(const FitPoint& point) const {
    Eigen::RowVectorXd all(unknowns());
    all.head(problem_.shared_count()) = point.shared.transpose();
    for (std::size_t k = 0; k < point.own.size(); ++k) {
      all.segment(problem_.shared_count() + static_cast<Eigen::Index>(k) * problem_.own_count(),
                  problem_.own_count()) = point.own[k].transpose();
    }
    return all;
  }

  Eigen::VectorXd normals() {
    Eigen::VectorXd numbers(directions_.cols());
    for (double& number : numbers) number = random_.normal();
    return numbers;
  }

  /// Near the answer, or at it where there is no trajectory beside it.
  void begin(const FitPoint& answer) {
    for (const double apart : {1.0, 0.3, 0.0}) {
      place_.point = answer;
      Eigen::VectorXd momentum = normals();
      drift(place_.point, momentum, apart);
      evaluate(place_);
      if (std::isfinite(place_.potential)) return;
    }
  }

  /// The steps along the directions of all unknowns that lead from the answer to the place.
  Eigen::VectorXd steps_from(const FitPoint& answer) const {
    const DirectionLayout& layout = density_.layout();
    Eigen::VectorXd steps(layout.all);
    Eigen::VectorXd shared(layout.shared), own(layout.own);
    problem_.shared_chart.minus(place_.point.shared.data(), answer.shared.data(), shared.data());
    steps.head(layout.shared) = shared;
    for (std::size_t k = 0; k < answer.own.size(); ++k) {
      problem_.own_chart.minus(place_.point.own[k].data(), answer.own[k].data(), own.data());
      steps.segment(layout.first_of(k), layout.own) = own;
    }
    return steps;
  }

  /// Directions in which what was seen has a deviation of one, drawn towards the present ones where it is little.
  void set_directions(const Eigen::MatrixXd& seen) {
    constexpr double kPresent = 10.0;
    const auto count = static_cast<double>(seen.cols());
    const Eigen::MatrixXd whitened =
        directions_.partialPivLu().solve((seen.colwise() - seen.rowwise().mean()).eval());
    Eigen::MatrixXd covariance = whitened * whitened.transpose() / (count + kPresent);
    covariance.diagonal().array() += kPresent / (count + kPresent);
    directions_ = directions_ * Eigen::MatrixXd(covariance.llt().matrixL());
    evaluate(place_);
  }

  /// Along the momentum for a time; walls of the box turn it as mirrors do, in directions of deviation one, where
  /// they are planes.
  void drift(FitPoint& point, Eigen::VectorXd& momentum, double time) const {
    constexpr int kMostMirrors = 1000;
    for (int mirrors = 0; mirrors < kMostMirrors && time > 0.0; ++mirrors) {
      const Eigen::VectorXd velocity = directions_ * momentum;
      const BoxedDirection* wall = nullptr;
      double until = time;
      for (const BoxedDirection& boxed : density_.boxed()) {
        const double meets = boxed.time_to_wall(point, velocity[boxed.direction]);
        if (meets < until) {
          wall = &boxed;
          until = meets;
        }
      }
      move(point, until * velocity);
      if (wall == nullptr) return;
      const Eigen::VectorXd normal = directions_.row(wall->direction).transpose();
      momentum -= 2.0 * normal.dot(momentum) / normal.squaredNorm() * normal;
      time -= until;
    }
  }

  void move(FitPoint& point, const Eigen::VectorXd& step) const {
    const DirectionLayout& layout = density_.layout();
    const FitPoint from = point;
    const Eigen::VectorXd shared = step.head(layout.shared);
    problem_.shared_chart.plus(from.shared.data(), shared.data(), point.shared.data());
    for (std::size_t k = 0; k < point.own.size(); ++k) {
      const Eigen::VectorXd own = step.segment(layout.first_of(k), layout.own);
      problem_.own_chart.plus(from.own[k].data(), own.data(), point.own[k].data());
    }
    // Rounding must not lead a family out of its box.
    for (const BoxedDirection& b : density_.boxed()) {
      const auto& coordinate =
          (b.is_shared ? problem_.shared : problem_.own)[static_cast<std::size_t>(b.unknown)];
      double& value = (b.is_shared ? point.shared : point.own[b.segment])[b.unknown];
      value = std::clamp(value, coordinate.lower, coordinate.upper);
    }
  }

  void evaluate(Place& place) {
    Eigen::VectorXd slope;
    place.potential = density_(place.point, slope);
    if (std::isfinite(place.potential)) place.slope = directions_.transpose() * slope;
  }

  /// One trajectory, taken or not. @returns the probability to take it
  double propose() {
    const double length = kLength * (0.6 + 0.8 * random_.uniform());
    const double wanted = std::ceil(length / step_.value());
    const int steps = wanted < kMostSteps ? std::max(1, static_cast<int>(wanted)) : kMostSteps;
    const double h = std::min(length / steps, step_.value());
    Eigen::VectorXd momentum = normals();
    Place place = place_;
    const double before = place.potential + 0.5 * momentum.squaredNorm();
    for (int k = 0; k < steps && std::isfinite(place.potential); ++k) {
      momentum -= 0.5 * h * place.slope;
      drift(place.point, momentum, h);
      evaluate(place);
      if (std::isfinite(place.potential)) momentum -= 0.5 * h * place.slope;
    }
    const double choice = random_.uniform();  // drawn in any case: proposals do not shift the stream
    if (!std::isfinite(place.potential)) return 0.0;
    const double gain = before - place.potential - 0.5 * momentum.squaredNorm();
    if (!(gain > -kDivergent)) ++divergences_;
    const double probability = std::min(1.0, std::exp(gain));
    if (choice < probability) place_ = std::move(place);
    return probability;
  }

  PosteriorDensity density_;
  const FitProblem& problem_;
  Eigen::MatrixXd directions_;  ///< of deviation one, in columns
  Stream random_;
  StepSize step_;
  Place place_;
  int divergences_ = 0;
};

/// Names of the unknowns: coefficients, then those of every segment by the capture it is of.
std::vector<std::string> names_of(const FitProblem& problem) {
  std::vector<std::string> names;
  for (const models::FamilyCoordinate& c : problem.shared) names.push_back(c.name);
  for (const Segment& segment : problem.segments) {
    const Motion& motion = problem.motion_of(segment);
    const std::string of =
        motion.segment_count > 1 ? motion.id + " at " + std::to_string(segment.start) : motion.id;
    for (const models::FamilyCoordinate& c : problem.own) names.push_back(of + ": " + c.name);
    for (const std::string& offset : problem.offsets) names.push_back(of + ": offset of " + offset);
    for (int k = 0; k < problem.camera_count(); ++k)
      names.push_back(of + ": camera " + std::to_string(k + 1));
  }
  return names;
}

PosteriorUnknown summary_of(std::string name, const std::vector<ChainResult>& chains, Eigen::Index column) {
  const Eigen::Index draws = chains.front().draws.rows();
  Eigen::MatrixXd values(draws, static_cast<Eigen::Index>(chains.size()));
  for (std::size_t c = 0; c < chains.size(); ++c)
    values.col(static_cast<Eigen::Index>(c)) = chains[c].draws.col(column);
  const ChainSummary chain = summarize_chains(values);
  std::vector<double> sorted(values.data(), values.data() + values.size());
  std::ranges::sort(sorted);
  const auto quantile = [&](double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<std::size_t>(place);
    const double rest = place - static_cast<double>(below);
    return (1.0 - rest) * sorted[below] + rest * sorted[std::min(below + 1, sorted.size() - 1)];
  };
  const double mean = values.mean();
  const double variance = (values.array() - mean).square().sum() / static_cast<double>(values.size() - 1);
  return {std::move(name), mean,       std::sqrt(variance), quantile(0.025), quantile(0.5),
          quantile(0.975), chain.rhat, chain.effective};
}

}  // namespace

Outcome<Posterior> sample_posterior(const models::TrajectoryFamily& family, const FitProblem& problem,
                                    const std::vector<SegmentResidual>& residuals, const FitPoint& point,
                                    double dispersion, const PosteriorOptions& options) {
  const auto none = [](Termination status, std::string why) { return Ending{status, std::move(why)}; };
  if (!(dispersion > 0.0) || !std::isfinite(dispersion))
    return none(Termination::not_determined, "the residuals leave nothing to tell the noise from");
  PosteriorDensity at_answer(family, problem, residuals, dispersion);
  const Eigen::Index count = at_answer.layout().all;
  if (count == 0) return none(Termination::not_determined, "nothing is unknown");
  if (count > kMostDirections)
    return none(Termination::exhausted,
                fmt::format("{} unknowns of all captures together are more than the {} that it can draw",
                            count, kMostDirections));
  Eigen::VectorXd slope;
  if (!std::isfinite(at_answer(point, slope)))
    return none(Termination::not_finite, "its density at the answer is not finite");
  const Eigen::LLT<Eigen::MatrixXd> factor(at_answer.curvature(point));
  if (factor.info() != Eigen::Success)
    return none(Termination::not_determined, "the curvature at the answer is not that of a minimum");
  const Eigen::MatrixXd directions = factor.matrixU().solve(Eigen::MatrixXd::Identity(count, count));

  std::vector<ChainResult> chains(kChains);
  const int draws = std::max((options.samples + kChains - 1) / kChains, 4);
  parallel_for(kChains, [&](int c) {
    Chain chain(PosteriorDensity(family, problem, residuals, dispersion), problem, directions,
                Stream(options.seed, static_cast<std::uint64_t>(c)));
    chains[static_cast<std::size_t>(c)] = chain.run(point, draws);
  });

  Posterior result{.chains = kChains, .seed = options.seed};
  const Eigen::Index unknowns = chains.front().draws.cols();
  result.draws.resize(draws * kChains, unknowns);
  for (int c = 0; c < kChains; ++c) {
    const ChainResult& chain = chains[static_cast<std::size_t>(c)];
    result.draws.middleRows(c * draws, draws) = chain.draws;
    result.acceptance += chain.acceptance / kChains;
    result.divergences += chain.divergences;
    result.evaluations += chain.evaluations;
  }
  const std::vector<std::string> names = names_of(problem);
  for (Eigen::Index k = 0; k < unknowns; ++k)
    result.unknowns.push_back(summary_of(names[static_cast<std::size_t>(k)], chains, k));
  return result;
}

}  // namespace samara::identification
