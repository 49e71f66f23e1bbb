#pragma once

#include "samara/flow/grid/rows.h"

/// Tridiagonal systems along the lines of a grid, the factors of implicit diffusion:
///
///   (1 + r_c (k_c + k_c+ + e_c)) x_c - r_c (k_c x_c- + k_c+ x_c+) = given,   c- and c+ the neighbours along the line
///
/// with couplings k through the lower face of c (and of c+), r the inverse volume, e further losses. For r, k, e >= 0 the
/// matrix is an M-matrix: what is positive stays so.
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

/// kLanes lines side by side by elimination (L. Thomas), in place. @param x, ratio, turn fields, the latter two for work
template <int kLanes, class Coupling, class Inverse, class Loss>
void solve_lines(double* x, double* ratio, double* turn, Index start, Index s, Index lane, Index n,
                 const LineEnds& ends, const Coupling& coupling, const Inverse& inverse, const Loss& loss) {
  const double low_factor = ends.periodic ? 1.0 : ends.low.factor;
  const double high_factor = ends.periodic ? 1.0 : ends.high.factor;
  for (Index i = 0; i < n; ++i) {
    const Index c0 = start + i * s;
    for (Index l = 0; l < kLanes; ++l) {
      const Index c = c0 + l * lane;
      const double r = inverse(c);
      const double below = r * coupling(c) * (i == 0 ? low_factor : 1.0);
      const double above = r * coupling(c + s) * (i == n - 1 ? high_factor : 1.0);
      double diagonal = 1.0 + below + above + r * loss(c);
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
          const double first_below = inverse(first) * coupling(first);
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
    const double along = -inverse(first) * coupling(first) / gamma;
    const double share = (x[first] + along * x[last]) / (1.0 + turn[first] + along * turn[last]);
    for (Index c = first; c <= last; c += s) x[c] -= share * turn[c];
  }
}

/// All lines of a range along a direction.
/// @param ratio, turn fields of the grid for work; turn is used on periodic lines only
template <class Coupling, class Inverse, class Loss>
void solve_all_lines(const MacGrid& grid, const Range& range, int direction, const LineEnds& ends, Field& x,
                     Field& ratio, Field& turn, const Coupling& coupling, const Inverse& inverse,
                     const Loss& loss) {
  constexpr int kTogether = 8;
  const auto along = static_cast<std::size_t>(direction);
  // Lanes lie along x, or along y for lines along x.
  const std::size_t lane_direction = direction == 0 ? 1 : 0;
  const std::size_t third = 3 - along - lane_direction;
  const Index s = grid.stride[along], lane = grid.stride[lane_direction];
  const Index n = range.end[along] - range.begin[along];
  const int lanes = range.end[lane_direction] - range.begin[lane_direction];
  const int blocks = (lanes + kTogether - 1) / kTogether;
  const int layers = range.end[third] - range.begin[third];
  parallel_for(blocks * layers, [&](int task) {
    std::array<int, 3> place = range.begin;
    const int begin = kTogether * (task % blocks);
    place[lane_direction] += begin;
    place[third] += task / blocks;
    const Index start = grid.at(place[0], place[1], place[2]);
    const auto solve = [&]<int kLanes>(Index from) {
      solve_lines<kLanes>(x.data(), ratio.data(), turn.data(), from, s, lane, n, ends, coupling, inverse,
                          loss);
    };
    if (begin + kTogether <= lanes) {
      solve.template operator()<kTogether>(start);
    } else {
      for (int l = 0; l < lanes - begin; ++l) solve.template operator()<1>(start + l * lane);
    }
  });
}

}  // namespace samara::flow
