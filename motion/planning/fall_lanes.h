#pragma once

#include <optional>
#include <span>
#include <vector>

#include "samara/base/shared_progress.h"
#include "samara/models/batch/stepper.h"
#include "samara/motion/events/event_finder.h"
#include "samara/motion/planning/motion_plan.h"
#include "samara/motion/planning/segment_choices.h"
#include "samara/motion/records/motion_record.h"

/// Pieces of falls, from one decision to the next, many side by side.
namespace samara::motion {

/// Steps between looks at accelerations, where turbulence is what they cost.
inline constexpr int kBetweenLooks = 16;

/// How far a fall has come, and what it has cost.
struct FallPoint {
  double t = 0.0;
  std::vector<double> state;
  std::vector<double> coefficients;  ///< at this time; a ramp may be under way
  std::vector<double> heading_for;   ///< what they are on the way to, or are
  double height = 0.0;               ///< of the place
  double square_time = 0.0;          ///< integral of the squared deviation over time [m^2 s]
  Eigen::Vector3d deviation = Eigen::Vector3d::Zero();  ///< here [m]
  double acceleration_square = 0.0;  ///< mean since the last decision of |a(c) - a(natural)|^2 [m^2/s^4]

  // What fall_cost.h adds up.
  double changes = 0.0, turbulence = 0.0, kinds = 0.0;
  int events = 0;         ///< that were passed; the segment that comes is number events - 1
  std::vector<int> past;  ///< kinds of the last segments, the latest last
};

enum class FallEnd {
  decision,  ///< an event, or none for long
  ground,    ///< or the time that the plan gives
  not_finite,
};

struct FallPiece {
  FallPoint to;  ///< at an event, the look beside it
  FallEnd end = FallEnd::not_finite;
  bool has_event = false;              ///< whether a segment has ended
  std::optional<EventKind> kind = {};  ///< of that segment; none: it is steady
};

/// What the search needs of a plan, once.
class PlannedFall {
 public:
  explicit PlannedFall(const MotionPlan& plan);

  const MotionPlan& plan() const { return plan_; }
  /// The box free, everything else fixed.
  const models::ParametricModel& model() const { return model_; }
  const MotionStates& states() const { return states_; }
  const std::vector<std::string>& names() const { return names_; }
  const std::vector<double>& natural() const { return natural_; }
  double semi_length() const { return semi_length_; }
  /// What looks for the events of its motions, as those of databases are found: new, to be copied.
  const EventFinder& finder() const { return finder_; }
  /// Steps after which the search looks at a fall again: few beside a swing, whose events are a matter of its cubics.
  int steps_to_look() const { return steps_to_look_; }
  /// A decision is due after so long without an event.
  double longest_piece() const { return longest_piece_; }
  double release_height() const { return release_height_; }
  double turbulence_factor() const { return turbulence_factor_; }  ///< see fall_cost.h
  /// Of the plan's database, if it has one.
  const std::optional<SegmentChoices>& choices() const { return choices_; }
  /// What the next segment is asked to be; none where nothing is.
  const AskedSegment* asked(const FallPoint& point) const;

  FallPoint release() const;
  bool is_over(double t, double height) const;
  /// From the target at this time; zero where there is no sketch.
  Eigen::Vector3d deviation(double t, const Eigen::Vector3d& position) const {
    Eigen::Index any = 0;
    return deviation(t, position, any);
  }
  /// @param near as Sketch::target
  Eigen::Vector3d deviation(double t, const Eigen::Vector3d& position, Eigen::Index& near) const;
  /// From the straight way to the landing place; zero where none is asked for, or a sketch leads there.
  Eigen::Vector3d off_course(const FallPoint& point) const;

 private:
  const MotionPlan& plan_;
  std::optional<Sketch> way_;
  std::vector<std::string> names_;
  std::vector<double> natural_;
  models::ParametricModel model_;
  MotionStates states_;
  double semi_length_ = 1.0, longest_piece_ = 0.0, release_height_ = 0.0, turbulence_factor_ = 0.0;
  int steps_to_look_ = 1;
  EventFinder finder_;
  std::optional<SegmentChoices> choices_;
};

/// Of what the coefficients do beyond the natural ones: the difference of accelerations, in body axes.
class Roaming {
 public:
  explicit Roaming(const PlannedFall& fall);
  /// @param difference one number per velocity
  void at(double t, std::span<const double> state, std::span<const double> coefficients,
          Eigen::VectorXd& difference);

 private:
  const PlannedFall& fall_;
  std::vector<double> rate_, natural_rate_;
  models::ParametricModel::Workspace workspace_;
};

/// How a fall goes on.
struct Continuation {
  const FallPoint* from = nullptr;
  std::vector<double> target;  ///< of the coefficients
};

/// Runs continuations to their next decision, several side by side. One object per thread.
class FallLanes {
 public:
  explicit FallLanes(const PlannedFall& fall);
  ~FallLanes();

  /// @param pieces one per continuation; those that had not ended when `progress` was cancelled are not finite
  void run(std::span<const Continuation> continuations, std::span<FallPiece> pieces,
           SharedProgress& progress);

 private:
  struct Rider;
  struct Sums;
  void board(Rider& rider, Eigen::Index lane, const Continuation& continuation);
  /// What a look adds up.
  void add_look(Rider& rider, double t, const Eigen::Vector3d& place);
  /// @returns whether the piece of this lane has ended
  bool look(Rider& rider, Eigen::Index lane, bool is_finite, bool is_event);
  bool end_piece(Rider& rider, Eigen::Index lane, FallEnd how) const;
  void put_point(const Sums& sums, double t, FallPoint& point) const;
  void put_coefficients(const Rider& rider, FallPoint& point) const;

  const PlannedFall& fall_;
  models::Stepper stepper_;
  EventLanes finders_;
  std::vector<Rider> riders_;
  std::vector<double> state_;  ///< of the lane that is looked at
  Roaming roaming_;
  Eigen::VectorXd difference_;
};

}  // namespace samara::motion
