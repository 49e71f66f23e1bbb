#include "samara/codebooks/source/command_function.h"

#include <cmath>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/source/command_program.h"

namespace samara::codebooks {

pgd::PointsFunction command_function(Command command) {
  if (command.run.empty() || command.run.front().empty())
    throw ArgumentError("the command is empty, expected a program and its arguments");
  if (command.inputs < 1 || command.outputs < 1 || command.largest_batch < 1 || !(command.timeout > 0.0) ||
      !std::isfinite(command.timeout)) {
    throw ArgumentError(fmt::format(
        "a command with {} inputs, {} outputs, batches of {} points and a timeout of {} s, expected "
        "positive numbers",
        command.inputs, command.outputs, command.largest_batch, command.timeout));
  }
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
