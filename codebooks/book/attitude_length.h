#pragma once

#include <array>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// Places among `outputs`, those that are wanted of a codebook, of the four numbers of its model's
/// quaternion; nothing without a quaternion, or where not all four are wanted.
std::optional<std::array<int, 4>> quaternion_places(const Codebook& book, const std::vector<int>& outputs);

/// The length of an attitude, which no motion changes: codebooks store the four numbers of its quaternion as
/// they came out of the build, and queries give them the length with which they began. Derivatives go through
/// that.
class AttitudeLength {
 public:
  /// @param outputs places in the codebook of those that are wanted
  /// @returns nothing where not all four numbers are wanted, or the attitude at the beginning is an axis:
  ///   then lengths differ, and are the caller's
  static std::optional<AttitudeLength> of(const Codebook& book, const std::vector<int>& outputs);

  /// Of the numbers, w first, among the outputs wanted.
  const std::array<int, 4>& places() const { return place_; }
  double length() const { return length_; }

  /// @param columns of rows (outputs, each at all times): values, first derivatives by `coordinates`, second
  ///   ones, as PackedField::point has them, up to `order`
  void restore(double* const* columns, int order, int coordinates, int times) const;

 private:
  std::array<int, 4> place_ = {};  ///< among the outputs wanted
  double length_ = 1.0;
};

}  // namespace samara::codebooks
