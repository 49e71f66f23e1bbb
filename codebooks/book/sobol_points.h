#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace samara::codebooks {

/// Scrambled Sobol' points in the unit cube: dimensions x count, each coordinate in [0, 1).
/// Direction numbers by Joe and Kuo (Boost.Random), nested uniform scrambling by the hash of Laine and Karras
/// as in Burley, Practical hash-based Owen scrambling, JCGT 9 (2020). Another seed gives an independent set.
/// There are direction numbers for 3667 dimensions; points are plain random ones in those beyond.
Eigen::MatrixXd sobol_points(int dimensions, int count, std::uint64_t seed);

}  // namespace samara::codebooks
