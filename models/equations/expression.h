#pragma once

#include <map>
#include <string>
#include <string_view>

#include "samara/models/equations/expression_graph.h"
#include "samara/models/equations/unit_powers.h"

/// Internal to models/.
namespace samara::models {

/// Part of an expression, and what it is measured in.
struct Term {
  int node = 0;  ///< negative: of a name that is given later
  UnitPowers unit;
};

/// Reads an expression: + - * / ^ (or **, to the right, above the sign), parentheses, numbers with or without a unit
/// ("9.81 [m/s^2]"), names, pi, and the functions sqrt exp log sin cos tan asin acos atan atan2 sinh cosh tanh abs
/// min max sign step. log is the natural one; step is 1 from 0 on, else 0. Units are checked on the way: sums,
/// min and max take equal ones, exponents and most functions none; 0 goes with any.
///
/// @param names what may stand in it, besides pi
/// @throws ArgumentError with what is wrong, at which column, and what was expected
Term read_expression(std::string_view text, const std::map<std::string, Term>& names, ExpressionGraph& graph);

/// Whether a text may be a name: letters, digits and underscores, no digit first, no function and not pi.
bool is_expression_name(std::string_view text);

}  // namespace samara::models
