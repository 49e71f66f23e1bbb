#include <fmt/format.h>

#include "assignments.h"
#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/io/csv.h"
#include "samara/models/integrate.h"
#include "terminal.h"

namespace samara::apps {

int run(const SimulateArguments& arguments) {
  if (!arguments.output.empty()) check_output(arguments.output, {});
  const auto model = models::find_model(arguments.model);
  const models::ModelInfo& info = model->info();
  std::map<std::string, std::string> units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) units[state.name + "(0)"] = state.unit;
  const models::ParametricModel parametric(model, parse_assignments(arguments.set, units), {});
  const double end = number_or_quantity("--until", arguments.until, models::time_unit(info));
  if (!(end > 0.0)) throw ArgumentError(fmt::format("--until is {}, expected more than 0", arguments.until));
  if (arguments.frames < 2 || arguments.frames > 10000000) {
    throw ArgumentError(fmt::format("--frames is {}, expected 2 to 10000000", arguments.frames));
  }
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(arguments.frames, 0.0, end);
  const models::Trajectory trajectory =
      models::integrate(parametric, {}, {times.data(), static_cast<std::size_t>(times.size())});

  Eigen::MatrixXd table(times.size(), 1 + trajectory.states.cols());
  table << times, trajectory.states;
  std::vector<std::string> header = {fmt::format("t[{}]", models::time_unit(info))};
  for (const auto& state : info.states) header.push_back(fmt::format("{}[{}]", state.name, state.unit));
  write_answer(arguments.output, io::format_csv(header, table));
  if (trajectory.is_usable()) return kDone;
  warn(fmt::format("{}; rows after t = {:.6g} are empty", trajectory.message, trajectory.reached));
  return kToleranceMissed;
}

}  // namespace samara::apps
