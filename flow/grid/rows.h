#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "samara/base/parallel.h"
#include "samara/flow/grid/mac_grid.h"

/// Loops over the rows of a grid. What they compute does not depend on the number of threads: a row is worked on by
/// one thread, and sums over rows are added in the order of the rows.
namespace samara::flow {

/// Eight numbers that machines compute at once; with shorter registers they take several. What is marked below is
/// inlined, so that none is ever handed over between sources that are built for different machines.
using Eight = double __attribute__((vector_size(64)));
inline constexpr Index kEight = 8;
/// Registers of two numbers, for any machine, are too few for it: there all goes by single numbers.
#ifdef __AVX__
inline constexpr bool kHasEights = true;
#else
inline constexpr bool kHasEights = false;
#endif

/// A number, or eight neighbours.
template <class V>
[[gnu::always_inline]] inline V load(const double* from) {
  V value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class V>
[[gnu::always_inline]] inline void store(const V& value, double* to) {
  std::memcpy(to, &value, sizeof value);
}

template <class V>
[[gnu::always_inline]] inline V larger(const V& a, const V& b) {
  return a > b ? a : b;
}

[[gnu::always_inline]] inline double sum_of(const double (&lanes)[kEight]) {
  double sum = 0.0;
  for (const double value : lanes) sum += value;
  return sum;
}

/// body.operator()<V>(place) for all from `begin` to `end`: eight places at a time as Eight, what is left as double.
template <class Body>
[[gnu::always_inline]] inline void by_eights(Index begin, Index end, const Body& body) {
  Index c = begin;
  if constexpr (kHasEights) {
    for (; c + kEight <= end; c += kEight) body.template operator()<Eight>(c);
  }
  for (; c < end; ++c) body.template operator()<double>(c);
}

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

/// Largest |value| of a row; infinite where one is not finite, which a maximum alone would pass over.
inline double largest_size(const double* values, Index count) {
  constexpr Index kLanes = 8;
  double largest[kLanes] = {}, sum[kLanes] = {};
  const auto look = [&](Index i, Index lane) {
    const double size = std::abs(values[i]);
    largest[lane] = size > largest[lane] ? size : largest[lane];
    sum[lane] += size;
  };
  Index i = 0;
  for (; i + kLanes <= count; i += kLanes) {
    for (Index lane = 0; lane < kLanes; ++lane) look(i + lane, lane);
  }
  for (; i < count; ++i) look(i, 0);
  double all = 0.0, most = 0.0;
  for (Index lane = 0; lane < kLanes; ++lane) {
    all += sum[lane];
    most = std::max(most, largest[lane]);
  }
  return std::isfinite(all) ? most : INFINITY;
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

  /// largest |of_row(first place of the row)|; infinite where one is not finite
  template <class OfRow>
  double maximum(const MacGrid& grid, const OfRow& of_row) {
    for_rows(grid, all_cells(grid),
             [&](Index row, int r) { sums_[static_cast<std::size_t>(r)] = of_row(row); });
    return largest_size(sums_.data(), static_cast<Index>(sums_.size()));
  }

 private:
  std::vector<double> sums_;
};

}  // namespace samara::flow
