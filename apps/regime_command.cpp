#include <fmt/format.h>

#include "assignments.h"
#include "commands.h"
#include "motion_answers.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/motion/patterns/regime.h"
#include "terminal.h"

namespace samara::apps {

namespace {

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

}  // namespace

int run(const RegimeArguments& arguments) {
  if (!arguments.output.empty()) check_output(arguments.output, {arguments.model});
  const auto model = codebooks::open_model(arguments.model);
  std::map<std::string, std::string> units;
  for (const auto& parameter : model->info().parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : model->info().states) units[state.name + "(0)"] = state.unit;
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);
  require_parameters(model->info(), values);
  const models::ParametricModel parametric(model, values, {});
  parametric.check({});
  warn_of_parameters(*model, parametric.fixed());
  const motion::FallNumbers numbers = motion::fall_numbers(*model, parametric.parameters({}));
  const motion::RegimeAnswer answer = motion::regime(numbers.Re, numbers.I_disc);
  if (!answer.measured)
    warn(fmt::format(
        "discs were measured from Re 20 to 4e4 and I* 2e-4 to 0.5: at {:.3g} and {:.3g} the regime is a "
        "guess",
        numbers.Re, numbers.I_disc));
  if (!arguments.json) {
    write_answer(arguments.output, regime_text(numbers, answer));
    return kDone;
  }
  const Json object = {{"schema", "samara-regime/1"},
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
  write_answer(arguments.output, object.dump() + "\n");
  return kDone;
}

}  // namespace samara::apps
