#pragma once

#include <array>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/chart.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/prior_terms.h"
#include "samara/models/trajectories/trajectory_family.h"

/// A fit with all names resolved; internal to identification/.
///
/// Unknowns are the shared coordinates, and for each segment of a capture its own: first its coordinates,
/// then its offsets, then those of the camera.
namespace samara::identification {

enum class CoordinateRole { shared, own, known, fixed };

/// Where the value of a coordinate of the family comes from.
struct CoordinateSlot {
  CoordinateRole role = CoordinateRole::fixed;
  int index = 0;       ///< among the shared, the own, or the known coordinates
  double value = 0.0;  ///< if fixed
};

struct ComparedOutput {
  std::string name;
  std::string unit;
  double scale = 1.0;                    ///< residuals are divided by it, SI
  std::optional<int> offset = {};        ///< its place among the offsets, if it has one
  std::optional<std::size_t> gain = {};  ///< the slot of its gain, if it has one
  double period = 0.0;                   ///< differences are taken on a circle of that length; 0: on the line
  bool scale_is_stated = true;           ///< by the options; else it may be no more than a unit
  bool scale_is_scatter = false;         ///< of frames about a smooth curve
};

/// One compared number.
struct Observation {
  int frame = 0;   ///< of the segment
  int output = 0;  ///< of the compared outputs
  double value = 0.0;
};

/// One compared attitude.
struct AttitudeObservation {
  int frame = 0;
  std::array<double, 4> q_WB = {1.0, 0.0, 0.0, 0.0};
};

/// A part of a capture with a start state of its own.
struct Segment {
  int motion = 0;
  double start = 0.0;     ///< s, of the capture's times: where its state is
  double interval = 0.0;  ///< s, between the frames of a mean; 0 where frames are no means
  /// s, from its state to its first frame: half the width of a mean, and where motions are cut, how far the delay
  /// may go below 0.
  double lead = 0.0;
  /// Since the start: of frames with something to compare, and if `joined`, last, where the next one starts.
  std::vector<double> times = {};
  std::vector<Observation> observations = {};
  std::vector<AttitudeObservation> attitudes = {};
  bool joined = false;  ///< the next segment continues the same motion
};

/// A capture as the fit sees it: its segments follow one another.
struct Motion {
  std::string id, file, checksum;
  std::string whole;  ///< id of the capture of which it is all, or a span
  std::map<std::string, std::string> labels;
  std::vector<std::string> notes = {};
  int cluster = 0;
  double weight = 1.0;        ///< of its part of the cost
  std::vector<double> known;  ///< values of known coordinates
  std::size_t first_segment = 0;
  std::size_t segment_count = 0;
};

/// How the end of a segment must agree with the own unknowns of the next: one rule for every direction in
/// which those can move.
struct JoinRule {
  enum class Kind {
    state,     ///< the output at the end is the coordinate
    offset,    ///< the output at the end and the offset are the next offset, and what the output starts from
    constant,  ///< a parameter, an offset that does not move, or an unknown of the camera
    turn       ///< the attitude at the end is the next one; one rule for all three directions
  };
  static constexpr int kNone = -1;

  Kind kind = Kind::state;
  int own = 0;             ///< the first of the own unknowns that are joined
  int column = 0;          ///< the first of the requested outputs
  double start = 0.0;      ///< what the output starts from, of an offset
  int start_slot = kNone;  ///< or the coordinate of the family that says so

  int rows() const { return kind == Kind::turn ? 3 : 1; }
};

/// What is not known of the camera: own unknowns, the same in all segments of a motion.
struct Camera {
  std::vector<int> columns = {};        ///< of the requested outputs: coordinates of the place
  std::vector<char> is_own = {};        ///< per axis: where a segment starts is an own unknown
  std::vector<int> start_slots = {};    ///< per axis: the coordinate of the family that says where, or kNone
  std::vector<double> starts = {};      ///< per axis, else
  std::vector<int> angles = {};         ///< compared outputs that turn with two axes
  std::optional<int> scale = {};        ///< the own unknown that is the relative error of lengths
  std::optional<int> turn = {};         ///< the first own unknown of the angle, or the rotation vector
  std::vector<double> deviations = {};  ///< beforehand, of scale and turn

