#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "samara/identification/petab/petab_problem.h"

/// The table of parameters of a PEtab problem; internal to identification/.
namespace samara::identification {

struct PetabParameters {
  std::vector<PetabParameter> rows;             ///< bounds narrowed by uniform priors
  std::vector<std::string> columns;             ///< as the file has them
  std::vector<std::vector<std::string>> cells;  ///< column by column
};

/// @throws InputError with file and line for what is no such table
PetabParameters read_petab_parameters(const std::filesystem::path& path);

}  // namespace samara::identification
