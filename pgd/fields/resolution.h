#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/separated_field.h"

namespace samara::pgd {

/// How well an axis resolves a field: the two highest Legendre coefficients along it (sizes summed), in the
/// worst element, output and point of `samples` seeded random nodes of the other axes; outputs divided by
/// their scales. On fourier axes the cosine and sine coefficients of the two highest harmonics. A measure of
/// the largest error that the next finer axis would mend; zero on finite elements (p1, p2) and lists, which
/// have no coefficients to spare. O(samples R elements).
double highest_coefficients(const SeparatedField& field, int axis, std::span<const double> scales,
                            int samples, std::uint64_t seed);

/// Rows that take values at the nodes of an axis to its highest coefficients in the sense of
/// highest_coefficients(), two of every element or four of a period; none where there is no coefficient to
/// spare.
Eigen::MatrixXd highest_coefficient_rows(const Axis& axis);

/// Largest minus smallest value of every output over `samples` seeded random nodes of the axes, of which
/// every second one per axis is an end of its interval.
std::vector<double> sampled_ranges(const SeparatedField& field, int samples, std::uint64_t seed);

}  // namespace samara::pgd
