#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/nonlinear/strategy.h"

/// Evolution equations over a box, by any strategy: one march in slabs and cells, which chooses how long slabs
/// are, refines axes, splits the box, and measures its error at guard points (slab_evolution.h).
///
///   const SlabResult result = march(problem, "empirical", {.tolerance = 1e-4});
///   if (result.status != Termination::converged) report(result.message);
namespace samara::pgd {

/// What a plan may name: "slabs", which solves the equations of a slab at the entries of crosses, and the
/// strategies of strategy.h, which turn it into linear problems.
const std::vector<std::string>& strategy_names();

/// One of these names but "slabs". @throws ArgumentError, with the names, if it is none
std::unique_ptr<Strategy> strategy_named(const std::string& name);

/// @param strategy one of strategy_names()
/// @param state of a call with the same problem, strategy and options that was cut off; empty: from the start
/// @throws ArgumentError as solve_by_slabs(), and for a name that is none.
SlabResult march(const AdaptiveProblem& problem, const std::string& strategy, const SlabOptions& options = {},
                 std::span<const double> state = {});

/// The same with a strategy of one's own, or with other options of one of ours.
SlabResult march(const AdaptiveProblem& problem, Strategy& strategy, const SlabOptions& options = {},
                 std::span<const double> state = {});

}  // namespace samara::pgd
