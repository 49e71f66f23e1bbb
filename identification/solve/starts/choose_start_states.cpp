#include "samara/identification/solve/starts/choose_start_states.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Cholesky>

#include "samara/base/parallel.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/smoothing/medians.h"
#include "samara/identification/solve/starts/states_from_frames.h"
#include "samara/identification/statistics/loss.h"

namespace samara::identification {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// From frames that nearly touch, for bodies that turn fast, to a bandwidth that averages much noise away.
constexpr std::array kSmoothings = {StartSmoothing{2, 5}, StartSmoothing{3, 7}, StartSmoothing{3, 9},
                                    StartSmoothing{4, 15}};
/// Where attitudes are free and were not measured: as the pushes of the fluid say, at rest or turning, and
/// tilted against them.
constexpr double kTilt = 0.5;
constexpr std::array kGuesses = {StartSmoothing{3, 9, AttitudeGuess{true}},
                                 StartSmoothing{4, 15, AttitudeGuess{true}},
                                 StartSmoothing{3, 9, AttitudeGuess{}},
                                 StartSmoothing{4, 15, AttitudeGuess{}},
                                 StartSmoothing{4, 15, AttitudeGuess{false, kTilt, 0.0}},
                                 StartSmoothing{4, 15, AttitudeGuess{false, -kTilt, 0.0}},
                                 StartSmoothing{4, 15, AttitudeGuess{false, 0.0, kTilt}},
                                 StartSmoothing{4, 15, AttitudeGuess{false, 0.0, -kTilt}}};
constexpr int kTrialIterations = 4;
/// Of candidates beside states that were fitted: with the same patience these would always win.
constexpr int kRivalIterations = 12;
constexpr int kIterationsOfStates = 15;
/// A segment whose cost is so many times the median has not found its motion.
constexpr double kFarAbove = 4.0;
constexpr int kFirstFrames = 4;

/// How many residuals belong to the first frames, and where: observations first, then attitudes, both in the
/// order of frames. Priors count with every number of frames.
struct ComparedRows {
  Eigen::Index values = 0;
  Eigen::Index turns_begin = 0, turns = 0;
  Eigen::Index priors_begin = 0, priors = 0;
};

ComparedRows rows_of(const SegmentResidual& residual, int frames) {
  const Segment& segment = residual.segment();
  ComparedRows rows;
  rows.values =
      std::ranges::count_if(segment.observations, [&](const Observation& o) { return o.frame < frames; });
  rows.turns_begin = static_cast<Eigen::Index>(segment.observations.size());
  rows.turns = 3 * std::ranges::count_if(segment.attitudes,
                                         [&](const AttitudeObservation& a) { return a.frame < frames; });
  rows.priors_begin = residual.data_size();
  rows.priors = residual.prior_size();
  return rows;
}

/// One segment as a small problem of its own.
class OwnProblem {
 public:
  OwnProblem(const FitProblem& problem, SegmentResidual& residual, const Eigen::VectorXd& shared,
             const Eigen::VectorXd& own, int frames)
      : problem_(problem),
        residual_(residual),
        shared_(shared),
        next_(own),
        rows_(rows_of(residual, frames)) {}

  /// 1/2 sum rho, infinite where a residual, or a slope that is wanted, is not finite; slopes are filled for gradient
  /// and normal.
  double evaluate(const Eigen::VectorXd& own, bool with_derivatives) {
    const double* next = residual_.segment().joined ? next_.data() : nullptr;
    if (!residual_.evaluate(shared_.data(), own.data(), next, with_derivatives)) return kInfinity;
    double sum = 0.0;
    psi_.resize(rows_.values + rows_.turns + rows_.priors);
    for (Eigen::Index k = 0; k < rows_.values + rows_.turns; ++k) {
      const LossValue value = loss_value(problem_.loss, residual_.residual()[row(k)]);
      sum += 0.5 * value.rho;
      psi_[k] = value.psi;
    }
    psi_.tail(rows_.priors) = residual_.residual().segment(rows_.priors_begin, rows_.priors);
    sum += 0.5 * psi_.tail(rows_.priors).squaredNorm();
    return sum;
  }

  /// After evaluate() with derivatives there.
  void linearise(const Eigen::VectorXd& own, Eigen::MatrixXd& normal, Eigen::VectorXd& gradient) const {
    Eigen::MatrixXd moves = problem_.own_chart.plus_jacobian(own.data());
    // One segment alone cannot tell a camera, or a delay, from a start.
    for (int unknown = 0; unknown < problem_.own_count(); ++unknown) {
      if (is_of_measurement(problem_, unknown)) moves.row(unknown).setZero();
    }
    Eigen::MatrixXd J(psi_.size(), moves.cols());
    J.topRows(rows_.values) = residual_.by_own().topRows(rows_.values) * moves;
    J.middleRows(rows_.values, rows_.turns) =
        residual_.by_own().middleRows(rows_.turns_begin, rows_.turns) * moves;
    J.bottomRows(rows_.priors) = residual_.by_own().middleRows(rows_.priors_begin, rows_.priors) * moves;
    normal = J.transpose() * J;
    gradient = J.transpose() * psi_;
  }

