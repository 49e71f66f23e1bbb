#include "samara/motion/planning/fall_replay.h"

#include <algorithm>
#include <limits>

#include "samara/motion/planning/fall_cost.h"

namespace samara::motion {

namespace {

/// A fall along knots, with all that its cost is made of.
class Replay {
 public:
  Replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots,
         const SeenSteps& see)
      : fall_(fall),
        knots_(knots),
        see_(see),
        lane_(fall.model(), fall.names(), 1),
        roaming_(fall),
        events_(fall.finder()),
        now_(start),
        begin_(start) {
    lane_.load(0, fall.natural());
    lane_.set_state(0, start.t, start.state);
    lane_.set_parameters(0, start.coefficients);
    events_.see(start.t, start.state);
    if (see_) see_(start.t, start.state);
  }

  ReplayedFall run() {
    const double h = fall_.plan().search.step;
    const double expected = 4.0 * fall_.plan().steps() * h;
    const double most =
        std::max(expected, knots_.empty() ? now_.t : knots_.back().t) + 4.0 * fall_.longest_piece();
    while (!fall_.is_over(now_.t, now_.height) && now_.t < most) {
      const std::size_t next = result_.at_knots.size();
      if (next < knots_.size() && now_.t > knots_[next].t - 0.5 * h) begin_knot(knots_[next]);
      lane_.step(h);
      lane_.read(0, now_.state);
      if (!lane_.finite(0)) {
        result_.cost = std::numeric_limits<double>::infinity();
        return result_;
      }
      move();
    }
    end_piece();
    lane_.read_parameters(0, now_.coefficients);
    result_.end = now_;
    for (FallPoint& point : result_.at_knots) add_events(point);
    add_events(result_.end);
    result_.cost = cost_of(fall_, result_.end).total();
    return result_;
  }

 private:
  void begin_knot(const CourseKnot& knot) {
    end_piece();
    lane_.read_parameters(0, now_.coefficients);
    result_.at_knots.push_back(now_);
    begin_ = now_;
    add_change(fall_, now_, now_.heading_for, knot.values);
    now_.heading_for = knot.values;
    lane_.ramp(0, knot.values, knot.ramp);
    steps_ = looks_ = 0;
    roaming_sum_ = 0.0;
  }

  void end_piece() {
    now_.acceleration_square = looks_ > 0 ? roaming_sum_ / looks_ : 0.0;
    add_piece(fall_, now_, now_.t - begin_.t, begin_.height - now_.height);
  }

  void move() {
    now_.t = lane_.time(0);
    if (see_) see_(now_.t, now_.state);
    const Eigen::Vector3d place = fall_.states().position(now_.state);
    const double before = now_.deviation.squaredNorm();
    now_.height = place.z();
    now_.deviation = fall_.deviation(now_.t, place);
    now_.square_time += 0.5 * fall_.plan().search.step * (before + now_.deviation.squaredNorm());
    if (fall_.turbulence_factor() > 0.0 && steps_++ % kBetweenLooks == 0) {
      roaming_.at(now_.t, now_.state, now_.heading_for, difference_);
      roaming_sum_ += difference_.squaredNorm();
      ++looks_;
    }
    if (!events_.see(now_.t, now_.state)) return;
    const Event& event = events_.event();
    found_.push_back({event.t, event.is_steady ? std::optional<EventKind>() : event.kind});
  }

  /// Events are certain some steps after they were: these are added when all are known.
  void add_events(FallPoint& point) const {
    for (const auto& [t, kind] : found_) {
      if (t <= point.t + fall_.plan().search.step) add_event(fall_, point, kind);
    }
  }

  struct FoundEvent {
    double t = 0.0;
    std::optional<EventKind> kind;
  };
  const PlannedFall& fall_;
  const std::vector<CourseKnot>& knots_;
  const SeenSteps& see_;
  models::Stepper lane_;
  Roaming roaming_;
  EventFinder events_;
  FallPoint now_, begin_;
  int steps_ = 0, looks_ = 0;
  double roaming_sum_ = 0.0;
  Eigen::VectorXd difference_;
  std::vector<FoundEvent> found_;
  ReplayedFall result_;
};

}  // namespace

ReplayedFall replay(const PlannedFall& fall, const FallPoint& start, const std::vector<CourseKnot>& knots,
                    const SeenSteps& see) {
  return Replay(fall, start, knots, see).run();
}

}  // namespace samara::motion
