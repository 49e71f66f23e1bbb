#include "samara/identification/petab/petab_result.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

namespace samara::identification {

namespace {

struct Found {
  double value = 0.0;
  std::optional<double> error = {};
};

/// What the fit says of a parameter; nothing of one that it held.
std::optional<Found> found_of(const PetabParameter& p, const FitResult& fit) {
  if (!p.noise_of.empty()) {
    for (const NoiseLevel& level : fit.noise) {
      if (level.estimated && std::ranges::count(level.outputs, p.noise_of) > 0)
        return Found{level.value, level.standard_error()};
    }
    return {};
  }
  if (p.condition.empty()) {
    const auto c = std::ranges::find(fit.coefficients, p.coordinate, &Coefficient::name);
    if (c == fit.coefficients.end()) return {};
    return Found{c->value, c->standard_error ? c->standard_error : c->naive_standard_error};
  }
  for (const CaptureFit& capture : fit.captures) {
    const auto label = capture.labels.find(kPetabCondition);
    if (label == capture.labels.end() || label->second != p.condition) continue;
    const auto own = std::ranges::find(capture.nuisances, p.coordinate, &Nuisance::name);
    if (own != capture.nuisances.end()) return Found{own->value, own->standard_error};
  }
  return {};
}

}  // namespace

std::string petab_parameters(const PetabProblem& problem, const FitResult& fit) {
  std::string text =
      "parameterId\tparameterScale\tlowerBound\tupperBound\tnominalValue\testimate\tstandardError\n";
  for (const PetabParameter& p : problem.parameters) {
    const std::optional<Found> found = p.estimated ? found_of(p, fit) : std::nullopt;
    const std::optional<double> value = found ? std::optional(found->value) : p.nominal;
    text += fmt::format(
        "{}\t{}\t{}\t{}\t{}\t{}\t{}\n", p.id, p.scale.empty() ? "lin" : p.scale,
        p.estimated ? fmt::format("{}", p.lower) : "", p.estimated ? fmt::format("{}", p.upper) : "",
        value ? fmt::format("{}", *value) : "", p.estimated ? 1 : 0,
        found && found->error && std::isfinite(*found->error) ? fmt::format("{}", *found->error) : "");
  }
  return text;
}

std::string petab_simulations(const PetabProblem& problem, const FitResult& fit) {
  std::string text = "observableId\tsimulationConditionId\ttime\tsimulation\n";
  for (const CaptureFit& capture : fit.captures) {
    const std::string& condition = capture.labels.at(kPetabCondition);
    for (Eigen::Index frame = 0; frame < capture.times.size(); ++frame) {
      for (std::size_t o = 0; o < capture.residuals.size(); ++o) {
        const auto column = static_cast<Eigen::Index>(o);
        if (std::isnan(capture.measured(frame, column))) continue;
        text += fmt::format("{}\t{}\t{}\t{}\n", problem.observables.at(capture.residuals[o].output),
                            condition, capture.times[frame], capture.model(frame, column));
      }
    }
  }
  return text;
}

}  // namespace samara::identification
