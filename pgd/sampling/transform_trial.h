#pragma once

#include <vector>

#include "samara/pgd/sampling/sample_table.h"

namespace samara::pgd {

/// A transform for every coordinate: the label's own, or the one under which the function's coefficients
/// along a few lines decay best. About 20 calls per line and coordinate that is tried. @throws
/// SamplingStopped
std::vector<Transform> try_transforms(const std::vector<SampledCoordinate>& coordinates,
                                      SampledFunction& function, std::uint64_t seed);

}  // namespace samara::pgd
