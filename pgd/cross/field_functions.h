#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/pgd/fields/separated_field.h"

/// Products, quotients and other functions of fields, entry by entry on the nodes of their axes.
///
/// The result interpolates the function of the nodal values: between the nodes it differs from the function
/// of the fields by the interpolation error of the axes. It is found by cross interpolation from values at
/// chosen nodes only, as a train, which is then separated; nothing visits the whole grid. A result is checked
/// at random nodes that nothing before had seen.
namespace samara::pgd {

struct FunctionOptions {
  /// Largest allowed difference of an output at the check nodes, divided by the largest |value| of that
  /// output among all nodes visited.
  double tolerance = 1e-6;
  int max_rank = 100;    ///< of the train
  int max_terms = 2000;  ///< of the result
  long max_evaluations = 50'000'000;
  std::uint64_t seed = 1;
};

struct FunctionResult {
  std::optional<SeparatedField> field;  ///< empty if there is a `point`
  /// converged; missed: ranks, sweeps, evaluations or terms ran out, the field is the best found; not_finite,
  /// sign_change: at `point`, no field.
  Termination status = Termination::missed;
  std::string message = "the function was not called";
  double error = 0.0;  ///< largest over outputs and check nodes, relative as FunctionOptions::tolerance
  bool tolerance_met = false;
  long evaluations = 0;            ///< nodes where the function was evaluated
  double grid_size = 0.0;          ///< nodes of the whole grid
  std::vector<double> point = {};  ///< coordinates of the node that forbids a result
};

using FieldReferences = std::vector<std::reference_wrapper<const SeparatedField>>;

/// Sets `values` (the new outputs) from `inputs`: all outputs of the first field, then those of the next, ..
using PointFunction = std::function<void(const Eigen::VectorXd& inputs, Eigen::VectorXd& values)>;

/// A function of one or several fields on the same axes. `outputs` names the new outputs and their units.
///
///   FunctionResult speed = function_of({u, v}, {{"speed", "m/s"}},
///       [](const Eigen::VectorXd& x, Eigen::VectorXd& y) { y[0] = std::hypot(x[0], x[1]); });
///
/// Cost: cross interpolation, O(d n r^2) evaluations for ranks r, each O(R d) for the fields' ranks R.
/// @throws ArgumentError if there is no field or output, axes differ, or an option is out of range.
FunctionResult function_of(const FieldReferences& fields, std::vector<OutputLabel> outputs,
                           const PointFunction& function, const FunctionOptions& options = {});

/// f g per output, named "f g", with the product of the units. If one of the fields has one output only, it
/// multiplies all of the other's.
/// @throws ArgumentError also if both have several outputs, but not as many.
FunctionResult product(const SeparatedField& f, const SeparatedField& g, const FunctionOptions& options = {});

/// f / g per output, named "f / g", with the quotient of the units; outputs are paired as in product(). If a
/// denominator vanishes or changes its sign, the status says so and names a node: at nodes visited, and at
/// those that a descent along grid lines from random starts finds.
FunctionResult quotient(const SeparatedField& f, const SeparatedField& g,
                        const FunctionOptions& options = {});

}  // namespace samara::pgd