  int turns() const { return !turn ? 0 : columns.size() == 3 ? 3 : 1; }
  int count() const { return static_cast<int>(deviations.size()); }
};

struct FitProblem {
  LossKind loss = LossKind::huber;
  std::vector<CoordinateSlot> slots;  ///< per coordinate of the family, then of the delay and the gains
  std::size_t model_slots = 0;        ///< how many belong to the family
  std::optional<std::size_t> delay;   ///< the slot of the delay of the clock, if there is one
  std::vector<std::string> known;     ///< names of known coordinates, in the order of Motion::known
  std::vector<models::FamilyCoordinate> shared;  ///< with the box of the fit
  std::vector<models::FamilyCoordinate> own;     ///< likewise; each segment has these
  Chart shared_chart, own_chart;
  std::optional<std::size_t> own_attitude;  ///< the first of its four own unknowns
  std::optional<std::size_t> clock;         ///< the slot that holds the start of a segment, if there is one
  std::vector<PriorTerm> priors;            ///< of shared unknowns
  std::vector<PriorTerm> own_priors;        ///< of own ones, at the start of every motion
  std::vector<std::pair<Eigen::Index, double>> initial;  ///< stated for the first start: shared index, value
  std::vector<ComparedOutput> outputs;
  std::optional<double> attitude_scale;  ///< if attitudes are compared
  int averaged_frames = 1;               ///< of which each frame is the mean
  std::vector<std::string> offsets;      ///< outputs with one
  std::optional<Camera> camera = {};
  /// Outputs taken from the family: the compared ones, then the attitude, then what camera and joins need.
  std::vector<std::string> requested;
  std::vector<JoinRule> joins;
  std::vector<Motion> motions;
  std::vector<Segment> segments;
  int cluster_count = 0;
  std::vector<std::string> cluster_names;  ///< what their captures have in common
  std::map<std::string, double> fixed;

  int shared_count() const { return static_cast<int>(shared.size()); }
  /// Unknowns of each segment: coordinates, offsets, and those of the camera.
  int own_count() const { return static_cast<int>(own.size() + offsets.size()) + camera_count(); }
  int camera_count() const { return camera ? camera->count() : 0; }
  int join_rows() const;
  /// Compared numbers; an attitude counts as three.
  int observation_count() const;
  /// First of the requested outputs that hold the attitude.
  int attitude_column() const { return static_cast<int>(outputs.size()); }
  bool is_joined() const;
  const Motion& motion_of(const Segment& segment) const {
    return motions[static_cast<std::size_t>(segment.motion)];
  }
};

/// What is compared and what is unknown, without the captures' frames: fits of all captures that measure the
/// same have it in common.
/// @throws ArgumentError as fit()
FitProblem describe_problem(const models::FamilyInfo& family, std::span<const Capture> captures,
                            const FitOptions& options);

/// @throws ArgumentError as fit()
FitProblem make_problem(const models::FamilyInfo& family, std::span<const Capture> captures,
                        const FitOptions& options);

/// The coordinates of the family, then delay and gains, for a segment of a motion.
/// @param q of their number already
void family_point(const FitProblem& problem, const Motion& motion, const double* shared, const double* own,
                  Eigen::VectorXd& q);

/// Of a circle that the output goes around: given, or a turn for what is in rad; 0: none.
double period_of(const models::FamilyOutput& output, const FitOptions& options);

/// A quaternion (w, x, y, z) of unit length; without a turn where it is too short to tell one.
Eigen::Vector4d unit_attitude(const Eigen::Vector4d& q);

/// Where the attitude of a segment starts as long as nothing better is known, if it is among the own
/// unknowns: as first measured; else in the middle of its box, as a unit quaternion, and without a turn where
/// that is none.
Eigen::Vector4d start_attitude(const FitProblem& problem, const Segment& segment);

/// Values of all unknowns.
struct FitPoint {
  Eigen::VectorXd shared;
  std::vector<Eigen::VectorXd> own;  ///< per segment
};

}  // namespace samara::identification
