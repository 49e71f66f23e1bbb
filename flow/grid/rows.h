#pragma once

#include <algorithm>
#include <array>

#include "samara/base/parallel.h"
#include "samara/flow/grid/mac_grid.h"

/// Loops over the rows of a grid. What they compute does not depend on the number of threads: a row is worked on by
/// one thread, and sums over rows are added in the order of the rows.
namespace samara::flow {

/// body(place of the first entry of a row, its number among the rows) for every row of the range.
template <class Body>
void for_rows(const MacGrid& grid, const Range& range, const Body& body) {
  const int height = range.end[1] - range.begin[1];
  const int rows = range.rows();
  const auto one = [&](int row) {
    body(grid.at(range.begin[0], range.begin[1] + row % height, range.begin[2] + row / height), row);
  };
  // Below this the threads cost more than they save.
  constexpr long kWorthThreads = 6000;
  if (static_cast<long>(rows) * range.width() < kWorthThreads) {
    for (int row = 0; row < rows; ++row) one(row);
    return;
  }
  constexpr int kRowsTogether = 8;
  parallel_for((rows + kRowsTogether - 1) / kRowsTogether, [&](int block) {
    const int end = std::min(rows, (block + 1) * kRowsTogether);
    for (int row = block * kRowsTogether; row < end; ++row) one(row);
  });
}

/// Sums and maxima over rows, with memory for one number a row.
class RowSums {
 public:
  explicit RowSums(const MacGrid& grid) : sums_(static_cast<std::size_t>(grid.cells[1] * grid.cells[2])) {}

  /// sum of of_row(first place of the row) over the rows of the cells
  template <class OfRow>
  double sum(const MacGrid& grid, const OfRow& of_row) {
    for_rows(grid, all_cells(grid),
             [&](Index row, int r) { sums_[static_cast<std::size_t>(r)] = of_row(row); });
    double sum = 0.0;
    for (const double value : sums_) sum += value;
    return sum;
  }

  template <class OfRow>
  double maximum(const MacGrid& grid, const OfRow& of_row) {
    for_rows(grid, all_cells(grid),
             [&](Index row, int r) { sums_[static_cast<std::size_t>(r)] = of_row(row); });
    return *std::max_element(sums_.begin(), sums_.end());
  }

 private:
  std::vector<double> sums_;
};

}  // namespace samara::flow
