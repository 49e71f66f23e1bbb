#pragma once

#include "motion/patterns_arguments.h"

namespace samara::apps {

/// `samara patterns SWEEP`: counts, map, clusters and landing, or points of the map.
/// @returns the exit code
/// @throws ArgumentError for options of captures, and as points_of_map()
int patterns_of_sweep(const PatternsArguments& arguments);

}  // namespace samara::apps
