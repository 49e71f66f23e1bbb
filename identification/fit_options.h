#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/identification/interval.h"
#include "samara/identification/loss.h"

namespace samara::identification {

/// The loss and the sizes at which it bends. Residuals are divided by these sizes, so they also weigh outputs
/// of different kinds against each other.
struct LossOptions {
  LossKind kind = LossKind::huber;
  /// m, of every output that is a length: a few times the noise of a good video.
  double length_scale = 2e-3;
  /// Of single outputs, by name, SI. Needed for outputs that are no lengths, unless there is one output only
  /// and the kind is none.
  std::map<std::string, double> scales = {};
};

struct FitOptions {
  // What is compared
  /// s: only this much of each capture, from its first frame. Empty: all of it.
  std::optional<double> window = {};
  /// Names; empty: every output that all captures measure.
  std::vector<std::string> outputs = {};
  LossOptions loss = {};

  // What is fitted
  /// Coordinates with one value for all captures. Parameters are, unless named in `per_capture`.
  std::vector<std::string> shared = {};
  /// Coordinates with a value of each capture's own. Initial values are, unless named in `shared`.
  std::vector<std::string> per_capture = {};
  /// Coordinates held at a value (SI).
  std::map<std::string, double> fixed = {};
  /// Intervals within the family's box that the fit must not leave (SI).
  std::map<std::string, Interval> box = {};
  /// Outputs that get a free constant for each capture, added to the model. Empty: those in which the model
  /// has a translation symmetry and whose initial value is not a coordinate.
  std::optional<std::vector<std::string>> offsets = {};

  // How
  /// Columns of the captures' labels: captures with the same labels there count as one observation of the
  /// coefficients. Empty: each capture is one.
  std::vector<std::string> cluster_by = {};
  /// From the centre of the box and from quasi-random points inside it; 1 to 10000.
  int starts = 3;
  /// Of each start.
  int max_iterations = 500;

  // What is said of the answer
  /// The profile of every shared coefficient: ten to twenty fits each, with it held. Whether it is determined,
  /// bounded to one side, or not at all, and an interval that follows bends.
  bool profiles = false;
};

/// @throws ArgumentError naming field, value and requirement.
void validate(const FitOptions& options);

}  // namespace samara::identification
