#pragma once

#include <vector>

#include "samara/pgd/fields/train_field.h"
#include "samara/pgd/sampling/sample_table.h"

namespace samara::pgd {

/// A train on the outputs and Leja nodes as a field on Chebyshev axes of the same degree.
TrainField on_chebyshev_axes(const std::vector<SampledCoordinate>& coordinates,
                             const std::vector<CoordinateMap>& maps, const std::vector<OutputLabel>& outputs,
                             TensorTrain train);

}  // namespace samara::pgd
