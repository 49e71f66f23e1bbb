#pragma once

#include <Eigen/Core>

#include "samara/pgd/random.h"
#include "samara/pgd/sample_table.h"

namespace samara::pgd {

/// Whether some output looks like narrow peaks on a constant ground: its values at uniform points (outputs x
/// points) hardly differ, in root mean square about the median, compared with its scale. Further random
/// points would see nothing of a peak that is not known yet.
bool looks_like_peaks(const Eigen::MatrixXd& values, const Eigen::VectorXd& scale);

/// Ends of climbs from random points of the box to where the output that looks most like peaks differs most
/// from its median: coordinate by coordinate, with steps that are halved when nothing is gained. The tails of
/// a smooth peak lead to it from far away. Calls about 12 points per coordinate and climb. @returns
/// coordinates x climbs @throws SamplingStopped
Eigen::MatrixXd climb_peaks(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
                            const Eigen::MatrixXd& values, int climbs, Random& random);

}  // namespace samara::pgd
