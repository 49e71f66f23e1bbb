#pragma once

#include "samara/flow/grid/rows.h"

/// Tridiagonal systems along the lines of a grid, the factors of implicit diffusion:
///
///   (1 + r_c (k_c + k_c+ + e_c)) x_c - r_c (k_c x_c- + k_c+ x_c+) = given,   c- and c+ the neighbours along the line
///
/// with couplings k through the lower face of c (and of c+), r the inverse volume, e further losses. For r, k, e >= 0
/// the matrix is an M-matrix: what is positive stays so.
namespace samara::flow {

/// What stands beyond the ends of lines: the coupling there is multiplied by `factor`, to a neighbour that is `value`.
/// 0: no flux; 1: a neighbour one spacing away; 2: a border half a spacing away.
struct LineEnd {
  double factor = 0.0;
  double value = 0.0;
};

struct LineEnds {
  bool periodic = false;
  LineEnd low, high;
};

/// What couplings, inverses and losses give at a place: f.operator()<V>(place) of one line, or of eight neighbours.
template <class V, class Function>
[[gnu::always_inline]] inline V value_of(const Function& f, Index c) {
  return f.template operator()<V>(c);
}

/// kLanes lines side by side by elimination (L. Thomas), in place. @param x, ratio, turn fields, the latter two for
/// work
template <int kLanes, class Coupling, class Inverse, class Loss>
void solve_lines(double* x, double* ratio, double* turn, Index start, Index s, Index lane, Index n,
                 const LineEnds& ends, const Coupling& coupling, const Inverse& inverse, const Loss& loss) {
  const double low_factor = ends.periodic ? 1.0 : ends.low.factor;
  const double high_factor = ends.periodic ? 1.0 : ends.high.factor;
  for (Index i = 0; i < n; ++i) {
    const Index c0 = start + i * s;
    for (Index l = 0; l < kLanes; ++l) {
      const Index c = c0 + l * lane;
      const double r = value_of<double>(inverse, c);
      const double below = r * value_of<double>(coupling, c) * (i == 0 ? low_factor : 1.0);
      const double above = r * value_of<double>(coupling, c + s) * (i == n - 1 ? high_factor : 1.0);
      double diagonal = 1.0 + below + above + r * value_of<double>(loss, c);
      double right = x[c];
      double corner = 0.0;  // of the column that a periodic line adds
      if (i == 0) {
        // Sherman and Morrison: the corners of the matrix are a product of two vectors.
        if (ends.periodic) {
          corner = -diagonal;
          diagonal *= 2.0;
        } else {
          right += below * ends.low.value;
        }
      }
      if (i == n - 1) {
        if (ends.periodic) {
          const Index first = start + l * lane;
          const double first_below = value_of<double>(inverse, first) * value_of<double>(coupling, first);
          const double gamma = -0.5 / ratio[first - s];
          diagonal -= first_below * above / gamma;
          corner = -above;
        } else {
          right += above * ends.high.value;
        }
      }
      if (i == 0 && ends.periodic)
        ratio[c - s] = 1.0 / diagonal;  // kept for the last row; -gamma is half the diagonal
      const double pivot = 1.0 / (i == 0 ? diagonal : diagonal - below * ratio[c - s]);
      ratio[c] = above * pivot;
      x[c] = (i == 0 ? right : right + below * x[c - s]) * pivot;
      if (ends.periodic) turn[c] = (i == 0 ? corner : corner + below * turn[c - s]) * pivot;
    }
  }
  for (Index i = n - 2; i >= 0; --i) {
    const Index c0 = start + i * s;
    for (Index l = 0; l < kLanes; ++l) {
      const Index c = c0 + l * lane;
      x[c] += ratio[c] * x[c + s];
      if (ends.periodic) turn[c] += ratio[c] * turn[c + s];
    }
  }
  if (!ends.periodic) return;
  for (Index l = 0; l < kLanes; ++l) {
    const Index first = start + l * lane, last = first + (n - 1) * s;
    const double gamma = -0.5 / ratio[first - s];
    const double along = -value_of<double>(inverse, first) * value_of<double>(coupling, first) / gamma;
    const double share = (x[first] + along * x[last]) / (1.0 + turn[first] + along * turn[last]);
    for (Index c = first; c <= last; c += s) x[c] -= share * turn[c];
  }
}

/// Neighbours along x: lines along another direction, that are not periodic, from their first places `start` to `end`.
template <class Coupling, class Inverse, class Loss>
void solve_columns(double* x, double* ratio, Index start, Index end, Index s, Index n, const LineEnds& ends,
                   const Coupling& coupling, const Inverse& inverse, const Loss& loss) {
  for (Index i = 0; i < n; ++i) {
    const bool first = i == 0;
    const double low_factor = first ? ends.low.factor : 1.0;
    const double high_factor = i == n - 1 ? ends.high.factor : 1.0;
    const double beyond = i == n - 1 ? ends.high.value : 0.0;
    by_eights(start + i * s, end + i * s, [&]<class V>(Index c) {
      const V r = value_of<V>(inverse, c);
      const V below = r * value_of<V>(coupling, c) * low_factor;
      const V above = r * value_of<V>(coupling, c + s) * high_factor;
      V diagonal = 1.0 + below + above + r * value_of<V>(loss, c);
      V right = load<V>(x + c) + above * beyond;
      if (first) {
        right += below * ends.low.value;
      } else {
        diagonal -= below * load<V>(ratio + c - s);
        right += below * load<V>(x + c - s);
      }
      const V pivot = 1.0 / diagonal;
      store<V>(above * pivot, ratio + c);
      store<V>(right * pivot, x + c);
    });
  }
  for (Index i = n - 2; i >= 0; --i) {
    by_eights(start + i * s, end + i * s, [&]<class V>(Index c) {
      store<V>(load<V>(x + c) + load<V>(ratio + c) * load<V>(x + c + s), x + c);
    });
  }
}

/// Rows and columns of eight by eight, exchanged.
[[gnu::always_inline]] inline void transpose(Eight (&rows)[kEight]) {
  const auto exchange = [&](Index apart, const auto& low_halves, const auto& high_halves) {
    for (Index i = 0; i < kEight; ++i) {
      if ((i & apart) != 0) continue;
      const Eight low = rows[i], high = rows[i + apart];
      rows[i] = low_halves(low, high);
      rows[i + apart] = high_halves(low, high);
    }
  };
  exchange(
      1,
      [](const Eight& a, const Eight& b) { return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14); },
      [](const Eight& a, const Eight& b) {
        return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
      });
  exchange(
      2,
      [](const Eight& a, const Eight& b) { return __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13); },
      [](const Eight& a, const Eight& b) {
        return __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
      });
  exchange(
      4,
      [](const Eight& a, const Eight& b) { return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11); },
      [](const Eight& a, const Eight& b) {
        return __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
      });
}

