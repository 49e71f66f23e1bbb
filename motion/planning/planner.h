#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/motion/courses/coefficient_course.h"
#include "samara/motion/planning/motion_plan.h"

/// Falls that do what they are asked: follow a sketch, come down at a place.
///
/// Nothing is blended. What comes out is one solution of the model whose coefficients change within their box: a course of
/// coefficients, and the motion that CVODES gives with it. At each minimum of speed the search chooses how
/// the coefficients go on, windows of Gauss and Newton's method then move them all a little, and where the
/// motion of the steps parts from that of CVODES, the rest is searched again from the state really reached.
///
///     const MotionResult motion = plan_motion(read_motion_plan("motion.toml"));
///     motion.deviation;                         // m, rms distance from the sketch
///     course_codebook(*motion.course, ..);      // what simulate --coefficients replays
namespace samara::motion {

enum class MotionStatus {
  found,             ///< and as good as was asked, if anything was
  deviation_missed,  ///< there is a motion, not as near as was asked
  landed_early,      ///< on the ground before the time that the plan gives
  not_landed,        ///< it is not where it was to land when its time is over, or did not come to its end
  lost,              ///< no fall came to the ground or to the end of the time: no motion
  cancelled,         ///< by the progress callback: no motion
};

std::string to_string(MotionStatus status);

struct MotionResult {
  MotionStatus status = MotionStatus::lost;
  std::string message = "nothing was planned";  ///< one sentence
  std::optional<CoefficientCourse> course;      ///< empty: there is no motion
  double end = 0.0;                             ///< s, when the body is on the ground, or the time is over
  Eigen::VectorXd times;                        ///< s, from 0 to end, at the steps of the plan
  Eigen::MatrixXd states;                       ///< by CVODES along the course, times x states
  double deviation = 0.0;                       ///< m, rms over time from the sketch; 0 without one
  double landing_miss = 0.0;                    ///< m, from the landing place; 0 without one
  int closings = 0;                             ///< how often the rest was searched again
  std::vector<PlanningStep> history;
  double seconds = 0.0;

  bool is_usable() const { return course.has_value(); }
};

/// @throws ArgumentError if the plan's values are outside their meaning.
MotionResult plan_motion(const MotionPlan& plan, const ProgressCallback& progress = {});

/// The motion of CVODES along a course to the ground, or to the end of the time; without frames if it is not finite.
struct RealisedFall {
  Eigen::VectorXd times;
  Eigen::MatrixXd states;
  double deviation = 0.0, landing_miss = 0.0;
  bool landed = false;   ///< it came to the ground
  bool is_over = false;  ///< it landed, or the time that the plan gives was over
};
RealisedFall realise(const MotionPlan& plan, const CoefficientCourse& course, double longest);

}  // namespace samara::motion
