#include "samara/motion/planning/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/integrators/integrate.h"
#include "samara/motion/planning/book_tangents.h"
#include "samara/motion/planning/fall_cost.h"
#include "samara/motion/planning/motion_judgement.h"
#include "samara/motion/planning/planning_state.h"

namespace samara::motion {

namespace {

/// Semi-lengths between the motion of the steps and that of CVODES from which on they have parted.
constexpr double kParted = 0.1;

void check(const MotionPlan& plan) {
  require_positive(plan.search.step, "step");
  require_positive(plan.search.ramp, "ramp");
  require(plan.search.beam >= 1, "beam", plan.search.beam, "at least 1");
  require(plan.search.children >= 2, "children", plan.search.children, "at least 2");
  require(plan.search.sweeps >= 0, "sweeps", plan.search.sweeps, "0 or more");
  require(!plan.box.empty(), "number of coefficients that may change", plan.box.size(), "1 or more");
  require_not_negative(plan.turbulence, "intensity of turbulence");
  if (!(plan.steps() <= MotionPlan::kMostSteps))
    throw ArgumentError(
        fmt::format("a step of {} makes about {:.3g} steps of the fall, expected at most {:.0e}",
                    plan.search.step, plan.steps(), MotionPlan::kMostSteps));
  if (plan.duration) require_positive(*plan.duration, "duration");
  if (!plan.sinks())
    throw ArgumentError("the body does not begin to sink when it is let go at rest, expected one that falls");
  for (const SteeredCoefficient& c : plan.box) {
    if (c.lower < c.upper && c.natural >= c.lower && c.natural <= c.upper) continue;
    throw ArgumentError(
        fmt::format("the range of {} is {} to {}, expected it to hold {}, which the body has by itself",
                    c.name, c.lower, c.upper, c.natural));
  }
  if (plan.codebook) const BookTangents refuses_what_it_must(plan);
}

/// As MotionResult::replayed_until: through the form that its file has.
double replayed_until(const PlannedFall& fall, const CoefficientCourse& course, const RealisedFall& real) {
  const MotionPlan& plan = fall.plan();
  std::map<std::string, double> fixed = plan.fixed;
  for (const std::string& name : course.followed()) fixed.erase(name);
  const double end = real.times[real.times.size() - 1];
  const codebooks::Codebook book = course_codebook(course, plan.model->info(), fixed, end);
  const models::ParametricModel model(
      models::following(plan.model, identification::codebook_course(book, plan.model->info())), fixed, {});
  const models::Trajectory replayed =
      models::integrate(model, {}, {real.times.data(), static_cast<std::size_t>(real.times.size())});
  const auto place = [&](const Eigen::MatrixXd& states, Eigen::Index row) {
    const Eigen::VectorXd state = states.row(row);
    return fall.states().position({state.data(), static_cast<std::size_t>(state.size())});
  };
  Eigen::Index row = 0;
  for (; row < real.times.size() && real.times[row] <= replayed.reached; ++row) {
    const double apart = (place(real.states, row) - place(replayed.states, row)).norm();
    if (!(apart <= kParted * fall.semi_length())) break;
  }
  return row == real.times.size() ? end : real.times[std::max<Eigen::Index>(0, row - 1)];
}

RealisedFall realise(const PlannedFall& fall, const CoefficientCourse& course) {
  FallPoint start = fall.release();
  start.coefficients = start.heading_for = course.first();
  std::vector<double> times, rows;
  const ReplayedFall replayed =
      replay(fall, start, course.knots(), [&](double t, std::span<const double> state) {
        times.push_back(t);
        rows.insert(rows.end(), state.begin(), state.end());
      });
  RealisedFall real;
  if (!std::isfinite(replayed.cost)) return real;
  const FallPoint& end = replayed.end;
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  real.times = Eigen::Map<const Eigen::VectorXd>(times.data(), std::ssize(times));
  real.states = Eigen::Map<const Rows>(rows.data(), std::ssize(times), std::ssize(end.state));
  real.deviation = end.t > 0.0 ? std::sqrt(end.square_time / end.t) : 0.0;
  const MotionPlan& plan = fall.plan();
  if (plan.landing) real.landing_miss = (fall.states().position(end.state) - *plan.landing).head<2>().norm();
  real.landed = end.height <= plan.ground;
  real.is_over = fall.is_over(end.t, end.height);
  real.cost = cost_of(fall, end);
  return real;
}

class Planner {
 public:
  Planner(const MotionPlan& plan, const PlanningOptions& options)
      : plan_(plan),
        fall_(plan),
        options_(options),
        progress_([this](const Progress& report) {
          if (options_.progress && !options_.progress(report)) cancelled_ = true;
          return !cancelled_;
        }),
        save_(codebooks::told_once<>([this] { save_state(state_, plan_, options_.checkpoint); },
                                     options.warning)) {}

