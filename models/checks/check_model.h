#pragma once

#include <string>
#include <vector>

#include "samara/base/check.h"
#include "samara/models/interface/model.h"

/// The test for a model of your own.
///
///   const auto check = samara::models::check_model(my_model);
///   for (const std::string& finding : check.findings) std::cerr << finding << "\n";
///
/// It looks at what a model says of itself (names, units, defaults, texts, groups of states), and at random
/// points within the meaning of the parameters, quaternions of norm one,
///  - compares its derivatives with central differences of its right-hand side, and of its outputs;
///  - compares what it gives at many points at once with what it gives at each;
///  - changes the units of length, mass and time: rates, derived defaults, forces and energy must follow as
///    their units say, which finds a dimensionally wrong law and a constant that hides a unit;
///  - tries its symmetries "translation of <state>" and "rotation about z";
///  - takes two coefficient vectors and their mean: f must be affine in the parameters of `affine_in`;
///  - compares the powers of the force terms with the rate of the kinetic energy, where the model has both. A
///    model whose undisturbed fluid is not steady and uniform returns no kinetic energy;
///  - holds force terms whose description ends with "no power" to that, and those that end with "takes power" to
///    giving none.
///
/// Beside the findings it notes kinks of f (kinks.h): they may belong to the law, but cost whoever solves it.
namespace samara::models {

struct CheckModelOptions {
  unsigned seed = 1;
  int points = 50;
  /// Largest |derivative - central difference| over |derivative| + |f| / (size of the variable). Differences
  /// over a step of 6e-6 of the variable are good to about 1e-9 in this measure where f is smooth.
  double tolerance = 1e-6;
  /// Off for a model that holds numbers with units besides its parameters, such as a field of wind: these do
  /// not follow a change of units.
  bool units = true;
};

/// @throws ArgumentError if an option is outside its meaning; what the model throws passes through.
Check check_model(const Model& model, const CheckModelOptions& options = {});

}  // namespace samara::models
