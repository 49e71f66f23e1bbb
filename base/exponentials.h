#pragma once

#include <span>

namespace samara {

/// exp(x) in place of each x, in loops that the compiler makes SIMD code of: within 1.1 units in the last place, and
/// the same bits alone, among others and on any machine. 0 below -707.7, where less than 5e-308 would be left; infinite
/// where exp(x) is above the largest double.
void take_exponentials(std::span<double> x);

/// log(x) in place of each positive normal x, within one unit in the last place, in the same way; of
/// other x no number that means anything.
void take_logarithms(std::span<double> x);

}  // namespace samara