  MotionResult run() {
    begin();
    const std::optional<FoundFall> found = search();
    if (cancelled_) return cancelled();
    if (!options_.checkpoint.empty() && !options_.keep_checkpoint) {
      std::error_code ignored;
      std::filesystem::remove(options_.checkpoint, ignored);
    }
    result_.history = history();
    if (plan_.codebook) result_.book = state_.refining ? state_.refining->use : BookUse();
    if (!found) return result_;
    result_.course.emplace(fall_.names(), fall_.natural(), found->knots);
    const RealisedFall real = realise(fall_, *result_.course);
    result_.cost = real.cost;
    judge_motion(fall_, real, result_);
    if (result_.is_usable()) result_.replayed_until = replayed_until(fall_, *result_.course, real);
    return result_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void begin() {
    codebooks::check_checkpoint_path(options_.checkpoint, kPlanningCheckpoint);
    if (codebooks::is_checkpoint(options_.checkpoint)) {
      state_ = load_state(plan_, options_.checkpoint);
    } else {
      state_.beam = BeamState::from(fall_.release());
    }
  }

  void keep(bool is_last) {
    if (options_.checkpoint.empty()) return;
    if (!is_last && Clock::now() - kept_ < std::chrono::seconds(10)) return;
    save_();
    kept_ = Clock::now();
  }

  std::vector<PlanningStep> history() const {
    std::vector<PlanningStep> all = state_.beam.history;
    if (state_.refining)
      all.insert(all.end(), state_.refining->history.begin(), state_.refining->history.end());
    return all;
  }

  MotionResult cancelled() {
    keep(true);
    MotionResult none;
    none.status = MotionStatus::cancelled;
    none.message = "cancelled before the search was over";
    none.history = history();
    return none;
  }

  /// None if it was cancelled, or none was found.
  std::optional<FoundFall> search() {
    const BeamResult beam = search_beam(fall_, state_.beam, progress_, [this] { keep(false); });
    if (beam.cancelled) return std::nullopt;
    if (!beam.lost.empty()) {
      result_.status = MotionStatus::lost;
      result_.message = "no fall came to the ground, or to its end: " + beam.lost;
      return std::nullopt;
    }
    if (!plan_.sketch && !plan_.landing && !(plan_.turbulence > 0.0)) return beam.falls.front();
    if (!state_.refining) state_.refining = RefiningState::from(fall_, fall_.release(), beam.falls.front());
    if (!refine_in_windows(fall_, fall_.release(), *state_.refining, progress_, [this] { keep(false); }))
      return std::nullopt;
    return state_.refining->best;
  }

  const MotionPlan& plan_;
  PlannedFall fall_;
  const PlanningOptions& options_;
  ProgressCallback progress_;  ///< the one given, remembering that it cancelled
  std::function<void()> save_;
  bool cancelled_ = false;
  Clock::time_point kept_ = Clock::now();
  PlanningState state_;
  MotionResult result_;
};

}  // namespace

std::string to_string(MotionStatus status) {
  switch (status) {
    case MotionStatus::found:
      return "found";
    case MotionStatus::deviation_missed:
      return "deviation missed";
    case MotionStatus::kinds_missed:
      return "kinds missed";
    case MotionStatus::landed_early:
      return "landed early";
    case MotionStatus::not_landed:
      return "not landed";
    case MotionStatus::lost:
      return "lost";
    case MotionStatus::cancelled:
      break;
  }
  return "cancelled";
}

RealisedFall realise(const MotionPlan& plan, const CoefficientCourse& course) {
  return realise(PlannedFall(plan), course);
}

MotionResult plan_motion(const MotionPlan& plan, const PlanningOptions& options) {
  check(plan);
  const auto start = std::chrono::steady_clock::now();
  MotionResult result = Planner(plan, options).run();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace samara::motion
