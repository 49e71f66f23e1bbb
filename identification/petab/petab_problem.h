#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/petab/petab_file.h"
#include "samara/identification/problem/fit_config.h"

/// Fits as PEtab states them (L. Schmiester et al., PLoS Comput. Biol. 17 (2021) e1008646), version 1: tables of
/// parameters, conditions, observables and measurements become captures and the config of a fit.
///
/// The model is that of the call, not the SBML file. Numbers are in SI units. Ids are names of the model; an initial
/// value "v(0)" is called v_0, or, as a column of the conditions, v. Understood are: observables that are one output
/// of the model, normal noise of one level for each (a number, a parameter held, or one that is estimated),
/// conditions that set parameters and initial values to numbers or to parameters, bounds, scales, nominal values, and
/// priors that are uniform, normal, log-normal. All else is refused by its name: preequilibration, observables that
/// are formulas, noise that changes along a measurement, times without end. Internal to identification/.
namespace samara::identification {

struct PetabParameter {
  std::string id = {};
  bool estimated = false;
  double lower = 0.0, upper = 0.0;  ///< of the bounds and a uniform prior
  std::optional<double> nominal = {};
  std::string scale = {};  ///< "lin", "log", "log10"
  std::string prior = {};  ///< "normal", "logNormal"; empty: none
  /// Of what is a square beside the frames: where it is lowest, and the deviation; of logNormal both of ln x.
  std::vector<double> prior_numbers = {};
  int line = 0;
  std::string coordinate = {};  ///< of the model, where it stands for one
  std::string condition = {};   ///< whose alone it is; empty: of all
  std::string noise_of = {};    ///< output whose noise it is
};

struct PetabProblem {
  PetabFile file = {};
  std::vector<PetabParameter> parameters = {};
  std::vector<std::string> parameter_columns = {};             ///< of the table of parameters, as it was read
  std::vector<std::vector<std::string>> parameter_cells = {};  ///< column by column
  std::map<std::string, std::string> observables = {};         ///< output -> observableId
  std::vector<Capture> captures = {};                          ///< one for each condition and replicate
  std::string config = {};                                     ///< TOML, as parse_fit_config() takes it
};

/// The label of a capture that names its condition.
constexpr const char* kPetabCondition = "simulationConditionId";

/// @param names of the model or codebook that is fitted @param free coordinates that have to be told of: those of a
/// codebook
/// @throws InputError with file and line
PetabProblem read_petab(const std::filesystem::path& path, const ConfigNames& names,
                        const std::vector<std::string>& free = {});

}  // namespace samara::identification
