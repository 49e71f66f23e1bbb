#pragma once

#include <map>
#include <optional>
#include <string>

#include "samara/identification/petab/petab_problem.h"
#include "samara/models/trajectories/interval.h"

/// Internal to identification/: what PEtab tables say, as the config of a fit.
namespace samara::identification {

struct PetabSettings {
  std::map<std::string, double> held = {};  ///< coordinates, SI
  /// Of each capture, by labels of their names; where they lie.
  std::map<std::string, models::Interval> known = {};
  std::map<std::string, double> noise = {};  ///< of outputs; where it is estimated, where that begins
  std::map<std::string, std::string> estimated_noise = {};  ///< output -> parameter
  std::optional<double> attitude_noise =
      {};  ///< rad, of the turn about each axis, where an attitude is observed
};

/// TOML.
std::string petab_config(const PetabProblem& problem, const PetabSettings& settings);

}  // namespace samara::identification
