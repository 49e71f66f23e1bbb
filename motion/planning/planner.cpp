#include "samara/motion/planning/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/integrators/integrate.h"
#include "samara/motion/planning/fall_cost.h"
#include "samara/motion/planning/motion_judgement.h"
#include "samara/motion/planning/planning_state.h"

namespace samara::motion {

namespace {

/// Rounds of searching the rest of a fall again.
constexpr int kMostClosings = 6;
/// Semi-lengths between the motion of the steps and that of CVODES from which on the plan is no plan any more.
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
}

/// The first row of a motion at which it has parted from the steps that planned it.
std::optional<FallPoint> parting(const PlannedFall& fall, const RealisedFall& real,
                                 const std::vector<CourseKnot>& knots, const CoefficientCourse& course,
                                 std::size_t& kept) {
  const ReplayedFall planned = replay(fall, fall.release(), knots);
  std::optional<FallPoint> last;
  for (std::size_t k = 0; k < planned.at_knots.size(); ++k) {
    const FallPoint& point = planned.at_knots[k];
    const auto row = static_cast<Eigen::Index>(std::lround(point.t / fall.plan().search.step));
    if (row >= real.times.size()) break;
    FallPoint here = point;
    for (std::size_t i = 0; i < here.state.size(); ++i)
      here.state[i] = real.states(row, static_cast<Eigen::Index>(i));
    const Eigen::Vector3d place = fall.states().position(here.state);
    const double apart = (place - fall.states().position(point.state)).norm() / fall.semi_length();
    if (apart > kParted) return last;
    here.height = place.z();
    course.values(point.t, {}, here.coefficients);
    kept = k;
    last = here;
  }
  return std::nullopt;
}

/// Numbers that the course has cost by its steps, in the place of the motion that CVODES gives.
FallCost cost_of_motion(const PlannedFall& fall, const RealisedFall& real, FallPoint end) {
  if (real.times.size() == 0) return {.path = std::numeric_limits<double>::infinity()};
  const Eigen::Index last = real.times.size() - 1;
  end.t = real.times[last];
  for (std::size_t i = 0; i < end.state.size(); ++i)
    end.state[i] = real.states(last, static_cast<Eigen::Index>(i));
  end.height = fall.states().position(end.state).z();
  end.square_time = real.square_time;
  end.kinds = 0.0;
  end.events = 0;
  end.past.clear();
  for (const Event& event : events_of_motion(fall, real).events)
    add_event(fall, end, event.is_steady ? std::optional<EventKind>() : event.kind);
  return cost_of(fall, end);
}

class Planner {
 public:
  Planner(const MotionPlan& plan, const PlanningOptions& options)
      : plan_(plan), fall_(plan), options_(options), progress_([this](const Progress& report) {
          if (options_.progress && !options_.progress(report)) cancelled_ = true;
          return !cancelled_;
        }) {}

  MotionResult run() {
    begin();
    while (search()) {
      std::size_t kept = 0;
      const auto from = parting(fall_, real_, state_.knots, *course_, kept);
      if (!from || state_.closings == kMostClosings) break;
      ++state_.closings;
      state_.head.assign(state_.knots.begin(), state_.knots.begin() + static_cast<std::ptrdiff_t>(kept));
      state_.start = *from;
      state_.beam = BeamState::from(*from);
      state_.refining.reset();
    }
    if (cancelled_) return cancelled();
    if (!options_.checkpoint.empty()) {
      std::error_code ignored;
      std::filesystem::remove(options_.checkpoint, ignored);
    }
    result_.history = state_.history;
    result_.closings = state_.closings;
    if (course_) {
      result_.course = course_;
      judge_motion(fall_, real_, result_);
    }
    return result_;
  }

 private:
  using Clock = std::chrono::steady_clock;

  void begin() {
    std::error_code ignored;
    if (!options_.checkpoint.empty() && std::filesystem::exists(options_.checkpoint, ignored)) {
      state_ = load_state(plan_, options_.checkpoint);
      if (!state_.knots.empty() || state_.longest > 0.0) realise_knots(state_.knots, state_.longest);
      return;
    }
    state_.start = fall_.release();
    state_.beam = BeamState::from(state_.start);
  }

  void keep(bool is_last) {
    if (options_.checkpoint.empty()) return;
    if (!is_last && Clock::now() - kept_ < std::chrono::seconds(10)) return;
    save_state(state_, plan_, options_.checkpoint);
    kept_ = Clock::now();
  }

  MotionResult cancelled() {
    keep(true);
    MotionResult none;
    none.status = MotionStatus::cancelled;
    none.message = "cancelled before the search was over";
    none.history = state_.history;
    none.history.insert(none.history.end(), state_.beam.history.begin(), state_.beam.history.end());
    return none;
  }