  /// `own` moved by a step, back into its box.
  void move(const Eigen::VectorXd& own, const Eigen::VectorXd& step, Eigen::VectorXd& to) const {
    problem_.own_chart.plus(own.data(), step.data(), to.data());
    for (std::size_t k = 0; k < problem_.own.size(); ++k) {
      if (problem_.own_chart.is_part_of_quaternion(static_cast<int>(k))) continue;
      double& value = to[static_cast<Eigen::Index>(k)];
      value = std::clamp(value, problem_.own[k].lower, problem_.own[k].upper);
    }
  }

 private:
  Eigen::Index row(Eigen::Index k) const {
    return k < rows_.values ? k : rows_.turns_begin + k - rows_.values;
  }

  const FitProblem& problem_;
  SegmentResidual& residual_;
  const Eigen::VectorXd& shared_;
  Eigen::VectorXd next_;  ///< anything: what it says is not looked at
  ComparedRows rows_;
  Eigen::VectorXd psi_;
};

/// The best of the candidates for one segment.
double choose(const FitProblem& problem, SegmentResidual& residual, const Eigen::VectorXd& shared,
              const std::vector<std::vector<Eigen::VectorXd>>& candidates, std::size_t segment,
              int trial_iterations, Eigen::VectorXd& best) {
  const auto frames = static_cast<int>(residual.segment().times.size());
  double lowest = kInfinity;
  for (const auto& candidate : candidates) {
    Eigen::VectorXd own = candidate[segment];
    const double cost = minimize_own(problem, residual, shared, own, frames, trial_iterations);
    if (cost < lowest || best.size() == 0) best = own;
    lowest = std::min(lowest, cost);
  }
  return minimize_own(problem, residual, shared, best, frames, kIterationsOfStates);
}

/// The best of the candidates, each grown from its first frames.
double grow(const FitProblem& problem, SegmentResidual& residual, const Eigen::VectorXd& shared,
            const std::vector<std::vector<Eigen::VectorXd>>& candidates, std::size_t segment, double cost,
            Eigen::VectorXd& best) {
  const auto frames = static_cast<int>(residual.segment().times.size());
  for (const auto& candidate : candidates) {
    Eigen::VectorXd own = candidate[segment];
    double reached = kInfinity;
    for (int some = kFirstFrames; some < frames + 2; some += 2) {
      reached = minimize_own(problem, residual, shared, own, std::min(some, frames), kTrialIterations);
    }
    if (reached < cost) best = own;
    cost = std::min(cost, reached);
  }
  return cost;
}

/// What a segment costs that has not found its motion, at least: by those that have a trajectory.
double far_above(std::vector<double> costs) {
  std::erase(costs, kInfinity);
  return costs.empty() ? std::numeric_limits<double>::max() : kFarAbove * median(std::move(costs));
}

}  // namespace

double minimize_own(const FitProblem& problem, SegmentResidual& residual, const Eigen::VectorXd& shared,
                    Eigen::VectorXd& own, int frames, int max_iterations) {
  OwnProblem segment(problem, residual, shared, own, frames);
  double cost = segment.evaluate(own, true);
  if (!(cost < kInfinity)) return kInfinity;
  if (problem.own_chart.directions() == 0) return cost;
  double damping = 1e-3;
  Eigen::VectorXd trial = own;
  Eigen::MatrixXd normal;
  Eigen::VectorXd gradient;
  for (int iteration = 0; iteration < max_iterations; ++iteration) {
    segment.linearise(own, normal, gradient);
    const Eigen::VectorXd diagonal = normal.diagonal().cwiseMax(1e-12 * normal.diagonal().maxCoeff());
    const double before = cost;
    for (; cost == before && damping < 1e8; damping *= cost < before ? 0.1 : 5.0) {
      normal.diagonal() = diagonal * (1.0 + damping);
      segment.move(own, -normal.ldlt().solve(gradient), trial);
      const double reached = segment.evaluate(trial, false);
      if (!(reached < before) || segment.evaluate(trial, true) == kInfinity) continue;
      cost = reached;
      own = trial;
    }
    if (before - cost < 1e-4 * before) break;
  }
  return cost;
}

void choose_start_states(const models::ParametricModel& equations, const FitProblem& problem,
                         std::vector<SegmentResidual>& residuals, FitPoint& point, bool also_point) {
  // Per smoothing and segment.
  std::vector<std::vector<Eigen::VectorXd>> candidates;
  const bool must_guess = problem.own_attitude && !problem.attitude_scale;
  const std::span<const StartSmoothing> smoothings =
      must_guess ? std::span<const StartSmoothing>(kGuesses) : kSmoothings;
  if (also_point) candidates.push_back(point.own);
  for (const StartSmoothing& smoothing : smoothings) {
    std::vector<Eigen::VectorXd>& all = candidates.emplace_back();
    for (const Motion& motion : problem.motions) {
      for (auto& own : states_from_frames(equations, problem, motion, point.shared, smoothing)) {
        all.push_back(std::move(own));
      }
    }
  }
  std::vector<double> costs(residuals.size());
  std::vector<Eigen::VectorXd> chosen(residuals.size());
  parallel_for(residuals.size(), [&](std::size_t k) {
    const int trials = also_point ? kRivalIterations : kTrialIterations;
    costs[k] = choose(problem, residuals[k], point.shared, candidates, k, trials, chosen[k]);
  });
  const double limit = far_above(costs);
  parallel_for(residuals.size(), [&](std::size_t k) {
    if (costs[k] > limit) grow(problem, residuals[k], point.shared, candidates, k, costs[k], chosen[k]);
  });
  point.own = std::move(chosen);
}

}  // namespace samara::identification
