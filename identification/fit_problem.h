#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/capture.h"
#include "samara/identification/fit_options.h"
#include "samara/identification/trajectory_source.h"

/// A fit with all names resolved; internal to identification/.
///
/// Unknowns are the shared coordinates, and for each capture its own: first its coordinates, then its
/// offsets.
namespace samara::identification {

enum class CoordinateRole { shared, own, fixed };

/// Where the value of a coordinate of the family comes from.
struct CoordinateSlot {
  CoordinateRole role = CoordinateRole::fixed;
  int index = 0;       ///< among the shared, or the own coordinates
  double value = 0.0;  ///< if fixed
};

struct ComparedOutput {
  std::string name;
  std::string unit;
  double scale = 1.0;              ///< residuals are divided by it, SI
  std::optional<int> offset = {};  ///< its place among the offsets, if it has one
};

/// One compared number.
struct Observation {
  int frame = 0;   ///< of the segment
  int output = 0;  ///< of the compared outputs
  double value = 0.0;
};

/// The part of a capture that is compared.
struct Segment {
  std::string id, file;
  std::map<std::string, std::string> labels;
  int cluster = 0;
  std::vector<double> times;  ///< of frames with something to compare
  std::vector<Observation> observations;
};

struct FitProblem {
  LossKind loss = LossKind::huber;
  std::vector<CoordinateSlot> slots;  ///< per coordinate of the family
  std::vector<FitCoordinate> shared;  ///< with the box of the fit
  std::vector<FitCoordinate> own;     ///< likewise; each capture has these
  std::vector<ComparedOutput> outputs;
  std::vector<std::string> offsets;  ///< outputs with one
  std::vector<Segment> segments;
  int cluster_count = 0;
  std::map<std::string, double> fixed;

  int shared_count() const { return static_cast<int>(shared.size()); }
  /// Unknowns of each capture: coordinates and offsets.
  int own_count() const { return static_cast<int>(own.size() + offsets.size()); }
  int observation_count() const;
  std::vector<std::string> output_names() const;
};

/// @throws ArgumentError as fit()
FitProblem make_problem(const FamilyInfo& family, std::span<const Capture> captures,
                        const FitOptions& options);

/// Values of all unknowns.
struct FitPoint {
  Eigen::VectorXd shared;
  std::vector<Eigen::VectorXd> own;  ///< per segment
};

}  // namespace samara::identification
