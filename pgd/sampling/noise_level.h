#pragma once

#include "samara/pgd/sampling/sample_table.h"
#include "samara/pgd/tensors/random.h"

namespace samara::pgd {

/// How noisy a function is: the standard deviation of its values about a smooth function, over the scale, of
/// the output in which it is largest; zero where no place looks noisy.
///
/// Seven points a short way apart (1e-6 of the box, and 1e-3 for noise with plateaus) on lines through random
/// places make tables of differences; of a smooth function the differences of high order vanish, of noise
/// they tell its size. Only places where several orders agree count. Calls 42 points. Reference: J. J. More
/// and S. M. Wild, Estimating computational noise, SIAM J. Sci. Comput. 33 (2011). @throws SamplingStopped
double noise_level(const std::vector<SampledCoordinate>& coordinates, SampledFunction& function,
                   Random& random);

}  // namespace samara::pgd
