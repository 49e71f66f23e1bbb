#pragma once

#include <filesystem>
#include <string>

#include "samara/pgd/adaptive_evolution.h"

namespace samara::codebooks {

/// Writes the solver's state beside a build, so that the build can go on after a kill. Atomic, like save().
/// @param plan text of the plan, so that no other build takes the state up
void save_checkpoint(const std::filesystem::path& path, const std::string& plan,
                     const pgd::SolverState& state);

/// @throws InputError if the file is broken or belongs to another plan.
pgd::SolverState load_checkpoint(const std::filesystem::path& path, const std::string& plan);

}  // namespace samara::codebooks