/// Eight rows, `lane` apart, as lines along x that are not periodic.
/// @param across_x, across_ratio room for 8 n numbers, in which the rows lie side by side
template <class Coupling, class Inverse, class Loss>
void solve_eight_rows(double* x, double* across_x, double* across_ratio, Index start, Index lane, Index n,
                      const LineEnds& ends, const Coupling& coupling, const Inverse& inverse,
                      const Loss& loss) {
  Eight x_before = {}, ratio_before = {};
  x_before += ends.low.value;
  for (Index i = 0; i < n; i += kEight) {
    const Index count = std::min(kEight, n - i);
    Eight below[kEight], above[kEight], diagonal[kEight], right[kEight];
    for (Index l = 0; l < kEight; ++l) {
      double* const lower = reinterpret_cast<double*>(&below[l]);
      double* const upper = reinterpret_cast<double*>(&above[l]);
      double* const middle = reinterpret_cast<double*>(&diagonal[l]);
      double* const given = reinterpret_cast<double*>(&right[l]);
      const Index row = start + l * lane + i;
      by_eights(row, row + count, [&]<class V>(Index c) {
        const V r = value_of<V>(inverse, c);
        const V low = r * value_of<V>(coupling, c), high = r * value_of<V>(coupling, c + 1);
        store<V>(low, lower + (c - row));
        store<V>(high, upper + (c - row));
        store<V>(1.0 + r * value_of<V>(loss, c), middle + (c - row));
        store<V>(load<V>(x + c), given + (c - row));
      });
    }
    transpose(below);
    transpose(above);
    transpose(diagonal);
    transpose(right);
    if (i == 0) below[0] *= ends.low.factor;
    if (i + count == n) {
      above[count - 1] *= ends.high.factor;
      right[count - 1] += above[count - 1] * ends.high.value;
    }
    for (Index k = 0; k < count; ++k) {
      const Eight pivot = 1.0 / (diagonal[k] + below[k] + above[k] - below[k] * ratio_before);
      ratio_before = above[k] * pivot;
      x_before = (right[k] + below[k] * x_before) * pivot;
      store(ratio_before, across_ratio + kEight * (i + k));
      store(x_before, across_x + kEight * (i + k));
    }
  }
  Eight x_after = {};
  for (Index i = (n - 1) / kEight * kEight; i >= 0; i -= kEight) {
    const Index count = std::min(kEight, n - i);
    Eight found[kEight] = {};
    for (Index k = count - 1; k >= 0; --k) {
      found[k] = load<Eight>(across_x + kEight * (i + k));
      if (i + k < n - 1) found[k] += load<Eight>(across_ratio + kEight * (i + k)) * x_after;
      x_after = found[k];
    }
    transpose(found);
    for (Index l = 0; l < kEight; ++l)
      std::memcpy(x + start + l * lane + i, &found[l], sizeof(double) * static_cast<std::size_t>(count));
  }
}

