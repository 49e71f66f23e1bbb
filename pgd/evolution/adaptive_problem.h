#pragma once

#include <optional>
#include <vector>

#include "samara/pgd/evolution/evolution_problem.h"

/// A parametric evolution problem whose discretisation is the solver's to choose.
namespace samara::pgd {

/// Axis whose nodes the solver chooses (or that the caller fixes). The label may have a transform.
struct AdaptiveAxis {
  Axis::Label label;
  double lower = 0.0;
  double upper = 1.0;
  /// Fixed number of nodes; empty: refined as needed. p2 and fourier axes take an odd number: the next one.
  std::optional<int> nodes = {};
  /// chebyshev, legendre or fourier; or p1 or p2, which have no measure of what they leave unresolved: their
  /// nodes must be fixed.
  Basis basis = Basis::chebyshev;
};

struct AdaptiveProblem {
  const EvolutionSystem* system = nullptr;
  Axis::Label time;
  double end = 1.0;  ///< time runs from 0
  std::vector<AdaptiveAxis> parameters;
  std::vector<OutputLabel> states;
  std::vector<double> scales;        ///< first guess; replaced by the sampled ranges of the states
  std::vector<double> scale_floors;  ///< least scale of every state: its absolute tolerance
  std::vector<InitialValue> initial;
};

/// The axis with that many nodes; p2 and fourier axes take an odd number: the next one.
Axis make_axis(const AdaptiveAxis& axis, int nodes);

/// Per state the largest absolute value at the start, over the box.
Eigen::VectorXd start_sizes(const AdaptiveProblem& problem);

/// @throws ArgumentError naming the first axis of a basis that AdaptiveAxis does not name, or if there is no
/// system, or its states, scales, floors and initial values differ in number or are impossible.
void check_problem(const AdaptiveProblem& problem);

}  // namespace samara::pgd
