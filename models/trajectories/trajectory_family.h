#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// A family of trajectories: parameters and initial values in, a trajectory with its derivatives out. One
/// interface for everything that gives trajectories, so that fits, commands and comparisons take any of them:
///
///   integrators of a model     models/trajectories/reference_trajectories.h, step_trajectories.h,
///                              integrator_trajectories.h
///   a codebook, a flow map     codebooks/composition/codebook_trajectories.h
///   a codebook, and another
///   family outside its box     codebooks/composition/mixed_trajectories.h
///
/// Usage:
///   const auto family = reference_trajectories(model, fixed, {{"mass", {0.001, 0.01}}});
///   const FamilyTrajectory one = trajectory(*family, q, times, {"x", "y"}, Derivatives::yes);
///   if (!one.outcome) report(one.outcome.message);
///
/// and for many points at the same times
///   const auto source = family->at(times, {"x", "y"});     // one per thread
///   for (const auto& q : points) source->evaluate(q, values, &derivatives);
///
/// check_family.h tests a family of your own.
namespace samara::models {

/// A free coordinate: a parameter, or the initial value "s(0)" of state s, with its box (SI).
struct FamilyCoordinate {
  std::string name;
  std::string unit;
  bool is_initial = false;
  double lower = 0.0;
  double upper = 0.0;
};

struct FamilyOutput {
  std::string name;
  std::string unit;
};

struct FamilyInfo {
  std::string model = {};
  /// Where trajectories come from, in words: "codebook", "reference integrator", "Runge-Kutta steps", ..
  std::string source = {};
  std::vector<FamilyCoordinate> coordinates = {};
  std::vector<FamilyOutput> outputs = {};
  std::vector<std::string> states = {};        ///< of the equations, if known: outputs may be some of them
  std::map<std::string, double> fixed = {};    ///< parameters and initial values held by the family, SI
  std::vector<std::string> translations = {};  ///< outputs that may be shifted without changing the motion
  /// The four outputs of an attitude quaternion (w, x, y, z), body to world; empty if there is none.
  std::vector<std::string> attitude = {};
  double end_time = std::numeric_limits<double>::infinity();  ///< s
  /// The coordinate that is the time of the capture at which a trajectory starts, for equations that depend
  /// on time; empty if they do not. No fit frees it: segments know when they start.
  std::string clock = {};
  bool autonomous = true;       ///< the equations do not depend on time
  bool has_derivatives = true;  ///< false: values only
};

enum class TrajectoryStatus {
  done,
  outside_box,     ///< the point, or a state on the way, is outside the box of a codebook
  not_integrated,  ///< the integrator stopped early, or a state is not finite
};

/// How one trajectory ended. True if it is there to the last time.
struct TrajectoryOutcome {
  TrajectoryStatus status = TrajectoryStatus::done;
  std::string message = {};  ///< one sentence; empty if done
  /// Where it is not done: time up to which rows are valid [s]; what later rows hold means nothing. Negative:
  /// no row is valid.
  double reached = -1.0;

  explicit operator bool() const { return status == TrajectoryStatus::done; }
};

/// How many rows are valid: all where it is done. @param times not decreasing
Eigen::Index rows_reached(const TrajectoryOutcome& outcome, std::span<const double> times);

/// q -> values and derivatives at fixed times, for chosen outputs. Holds scratch space: one per thread.
class TrajectorySource {
 public:
  virtual ~TrajectorySource() = default;

  /// The same call gives the same bits, whatever was asked before.
  /// @param q all coordinates of the family, in order, inside its box, SI
  /// @param values times x outputs, of that size already
  /// @param derivatives of that size already, times x (outputs * coordinates): column o + outputs * k holds
  ///   d(output o)/dq_k, at least for the coordinates that were wanted; null if not wanted
  /// @throws ArgumentError if q has the wrong size or is not finite (check_point()); if the family has no
  ///   derivatives, and they are wanted.
  virtual TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                     Eigen::MatrixXd* derivatives) = 0;
};

enum class Derivatives { no, yes };

struct FamilyBatchOptions {
  Derivatives derivatives = Derivatives::no;
  int threads = 0;  ///< 0: as many as the machine has
};

/// Trajectories of many points at the same times.
struct FamilyBatch {
  std::vector<TrajectoryOutcome> outcomes;   ///< per trajectory
  std::vector<Eigen::MatrixXd> values;       ///< per trajectory, times x outputs; NaN where not valid
  std::vector<Eigen::MatrixXd> derivatives;  ///< as TrajectorySource::evaluate(); empty if not wanted
};

/// Trajectories over a box of coordinates. Immutable, safe to share between threads.
class TrajectoryFamily {
 public:
  virtual ~TrajectoryFamily() = default;

  virtual const FamilyInfo& info() const = 0;

  /// The source at fixed times for chosen outputs. The family must outlive it.
  /// @param times s, not decreasing, from 0 to end_time
  /// @param outputs names
  /// @throws ArgumentError for an unknown output, and for times that are negative, decrease or are not
  ///   finite; OutsideBoxError for times after the end.
  virtual std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const = 0;
  /// The same where derivatives by some coordinates only are needed. By default all are computed.
  /// @param wanted indices of coordinates
  virtual std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs,
                                               const std::vector<int>& wanted) const;

  /// Trajectories of many points. By default each by a source as at() gives it, spread over threads; families
  /// that compute several at once may differ from that by round-off. Results do not depend on the number of
  /// threads.
  /// @param points trajectories x coordinates, SI
  /// @throws ArgumentError as at(), and as TrajectorySource::evaluate() for any point.
  virtual FamilyBatch batch(const Eigen::Ref<const Eigen::MatrixXd>& points, const std::vector<double>& times,
                            const std::vector<std::string>& outputs,
                            const FamilyBatchOptions& options = {}) const;

  /// The equations of the trajectories, with the coordinates of the family free, in their order; null if they
  /// are not known.
  virtual const ParametricModel* equations() const { return nullptr; }

  /// The same trajectories by steps of half the length, to see what the steps cost; null for a family whose
  /// error is not that of steps of one length.
  virtual std::unique_ptr<TrajectoryFamily> finer() const { return nullptr; }
};

/// One trajectory of a family.
struct FamilyTrajectory {
  TrajectoryOutcome outcome;
  Eigen::MatrixXd values;       ///< times x outputs, SI; NaN after outcome.reached
  Eigen::MatrixXd derivatives;  ///< as TrajectorySource::evaluate(); empty if not wanted
};

/// One trajectory, without keeping a source.
/// @throws ArgumentError, OutsideBoxError as TrajectoryFamily::at() and TrajectorySource::evaluate()
FamilyTrajectory trajectory(const TrajectoryFamily& family, std::span<const double> q,
                            const std::vector<double>& times, const std::vector<std::string>& outputs,
                            Derivatives derivatives = Derivatives::no);

/// Where the coordinate of that name stands; none: there is none.
std::optional<std::size_t> position(std::span<const FamilyCoordinate> coordinates, const std::string& name);

std::vector<std::string> names_of(std::span<const FamilyCoordinate> coordinates);

/// The names of all outputs.
std::vector<std::string> output_names(const FamilyInfo& family);

/// What every TrajectorySource::evaluate() refuses.
/// @throws ArgumentError if q has not `count` numbers, or one is not finite.
void check_point(std::span<const double> q, std::size_t count);

}  // namespace samara::models
