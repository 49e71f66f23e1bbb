#pragma once

#include <span>
#include <vector>

#include "samara/codebooks/codebook.h"

namespace samara::codebooks {

/// @throws ArgumentError if a coordinate is not finite, OutsideBoxError naming the first one outside its
/// interval.
void require_inside(std::span<const Coordinate> coordinates, std::span<const double> x);

/// Whether the axes' box (borders included) holds the point.
bool contains(std::span<const pgd::Axis> axes, std::span<const double> x);

/// The nearest point of the box; coordinates that are not finite stay.
std::vector<double> clamped(std::span<const Coordinate> coordinates, std::span<const double> x);

}  // namespace samara::codebooks
