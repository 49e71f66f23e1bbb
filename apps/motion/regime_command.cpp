#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "motion/motion_answers.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/motion/patterns/disc_phase_diagram.h"
#include "samara/motion/sweeps/phase_diagram.h"
#include "samara/motion/sweeps/sweep_file.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

struct RegimeArguments {
  std::string model;
  std::vector<std::string> set;
  std::string output;
  std::string sweep;  ///< whose shares of patterns are told; empty: none
  bool json = false;
};

std::string regime_text(const motion::FallNumbers& n, const motion::RegimeAnswer& answer) {
  std::string text = fmt::format(
      "length      {:.4g} m, thickness {:.4g} m\n"
      "speed       {:.4g} m/s, sqrt(|rho_s/rho_f - 1| g t)\n"
      "Re          {:.4g}\n"
      "I*, disc    {:.4g}    pi rho_s t/(64 rho_f d), of this diagram\n"
      "I*, plate   {:.4g}    8 rho_s t (l^2 + t^2)/(3 pi rho_f l^3), Smith 1971\n"
      "I*, ellipse {:.4g}    rho_s b/(rho_f a), Andersen et al. 2005\n"
      "regime      {}, as discs of this Re and I* fall (Field et al. 1997)\n"
      "beyond      {}, {:.3g} away in ln Re and ln I*\n",
      n.length, n.thickness, n.speed, n.Re, n.I_disc, n.I_plate, n.I_ellipse, to_string(answer.regime),
      to_string(answer.beyond), answer.distance);
  return text;
}

motion::SharesAt shares_around(const std::string& file, const models::ParametricModel& body) {
  const motion::Sweep sweep = motion::load_sweep(file);
  try {
    return motion::shares_of(sweep, body);
  } catch (const ArgumentError& error) {
    throw ArgumentError(fmt::format("--sweep {}: {}", file, error.what()));
  }
}

std::string shares_text(const motion::SharesAt& at) {
  std::string text = fmt::format(
      "patterns of the {} falls of the sweep nearest to this body, from all its releases\n", at.falls);
  for (std::size_t k = 0; k < motion::kPatterns; ++k) {
    const motion::Share& share = at.patterns[k];
    if (share.value > 0.0)
      text += fmt::format("  {:<14} {:5.1f} %  ({:.1f} to {:.1f}, 95 %)\n", motion::pattern_names()[k],
                          100.0 * share.value, 100.0 * share.lower, 100.0 * share.upper);
  }
  return text;
}

Json shares_json(const motion::SharesAt& at) {
  Json object = {{"falls", at.falls}, {"shares", Json::object()}};
  for (std::size_t k = 0; k < motion::kPatterns; ++k)
    object["shares"][motion::pattern_names()[k]] = {
        {"share", at.patterns[k].value}, {"interval", {at.patterns[k].lower, at.patterns[k].upper}}};
  return object;
}

int run_regime(const RegimeArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.model, arguments.sweep},
                      arguments.json ? ".json" : ".txt");
  const models::ParametricModel body = body_of(arguments.model, arguments.set);
  const motion::FallNumbers numbers = motion::fall_numbers(body.model(), body.parameters({}));
  const motion::RegimeAnswer answer = motion::regime(numbers.Re, numbers.I_disc);
  if (!answer.measured)
    warn(fmt::format(
        "discs were measured from Re 20 to 4e4 and I* 2e-4 to 0.5: at {:.3g} and {:.3g} the regime is a "
        "guess",
        numbers.Re, numbers.I_disc));
  std::optional<motion::SharesAt> shares;
  if (!arguments.sweep.empty()) shares = shares_around(arguments.sweep, body);
  if (!arguments.json) {
    write_answer(arguments.output, regime_text(numbers, answer) + (shares ? shares_text(*shares) : ""));
    return kDone;
  }
  Json object = {{"schema", "samara-regime/1"},
                 {"length", numbers.length},
                 {"thickness", numbers.thickness},
                 {"speed", numbers.speed},
                 {"Re", numbers.Re},
                 {"I_disc", numbers.I_disc},
                 {"I_plate", numbers.I_plate},
                 {"I_ellipse", numbers.I_ellipse},
                 {"regime", to_string(answer.regime)},
                 {"beyond", to_string(answer.beyond)},
                 {"distance", answer.distance},
                 {"measured", answer.measured}};
  if (shares) object["sweep"] = shares_json(*shares);
  write_answer(arguments.output, json_line(object));
  return kDone;
}

}  // namespace

void add_regime(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<RegimeArguments>();
  CLI::App* command =
      app.add_subcommand("regime", "Re, the three I*, and where a body stands in the measured phase diagram");
  command->add_option("MODEL", values->model, "name of a model of a falling body, or a file")->required();
  command->add_option("--set", values->set, "NAME=VALUE, SI or with a unit")->allow_extra_args(false);
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  command->add_option("--sweep", values->sweep,
                      "a sweep of the model: which shares of its falls near this body have which pattern");
  on_call(*command, arguments, values, run_regime);
}

}  // namespace samara::apps
