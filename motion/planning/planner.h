#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/motion/courses/coefficient_course.h"
#include "samara/motion/planning/motion_plan.h"

/// Falls that do what they are asked: follow a sketch, come down at a place, swing and turn in a given order.
///
/// Nothing is blended. What comes out is one solution of the model whose coefficients change within their box: a
/// course of coefficients, and the motion that the steps of the plan make along it. At each minimum of speed the
/// search chooses how the coefficients go on, windows of Gauss and Newton's method then move them all a little.
///
///     const MotionResult motion = plan_motion(read_motion_plan("motion.toml"));
///     motion.deviation;                         // m, rms distance from the sketch
///     course_codebook(*motion.course, ..);      // what simulate --coefficients replays
///     motion.replayed_until;                    // s, to which it then stays with these states
///
/// Falls are sensitive: of two that begin alike to round-off, long ones part. Whoever replays the course by other steps
/// has this motion up to some time only, which is told by CVODES; the states themselves need no more forces for that.
namespace samara::motion {

enum class MotionStatus {
  found,             ///< and as good as was asked, if anything was
  deviation_missed,  ///< there is a motion, not as near as was asked
  kinds_missed,      ///< as near as was asked, if anything was, but not of the kinds or patterns that were
  landed_early,      ///< on the ground before the time that the plan gives
  not_landed,        ///< it is not where it was to land when its time is over, or did not come to its end
  lost,              ///< no fall came to the ground or to the end of the time: no motion
  cancelled,         ///< by the progress callback: no motion
};

std::string to_string(MotionStatus status);

/// What became of a plan's sequence, told from the motion that came out, not from the search.
struct SequenceOutcome {
  struct Segment {
    double begin = 0.0, end = 0.0;  ///< s
    std::optional<EventKind> asked = {};
    std::optional<EventKind> got = {};  ///< none: it is steady
  };
  struct Stretch {
    double begin = 0.0, end = 0.0;  ///< s; of a stretch that was not reached both the end of the fall
    Pattern asked = Pattern::unresolved;
    PatternLabel got = {};
  };
  std::vector<Segment> segments;   ///< all, from the first event on
  std::vector<Stretch> stretches;  ///< of patterns that were asked
  int asked = 0;                   ///< segments, or stretches
  int had = 0;                     ///< as they were asked
  int not_reached = 0;             ///< the fall was over before
  /// Mean of log P(kind | kinds before) of the segments under the sequence's chain; NaN without one.
  double log_likelihood = 0.0;
};

struct MotionResult {
  MotionStatus status = MotionStatus::lost;
  std::string message = "nothing was planned";  ///< one sentence
  std::optional<CoefficientCourse> course;      ///< empty: there is no motion
  double end = 0.0;                             ///< s, when the body is on the ground, or the time is over
  Eigen::VectorXd times;                        ///< s, from 0 to end, at the steps of the plan
  Eigen::MatrixXd states;                       ///< along the course, times x states
  double deviation = 0.0;                       ///< m, rms over time from the sketch; 0 without one
  double landing_miss = 0.0;                    ///< m, from the landing place; 0 without one
  std::optional<SequenceOutcome> sequence;      ///< where the plan has one
  std::optional<BookUse> book;                  ///< where the plan has a codebook
  FallCost cost;                                ///< of the motion
  /// s, up to which CVODES along the course, as its file has it, stays within a tenth of a semi-length of the states.
  double replayed_until = 0.0;
  std::vector<PlanningStep> history;
  double seconds = 0.0;

  bool is_usable() const { return course.has_value(); }
};

struct PlanningOptions {
  ProgressCallback progress = {};
  /// Where the search is kept while it runs (every ten seconds, and when it is cancelled), and taken up again if it
  /// is of the same plan; it is removed when all is done. What comes out is the same to the bit. Empty: nowhere.
  std::filesystem::path checkpoint = {};
  /// Leave the checkpoint of a search that is done, too: for a caller that removes it when the result is written.
  bool keep_checkpoint = false;
  /// Told in one sentence, once, if the checkpoint cannot be written.
  std::function<void(const std::string&)> warning = {};
};

/// @throws ArgumentError if the plan's values are outside their meaning, or its body does not sink, or for its
/// codebook, as BookTangents; InputError for a checkpoint of another plan, and for another file in its place.
MotionResult plan_motion(const MotionPlan& plan, const PlanningOptions& options = {});

/// The motion of a plan's steps along a course to the ground, or to the end of the time; without frames if it is not
/// finite.
struct RealisedFall {
  Eigen::VectorXd times;
  Eigen::MatrixXd states;
  double deviation = 0.0, landing_miss = 0.0;
  bool landed = false;   ///< it came to the ground
  bool is_over = false;  ///< it landed, or the time that the plan gives was over
  FallCost cost;
};
RealisedFall realise(const MotionPlan& plan, const CoefficientCourse& course);

}  // namespace samara::motion
