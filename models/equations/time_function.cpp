#include "samara/models/equations/time_function.h"

#include <array>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/models/equations/expression.h"
#include "samara/models/equations/tape.h"

namespace samara::models {

struct TimeFunction::Compiled {
  Tape tape;  ///< the value, its rate, and the rate of that
};

TimeFunction::TimeFunction(std::string_view expression) {
  ExpressionGraph graph;
  const std::map<std::string, Term> names = {{"t", {graph.symbol(0), {}}}};
  const Term term = read_expression(expression, names, graph);
  if (!term.unit.is_dimensionless())
    throw ArgumentError(
        fmt::format("\"{}\" is in {}, expected a number without a unit", expression, to_string(term.unit)));
  const int value = term.node;
  const int rate = graph.derivative(value, 0);
  const int second_rate = graph.derivative(rate, 0);
  compiled_ = std::make_shared<Compiled>(Compiled{Tape(graph, {value, rate, second_rate}, 1)});
}

TimeFunction::Value TimeFunction::at(double t) const {
  std::vector<double> work(compiled_->tape.work_size(1));
  work[0] = t;
  std::array<double, 3> results = {};
  compiled_->tape.evaluate(work, results.data());
  return {results[0], results[1], results[2]};
}

}  // namespace samara::models
