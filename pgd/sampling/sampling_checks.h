#pragma once

#include "samara/pgd/sampling/sampling.h"

namespace samara::pgd {

/// Nodes with which every coordinate begins.
inline constexpr int kFewestNodes = 3;

/// What sample() refuses. @throws ArgumentError as sample() says
void check_sampling(const std::vector<SampledCoordinate>& coordinates,
                    const std::vector<OutputLabel>& outputs, const PointsFunction& function,
                    const SamplingOptions& options);

}  // namespace samara::pgd
