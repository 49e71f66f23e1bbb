#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/models/interface/model.h"

/// A model from equations as text: x' = f(t, x, p), with exact derivatives.
///
///     Equations pendulum{.name = "pendulum",
///                        .states = {{.name = "angle", .unit = "rad"}, {.name = "rate", .unit = "rad/s"}},
///                        .parameters = {{.name = "length", .unit = "m"}, {.name = "g", .unit = "m/s^2"}},
///                        .rates = {"rate", "-g/length*sin(angle)"}};
///     const auto model = equation_model(pendulum);
///
/// In an expression may stand + - * / ^ (or **), parentheses, numbers with or without a unit ("9.81 [m/s^2]"), the
/// states, the parameters, the abbreviations, t, pi, and the functions sqrt exp log sin cos tan asin acos atan atan2
/// sinh cosh tanh abs min max sign step. log is the natural one; step is 1 from 0 on, else 0. Units are checked:
/// sums, min and max take equal ones, exponents and most functions none; 0 goes with any. A rate is in the unit of
/// its state per second, or per 1 where states and parameters all are dimensionless; an output is in its own.
namespace samara::models {

struct Equations {
  std::string name = "equations";
  std::string title = {};
  std::string frames = {};    ///< what the axes mean, in words
  std::string source = {};    ///< paper or book
  std::string validity = {};  ///< in words
  std::vector<StateInfo> states = {};
  std::vector<ParameterInfo> parameters = {};
  /// Name and expression of what the rates may use by name; each may use those before it.
  std::vector<std::pair<std::string, std::string>> abbreviations = {};
  std::vector<std::string> rates = {};  ///< one per state
  /// What follows from the states, beside them, and its expression, which may use the abbreviations too.
  std::vector<std::pair<OutputInfo, std::string>> outputs = {};
};

enum class EquationPart { states, parameters, abbreviations, rates, outputs };

/// What is wrong with a set of equations, and where.
class EquationError : public ArgumentError {
 public:
  EquationError(EquationPart part, std::string name, const std::string& sentence)
      : ArgumentError(sentence), part_(part), name_(std::move(name)) {}
  EquationPart part() const { return part_; }
  /// The state, parameter, abbreviation or output that it is about; empty: all of them.
  const std::string& name() const { return name_; }

 private:
  EquationPart part_;
  std::string name_;
};

/// The model finds out by itself which of its parameters it is affine in, and which states its rates do not depend on.
/// @throws EquationError for an expression that cannot be read, units that do not fit, a name that is taken or none,
///   numbers that are not finite, and where rates and states differ in number
std::shared_ptr<const Model> equation_model(const Equations& equations);

/// Whether t stands in the rates, or in an abbreviation.
bool mention_time(const Equations& equations);
/// Whether t stands in the outputs, or in an abbreviation.
bool outputs_mention_time(const Equations& equations);

/// The text of a model that was made by equation_model(); null of any other.
const Equations* equations_of(const Model& model);

}  // namespace samara::models
