#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/error_scale.h"

namespace samara::codebooks {

/// Some trajectories, the pilots, at given times (ascending): one matrix, times x outputs, per trajectory; or
/// why there are none.
using PilotTrajectories =
    std::function<Outcome<std::vector<Eigen::MatrixXd>>(const std::vector<double>& times)>;

struct TimeMeshOptions {
  /// Largest interpolation error of an output between the nodes, over its scale, see TimeMesh.
  double tolerance = 1e-5;
  pgd::OutputMeasure measure = {};  ///< of the outputs
  int degree = 8;                   ///< of the Chebyshev elements
  int max_elements = 512;
};

struct TimeMesh {
  pgd::Axis axis;      ///< Chebyshev elements on [0, end]
  double error = 0.0;  ///< largest that is left, in the measure of the tolerance
  /// Per output, what its errors are divided by (pgd/fields/error_scale.h), by the values seen.
  Eigen::VectorXd scale;
  bool resolved = false;  ///< error <= tolerance with the elements allowed
  int passes = 0;         ///< how often the pilots were asked for
};

/// A mesh of time for a family of trajectories: elements are halved until polynomials through their nodes
/// follow every pilot, at points between the nodes, to the tolerance. Several halvings are looked at for one
/// pass over the pilots.
/// @returns why the pilots have no trajectories, if they have none. @throws ArgumentError if end or an option is
/// not positive.
Outcome<TimeMesh> mesh_time(const pgd::Axis::Label& label, double end, const PilotTrajectories& pilots,
                            const TimeMeshOptions& options);

}  // namespace samara::codebooks