/// All lines of a range along a direction.
/// @param ratio, turn fields of the grid for work
template <class Coupling, class Inverse, class Loss>
void solve_all_lines(const MacGrid& grid, const Range& range, int direction, const LineEnds& ends, Field& x,
                     Field& ratio, Field& turn, const Coupling& coupling, const Inverse& inverse,
                     const Loss& loss) {
  // Of lines along x, whose lanes lie along y, as many as there are in an Eight; of others what stays near.
  const Index together = direction == 0 ? kEight : 8 * kEight;
  const auto along = static_cast<std::size_t>(direction);
  const std::size_t lane_direction = direction == 0 ? 1 : 0;
  const std::size_t third = 3 - along - lane_direction;
  const Index s = grid.stride[along], lane = grid.stride[lane_direction];
  const Index n = range.end[along] - range.begin[along];
  const Index lanes = range.end[lane_direction] - range.begin[lane_direction];
  const Index blocks = (lanes + together - 1) / together;
  const Index layers = range.end[third] - range.begin[third];
  parallel_for(blocks * layers, [&](Index task) {
    std::array<int, 3> place = range.begin;
    const Index begin = together * (task % blocks), count = std::min(together, lanes - begin);
    place[lane_direction] += static_cast<int>(begin);
    place[third] += static_cast<int>(task / blocks);
    const Index start = grid.at(place[0], place[1], place[2]);
    if (!ends.periodic && direction > 0)
      return solve_columns(x.data(), ratio.data(), start, start + count, s, n, ends, coupling, inverse, loss);
    // The room of eight rows of these fields is that of the numbers side by side.
    if (kHasEights && !ends.periodic && count == kEight)
      return solve_eight_rows(x.data(), turn.data() + start, ratio.data() + start, start, lane, n, ends,
                              coupling, inverse, loss);
    const auto solve = [&]<int kLanes>(Index from) {
      solve_lines<kLanes>(x.data(), ratio.data(), turn.data(), from, s, lane, n, ends, coupling, inverse,
                          loss);
    };
    Index l = 0;
    for (; l + kEight <= count; l += kEight)
      solve.template operator()<static_cast<int>(kEight)>(start + l * lane);
    for (; l < count; ++l) solve.template operator()<1>(start + l * lane);
  });
}

}  // namespace samara::flow
