#pragma once

#include <memory>
#include <string_view>

namespace samara::models {

/// A number that changes in time, by an expression in t (equation_model.h says what may stand in it), with its exact
/// first and second derivatives: paths, signals.
///
///   const TimeFunction x("-0.8*sin(2*pi*0.2*t)");
///   x.at(1.5).rate;
class TimeFunction {
 public:
  struct Value {
    double value = 0.0, rate = 0.0, second_rate = 0.0;
  };

  /// @throws ArgumentError with what is wrong with the expression, at which column, and what was expected
  explicit TimeFunction(std::string_view expression);

  Value at(double t) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
};

}  // namespace samara::models
