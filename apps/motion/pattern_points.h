#pragma once

#include "motion/patterns_arguments.h"
#include "samara/motion/sweeps/sweep.h"

/// `samara patterns SWEEP --draw PATTERN` and `--clamp PATTERN`: points of the box by the pattern that they lead to.
namespace samara::apps {

/// Whether the call asks for points in place of a report.
bool asks_for_points(const PatternsArguments& arguments);

/// @throws ArgumentError for words of one beside the other, words of points without either, and those of reports beside
/// them
void check_point_words(const PatternsArguments& arguments);

/// Writes the table of the points, or with --json what the map says of each.
/// @returns the exit code
/// @throws ArgumentError for an unknown pattern, coordinate or release, a pattern that no fall of the release has, a
/// coordinate that is missing or twice given
int points_of_map(const PatternsArguments& arguments, const motion::Sweep& sweep);

}  // namespace samara::apps
