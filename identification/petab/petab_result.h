#pragma once

#include <string>
#include <vector>

#include "samara/identification/petab/petab_problem.h"
#include "samara/identification/problem/fit_result.h"

/// A fit as PEtab tables; internal to identification/.
namespace samara::identification {

/// The rows of the table of parameters as they were read, with what was found as nominalValue, and standardError
/// beside it, empty where there is none.
std::string petab_parameters(const PetabProblem& problem, const FitResult& fit);

/// A sentence for each noise level that was found outside the bounds of its parameter, which bound no fit.
std::vector<std::string> petab_noise_outside_bounds(const PetabProblem& problem, const FitResult& fit);

/// The table of simulations: what the model says at each measurement, in the order of captures, times and observables.
/// Of an attitude, whose four numbers are compared as one turn, there are no rows.
std::string petab_simulations(const PetabProblem& problem, const FitResult& fit);

}  // namespace samara::identification
