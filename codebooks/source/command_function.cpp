#include "samara/codebooks/source/command_function.h"

#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/codebooks/source/command_program.h"

namespace samara::codebooks {

pgd::PointsFunction command_function(Command command) {
  if (command.run.empty() || command.run.front().empty())
    throw ArgumentError("the command is empty, expected a program and its arguments");
  constexpr std::string_view kWhere = "command_function";
  require(command.inputs >= 1, "inputs", command.inputs, "at least 1", kWhere);
  require(command.outputs >= 1, "outputs", command.outputs, "at least 1", kWhere);
  require(command.largest_batch >= 1, "largest_batch", command.largest_batch, "at least 1", kWhere);
  require_positive(command.timeout, "timeout [s]", kWhere);
  const int inputs = command.inputs, outputs = command.outputs;
  return [inputs, outputs, program = std::make_shared<CommandProgram>(std::move(command))](
             const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    if (points.rows() != inputs) {
      throw ArgumentError(fmt::format("the command {} takes {} inputs, the points have {}", program->name(),
                                      inputs, points.rows()));
    }
    values = program->answers(points, outputs);
  };
}

}  // namespace samara::codebooks
