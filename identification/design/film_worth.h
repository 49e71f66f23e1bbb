#pragma once

#include <vector>

#include "samara/identification/design/precision.h"

/// Internal to identification/: which outputs and times of given captures say something.
namespace samara::identification {

/// Fills outputs, lengths, sufficient_duration and frame_counts, and times if they are asked for.
void add_film_worth(const RowsOfCaptures& captures, const Experiment& experiment, const Precision& precision,
                    const DesignOptions& options, Design& design);

}  // namespace samara::identification