  /// The search that is under way, to its end. @returns whether the fall is a better one
  bool search() {
    const BeamResult beam = search_beam(fall_, state_.beam, progress_, [this] { keep(false); });
    if (beam.cancelled) return false;
    if (!beam.lost.empty()) {
      append(state_.beam.history);
      if (course_) return false;  // what there was before stays
      result_.status = MotionStatus::lost;
      result_.message = "no fall came to the ground, or to its end: " + beam.lost;
      return false;
    }
    FoundFall best = beam.falls.front();
    if (plan_.sketch || plan_.landing || plan_.turbulence > 0.0) {
      if (!state_.refining) state_.refining = RefiningState::from(fall_, state_.start, best);
      if (!refine_in_windows(fall_, state_.start, *state_.refining, progress_, [this] { keep(false); }))
        return false;
      best = state_.refining->best;
    }
    append(state_.beam.history);
    if (state_.refining) append(state_.refining->history);
    std::vector<CourseKnot> knots = state_.head;
    knots.insert(knots.end(), best.knots.begin(), best.knots.end());
    return take(std::move(knots), best.end.t + 4.0 * fall_.longest_piece());
  }

  void append(const std::vector<PlanningStep>& steps) {
    state_.history.insert(state_.history.end(), steps.begin(), steps.end());
  }

  void realise_knots(const std::vector<CourseKnot>& knots, double longest) {
    course_.emplace(fall_.names(), fall_.natural(), knots);
    real_ = realise(plan_, *course_, longest);
    result_.cost = cost_of_motion(fall_, real_, replay(fall_, fall_.release(), knots).end);
  }

  bool take(std::vector<CourseKnot> knots, double longest) {
    const std::optional<CoefficientCourse> course = course_;
    const RealisedFall real = real_;
    const FallCost cost = result_.cost;
    realise_knots(knots, longest);
    const auto worth = [](const RealisedFall& motion, const FallCost& of) {
      return motion.is_over ? of.total() : std::numeric_limits<double>::infinity();
    };
    if (course && !(worth(real_, result_.cost) < worth(real, cost))) {
      course_ = course;
      real_ = real;
      result_.cost = cost;
      return false;
    }
    state_.knots = std::move(knots);
    state_.longest = longest;
    return true;
  }

  const MotionPlan& plan_;
  PlannedFall fall_;
  const PlanningOptions& options_;
  ProgressCallback progress_;  ///< the one given, remembering that it cancelled
  bool cancelled_ = false;
  Clock::time_point kept_ = Clock::now();
  PlanningState state_;
  std::optional<CoefficientCourse> course_;
  RealisedFall real_;
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

RealisedFall realise(const MotionPlan& plan, const CoefficientCourse& course, double longest) {
  const PlannedFall fall(plan);
  std::map<std::string, double> fixed = plan.fixed;
  for (const std::string& name : course.followed()) fixed.erase(name);
  // Through the file's form: what is replayed from there takes the same numbers.
  const codebooks::Codebook book = course_codebook(course, plan.model->info(), fixed, longest);
  const models::ParametricModel model(
      models::following(plan.model, identification::codebook_course(book, plan.model->info())), fixed, {});
  const double h = plan.search.step;
  const auto most = static_cast<Eigen::Index>(std::floor(longest / h));
  const Eigen::VectorXd times = h * Eigen::VectorXd::LinSpaced(most + 1, 0.0, static_cast<double>(most));
  const models::Trajectory motion =
      models::integrate(model, {}, {times.data(), static_cast<std::size_t>(times.size())});
  RealisedFall real;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (Eigen::Index row = 0; row < times.size() && times[row] <= motion.reached; ++row) {
    const Eigen::VectorXd state = motion.states.row(row);
    const Eigen::Vector3d place =
        fall.states().position({state.data(), static_cast<std::size_t>(state.size())});
    const Eigen::Vector3d deviation = fall.deviation(times[row], place);
    if (row > 0) real.square_time += 0.5 * h * (before.squaredNorm() + deviation.squaredNorm());
    before = deviation;
    real.landed = place.z() <= plan.ground;
    real.is_over = fall.is_over(times[row], place.z());
    if (!real.is_over && row + 1 < times.size()) continue;
    real.times = times.head(row + 1);
    real.states = motion.states.topRows(row + 1);
    real.deviation = row > 0 ? std::sqrt(real.square_time / times[row]) : 0.0;
    if (plan.landing) real.landing_miss = (place - *plan.landing).head<2>().norm();
    break;
  }
  return real;
}

MotionResult plan_motion(const MotionPlan& plan, const PlanningOptions& options) {
  check(plan);
  const auto start = std::chrono::steady_clock::now();
  MotionResult result = Planner(plan, options).run();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace samara::motion
