#pragma once

#include <string>

#include "samara/identification/petab/petab_problem.h"
#include "samara/identification/problem/fit_result.h"

/// A fit as PEtab tables; internal to identification/.
namespace samara::identification {

/// The table of parameters with what was found as nominalValue, and standardError beside it, empty where there is none.
std::string petab_parameters(const PetabProblem& problem, const FitResult& fit);

/// The table of simulations: what the model says at each measurement, in the order of captures, times and observables.
std::string petab_simulations(const PetabProblem& problem, const FitResult& fit);

}  // namespace samara::identification
