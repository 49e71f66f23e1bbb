#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "samara/pgd/separated_field.h"

namespace samara::pgd {

/// How well an axis resolves a field: the two highest Legendre coefficients along it, in the worst element,
/// as a root mean square over all other axes and over the outputs, each divided by its scale. A measure of
/// the size of what the next finer axis would add; zero on P1 axes, which have no coefficients to spare.
double highest_coefficients(const SeparatedField& field, int axis, std::span<const double> scales);

/// Largest minus smallest value of every output over `samples` seeded random nodes of the axes, of which
/// every second one per axis is an end of its interval.
std::vector<double> sampled_ranges(const SeparatedField& field, int samples, std::uint64_t seed);

}  // namespace samara::pgd
