#pragma once

#include <optional>
#include <span>
#include <vector>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// Whether points with these values of some coordinates may lie in a piece: inside its box and, of lists, among their
/// values.
/// @param values one per coordinate, empty where it is free
/// @param by_box whether the box says all, as no axis is a list; then the piece is not read
bool holds(const Piece& piece, std::span<const std::optional<double>> values, bool by_box);

/// Finds the piece that answers for a point: the first one that holds it. O(log pieces) where pieces are
/// slabs of the first coordinate; does not allocate.
class PieceFinder {
 public:
  struct Interval {
    double lower = 0.0;
    double upper = 0.0;
  };
  struct Box {
    std::vector<Interval> intervals;
    /// Axes that are lists of values, where being inside is not enough; else empty places.
    std::vector<std::optional<pgd::Axis>> lists;
  };
  /// Boxes of the pieces, in their order, over the same coordinates.
  explicit PieceFinder(const std::vector<Box>& pieces);

  /// The place of the piece, or -1 in a gap. @param x finite
  int find(const double* x) const;
  /// Whether that piece holds the point, borders included. @param x finite
  bool contains(int piece, const double* x) const;

 private:
  std::size_t dimensions_ = 0;
  std::vector<Interval> boxes_;  ///< pieces x coordinates
  struct List {
    int piece = 0;
    std::size_t coordinate = 0;
    pgd::Axis axis;
  };
  std::vector<List> lists_;
  std::vector<double> borders_;  ///< of all pieces on the first coordinate, ascending
  /// Pieces that meet (border i - 1, border i], in their order.
  std::vector<std::vector<int>> candidates_;
};

}  // namespace samara::codebooks
