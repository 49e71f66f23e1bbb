#include "samara/motion/planning/planner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/integrators/integrate.h"
#include "samara/motion/planning/window_search.h"

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

class Planner {
 public:
  Planner(const MotionPlan& plan, const ProgressCallback& progress)
      : plan_(plan), fall_(plan), progress_([this, &progress](const Progress& report) {
          if (progress && !progress(report)) cancelled_ = true;
          return !cancelled_;
        }) {}

  MotionResult run() {
    if (!search({}, fall_.release())) return cancelled_ ? cancelled() : result_;
    for (int round = 0; round < kMostClosings; ++round) {
      std::size_t kept = 0;
      const auto from = parting(fall_, real_, knots_, *course_, kept);
      if (!from) break;
      const std::vector<CourseKnot> head(knots_.begin(), knots_.begin() + static_cast<std::ptrdiff_t>(kept));
      ++result_.closings;
      if (!search(head, *from)) break;
    }
    if (cancelled_) return cancelled();
    finish();
    return result_;
  }

 private:
  MotionResult cancelled() const {
    MotionResult none;
    none.status = MotionStatus::cancelled;
    none.message = "cancelled before the search was over";
    none.history = result_.history;
    return none;
  }

  /// The rest of a fall, from a state that was reached. @returns false if there is none
  bool search(const std::vector<CourseKnot>& head, const FallPoint& start) {
    BeamResult beam = search_beam(fall_, start, progress_);
    result_.history.insert(result_.history.end(), beam.history.begin(), beam.history.end());
    if (beam.cancelled || beam.lost) {
      if (course_) return false;  // what there was before stays
      result_.status = MotionStatus::lost;
      result_.message = "no fall came to the ground: its numbers were not finite, or it took too long";
      return false;
    }
    FoundFall best = beam.falls.front();
    // Windows know nothing of what turbulence costs.
    if (plan_.sketch && !(plan_.turbulence > 0.0))
      best = refine_in_windows(fall_, start, best, progress_, result_.history);
    if (cancelled_) return false;
    std::vector<CourseKnot> knots = head;
    knots.insert(knots.end(), best.knots.begin(), best.knots.end());
    CoefficientCourse course(fall_.names(), fall_.natural(), knots);
    RealisedFall real = realise(plan_, course, best.end.t + 4.0 * fall_.longest_piece());
    if (course_ && !(score(real) < score(real_))) return false;
    knots_ = std::move(knots);
    course_ = std::move(course);
    real_ = std::move(real);
    return true;
  }

  static double score(const RealisedFall& real) {
    return real.is_over ? real.deviation + real.landing_miss : std::numeric_limits<double>::infinity();
  }

  void finish() {
    if (real_.times.size() == 0) {
      result_.status = MotionStatus::lost;
      result_.message = "the motion that was found is not finite when it is integrated";
      return;
    }
    result_.course = course_;
    result_.times = real_.times;
    result_.states = real_.states;
    result_.end = real_.times[real_.times.size() - 1];
    result_.deviation = real_.deviation;
    result_.landing_miss = real_.landing_miss;
    const auto& info = plan_.model->info();
    const auto in = [](double value, const std::string& unit) {
      return unit == "1" ? fmt::format("{:.4g}", value) : fmt::format("{:.4g} {}", value, unit);
    };
    const std::string length = std::ranges::find(info.states, "x", &models::StateInfo::name)->unit;
    const std::string time = models::time_unit(info);
    double miss = 0.0;
    std::string distances;
    if (plan_.sketch) {
      miss = real_.deviation;
      distances = in(real_.deviation, length) + " rms from the sketch";
    }
    if (plan_.landing) {
      miss = std::max(miss, real_.landing_miss);
      distances += fmt::format("{}{} from the landing place", distances.empty() ? "" : ", ",
                               in(real_.landing_miss, length));
    }
    result_.status = MotionStatus::found;
    result_.message = distances;
    if (!real_.is_over || (plan_.landing && !real_.landed)) {
      const Eigen::VectorXd state = real_.states.row(real_.states.rows() - 1);
      const double height =
          fall_.states().position({state.data(), static_cast<std::size_t>(state.size())}).z() - plan_.ground;
      result_.status = MotionStatus::not_landed;
      result_.message = fmt::format("{} above the ground after {}; {}", in(height, length),
                                    in(result_.end, time), distances);
    } else if (plan_.duration && result_.end < *plan_.duration * (1.0 - 1e-9)) {
      result_.status = MotionStatus::landed_early;
      result_.message = fmt::format("on the ground after {}, expected {}", in(result_.end, time),
                                    in(*plan_.duration, time));
    } else if (plan_.deviation && miss > *plan_.deviation) {
      result_.status = MotionStatus::deviation_missed;
      result_.message = fmt::format("{}; {} was asked", distances, in(*plan_.deviation, length));
    }
  }

  const MotionPlan& plan_;
  PlannedFall fall_;
  ProgressCallback progress_;  ///< the one given, remembering that it cancelled
  bool cancelled_ = false;
  std::vector<CourseKnot> knots_;
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
  double square_time = 0.0;
  Eigen::Vector3d before = Eigen::Vector3d::Zero();
  for (Eigen::Index row = 0; row < times.size() && times[row] <= motion.reached; ++row) {
    const Eigen::VectorXd state = motion.states.row(row);
    const Eigen::Vector3d place =
        fall.states().position({state.data(), static_cast<std::size_t>(state.size())});
    const Eigen::Vector3d deviation = fall.deviation(times[row], place);
    if (row > 0) square_time += 0.5 * h * (before.squaredNorm() + deviation.squaredNorm());
    before = deviation;
    real.landed = place.z() <= plan.ground;
    real.is_over = fall.is_over(times[row], place.z());
    if (!real.is_over && row + 1 < times.size()) continue;
    real.times = times.head(row + 1);
    real.states = motion.states.topRows(row + 1);
    real.deviation = row > 0 ? std::sqrt(square_time / times[row]) : 0.0;
    if (plan.landing) real.landing_miss = (place - *plan.landing).head<2>().norm();
    break;
  }
  return real;
}

MotionResult plan_motion(const MotionPlan& plan, const ProgressCallback& progress) {
  check(plan);
  const auto start = std::chrono::steady_clock::now();
  MotionResult result = Planner(plan, progress).run();
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

}  // namespace samara::motion
