#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// @throws ArgumentError if a coordinate is not finite, OutsideBoxError naming the first one outside its
/// interval.
void require_inside(std::span<const Coordinate> coordinates, std::span<const double> x);

/// Rows and columns of a matrix.
struct Size {
  Eigen::Index rows = 0;
  Eigen::Index columns = 0;

  bool operator==(const Size&) const = default;
};

template <class Matrix>
Size size_of(const Matrix& matrix) {
  return {matrix.rows(), matrix.cols()};
}

/// @param what the answer, for the message
/// @throws ArgumentError if the matrix that a caller gave for an answer has another size.
void require_size(const char* what, Size found, Size expected);

}  // namespace samara::codebooks
