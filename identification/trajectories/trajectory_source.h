#pragma once

#include <limits>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// Where a fit takes its trajectories from: a codebook, the reference integrator, Runge-Kutta steps, or a
/// mixture. All say what can be fitted, and answer at the frame times of a capture.
namespace samara::identification {

/// A free coordinate: a parameter, or the initial value "s(0)" of state s, with its box (SI).
struct FitCoordinate {
  std::string name;
  std::string unit;
  bool is_initial = false;
  double lower = 0.0;
  double upper = 0.0;
};

struct FitOutput {
  std::string name;
  std::string unit;
};

struct FamilyInfo {
  std::string model = {};
  /// "codebook", "reference integrator", "Runge-Kutta steps", "codebook and ..", or a word of one's own.
  std::string source = {};
  std::vector<FitCoordinate> coordinates = {};
  std::vector<FitOutput> outputs = {};
  std::vector<std::string> states = {};        ///< of the equations, if known: outputs may be some of them
  std::map<std::string, double> fixed = {};    ///< parameters and initial values held by the family, SI
  std::vector<std::string> translations = {};  ///< outputs that may be shifted without changing the motion
  /// The four outputs of an attitude quaternion (w, x, y, z), body to world; empty if there is none.
  std::vector<std::string> attitude = {};
  double end_time = std::numeric_limits<double>::infinity();  ///< s
  /// The coordinate that is the time of the capture at which a trajectory starts, for equations that depend
  /// on time; empty if they do not. No fit frees it: segments know when they start.
  std::string clock = {};
  bool autonomous = true;  ///< the equations do not depend on time
};

/// q -> values and derivatives at fixed times, for chosen outputs. Holds scratch space: one per thread.
class TrajectorySource {
 public:
  virtual ~TrajectorySource() = default;

  /// @param q all coordinates of the family, in order, inside its box
  /// @param values times x outputs, of that size already
  /// @param derivatives of that size already, times x (outputs * coordinates): column o + outputs * k holds
  ///   d(output o)/dq_k, at least for the coordinates that were wanted; null if not wanted
  /// @returns false if there is no trajectory at q (the integrator gave up)
  virtual bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) = 0;
};

/// Trajectories over a box of coordinates. Immutable, safe to share between threads.
class TrajectoryFamily {
 public:
  virtual ~TrajectoryFamily() = default;

  virtual const FamilyInfo& info() const = 0;

  /// @param times s, not decreasing, from 0 to end_time
  /// @param outputs names
  /// @throws ArgumentError for an unknown output; OutsideBoxError for times outside.
  virtual std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const = 0;
  /// The same for a fit that needs derivatives by some coordinates only. By default all are computed.
  /// @param wanted indices of coordinates
  virtual std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs,
                                               const std::vector<int>& wanted) const;

  /// The equations behind the trajectories, with the coordinates of the family free, in their order; null if
  /// they are not known.
  virtual const models::ParametricModel* equations() const { return nullptr; }

  /// The same trajectories by steps of half the length, to see what the steps cost; null for a family whose
  /// error is not that of steps of one length.
  virtual std::unique_ptr<TrajectoryFamily> finer() const { return nullptr; }
};

}  // namespace samara::identification
