#pragma once

#include <vector>

#include "samara/pgd/sample_table.h"
#include "samara/pgd/train_field.h"

namespace samara::pgd {

/// A train on the outputs and Leja nodes as a field on Chebyshev axes of the same degree.
TrainField on_chebyshev_axes(const std::vector<SampledCoordinate>& coordinates,
                             const std::vector<CoordinateMap>& maps, const std::vector<OutputLabel>& outputs,
                             TensorTrain train);

}  // namespace samara::pgd
