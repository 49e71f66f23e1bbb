#include "samara/flow/turbulence/monotone_transport.h"

#include <algorithm>
#include <cmath>

#include "samara/flow/grid/line_solver.h"
#include "samara/flow/momentum/momentum_flux.h"

namespace samara::flow {

namespace {

/// body(place of the border's face, place of the cell inside) for all cells at an upper or lower border.
template <class Body>
void for_border(const MacGrid& grid, int side, const Body& body) {
  const auto across = static_cast<std::size_t>(side / 2);
  Range layer = all_cells(grid);
  if (side % 2 == 0) {
    layer.end[across] = 1;
  } else {
    layer.begin[across] = grid.cells[across] - 1;
  }
  const Index to_face = side % 2 == 0 ? 0 : grid.stride[across];
  for (int k = layer.begin[2]; k < layer.end[2]; ++k) {
    for (int j = layer.begin[1]; j < layer.end[1]; ++j) {
      for (int i = layer.begin[0]; i < layer.end[0]; ++i) body(grid.at(i, j, k) + to_face, grid.at(i, j, k));
    }
  }
}

/// Through the lower face of cell c.
template <class V>
[[gnu::always_inline]] inline V carried_flux(const double* s, const double* discharge, Index c,
                                             Index across) {
  const V mass = load<V>(discharge + c);
  const double* const at = s + c;
  return mass * upwind_value(mass, load<V>(at - 2 * across), load<V>(at - across), load<V>(at),
                             load<V>(at + across));
}

}  // namespace

double fastest_exchange(const MacGrid& grid, const Openness& open, const FaceField& velocity, RowSums& rows) {
  return rows.maximum(grid, [&](Index row) {
    double largest[kEight] = {};
    by_eights(row, row + grid.cells[0], [&]<class V>(Index c) {
      const V none = {};
      V out = {}, in = {};
      for (int d = 0; d < grid.dimensions; ++d) {
        const auto at = static_cast<std::size_t>(d);
        const Index s = grid.stride[at];
        const double* const u = velocity[at].data() + c;
        const double* const a = open.face[at].data() + c;
        const V low = load<V>(a) * load<V>(u), high = load<V>(a + s) * load<V>(u + s);
        out += larger<V>(high, none) + larger<V>(-low, none);
        in += larger<V>(-high, none) + larger<V>(low, none);
      }
      const V rate = larger(out, in) * load<V>(open.inverse_cell.data() + c);
      store<V>(larger(rate, load<V>(largest)), largest);
    });
    return *std::max_element(largest, largest + kEight);
  }) / grid.spacing;
}

MonotoneTransport::MonotoneTransport(const MacGrid& grid, const Borders& borders, const Openness& open)
    : grid_(grid),
      borders_(borders),
      open_(open),
      discharge_(grid.faces()),
      before_(grid.field()),
      ratio_(grid.field()),
      turn_(grid.field()),
      sums_(grid) {}

double MonotoneTransport::set_velocity(const FaceField& velocity) {
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const double* const a = open_.face[at].data();
    const double* const u = velocity[at].data();
    double* const q = discharge_[at].data();
    for_rows(grid_, all_cells(grid_), [&](Index row, int) {
      for (Index c = row; c <= row + grid_.cells[0]; ++c) q[c] = a[c] * u[c];
    });
    if (d == 0) continue;
    Range last = all_cells(grid_);
    last.begin[at] = grid_.cells[at];
    last.end[at] = grid_.cells[at] + 1;
    for_rows(grid_, last, [&](Index row, int) {
      for (Index c = row; c < row + grid_.cells[0]; ++c) q[c] = a[c] * u[c];
    });
  }
  return fastest_exchange(grid_, open_, velocity, sums_);
}

double MonotoneTransport::advect(Field& s, double step, const std::array<double, 6>& given,
                                 double returning) {
  fill_margins(grid_, borders_, s, given);
  for (int side = 1; side < 2 * grid_.dimensions; side += 2) {
    if (borders_.side[static_cast<std::size_t>(side)].kind != BorderKind::outflow) continue;
    const auto across = static_cast<std::size_t>(side / 2);
    for_border(grid_, side, [&](Index face, Index) {
      if (discharge_[across][static_cast<std::size_t>(face)] >= 0.0) return;
      for (Index m = 0; m < MacGrid::kMargin; ++m)
        s[static_cast<std::size_t>(face + m * grid_.stride[across])] = returning;
    });
  }
  std::swap(s, before_);
  const double* const old = before_.data();
  const double per_spacing = 1.0 / grid_.spacing;
  for_rows(grid_, all_cells(grid_), [&](Index row, int) {
    double* const now = s.data();
    const Index end = row + grid_.cells[0];
    for (Index c = row; c < end; ++c) now[c] = 0.0;
    for (int d = 0; d < grid_.dimensions; ++d) {
      const auto at = static_cast<std::size_t>(d);
      const Index across = grid_.stride[at];
      const double* const q = discharge_[at].data();
      by_eights(row, end, [&]<class V>(Index c) {
        const V out = carried_flux<V>(old, q, c + across, across),
                entering = carried_flux<V>(old, q, c, across);
        store<V>(load<V>(now + c) + (out - entering), now + c);
      });
    }
    const double* const inverse = open_.inverse_cell.data();
    for (Index c = row; c < end; ++c) now[c] = old[c] - step * per_spacing * inverse[c] * now[c];
  });
  double entered = sweeps_ ? add_swept(old, s, step * per_spacing) : 0.0;
  for (int side = 0; side < 2 * grid_.dimensions; ++side) {
    if (borders_.periodic(side / 2)) continue;
    const auto across = static_cast<std::size_t>(side / 2);
    const double inward = side % 2 == 0 ? 1.0 : -1.0;
    for_border(grid_, side, [&](Index face, Index) {
      entered += inward * carried_flux<double>(old, discharge_[across].data(), face, grid_.stride[across]);
    });
  }
  return entered * step * per_spacing;
}

/// @returns what the body's sweeping adds to the sum of V s, over `scale`
double MonotoneTransport::add_swept(const double* old, Field& s, double scale) const {
  double sum = 0.0;
  for (int k = open_.near.begin[2]; k < open_.near.end[2]; ++k) {
    for (int j = open_.near.begin[1]; j < open_.near.end[1]; ++j) {
      for (int i = open_.near.begin[0]; i < open_.near.end[0]; ++i) {
        const auto c = static_cast<std::size_t>(grid_.at(i, j, k));
        if (open_.inverse_cell[c] == 0.0) continue;
        double out = 0.0;
        for (int d = 0; d < grid_.dimensions; ++d) {
          const double* const q = discharge_[static_cast<std::size_t>(d)].data() + c;
          out += q[grid_.stride[static_cast<std::size_t>(d)]] - q[0];
        }
        s[c] += scale * open_.inverse_cell[c] * old[c] * out;
        sum += old[c] * out;
      }
    }
  }
  return sum;
}

double MonotoneTransport::diffuse(Field& s, double step, double viscosity, const Field* eddy, double sigma,
                                  const std::array<double, 6>& given) {
  const double scale = step / (grid_.spacing * grid_.spacing);
  const double* const inverse = open_.inverse_cell.data();
  double entered = 0.0;
  for (int d = 0; d < grid_.dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const Index across = grid_.stride[at];
    const double* const a = open_.face[at].data();
    const double* const turbulent = eddy != nullptr ? eddy->data() : nullptr;
    const double half_over_sigma = 0.5 / sigma;
    const auto coupling = [=]<class V>(Index c) -> V {
      V eddies = {};
      if (turbulent != nullptr)
        eddies = half_over_sigma * (load<V>(turbulent + c) + load<V>(turbulent + c - across));
      return scale * load<V>(a + c) * (viscosity + eddies);
    };
    LineEnds ends{borders_.periodic(d), {}, {}};
    const auto end_of = [&](int side) -> LineEnd {
      const bool wall = borders_.side[static_cast<std::size_t>(side)].kind == BorderKind::wall;
      const double value = given[static_cast<std::size_t>(side)];
      if (!wall || value < 0.0) return {};
      return {.factor = 2.0, .value = value};
    };
    ends.low = end_of(2 * d);
    ends.high = end_of(2 * d + 1);
    solve_all_lines(
        grid_, all_cells(grid_), d, ends, s, ratio_, turn_, coupling,
        [=]<class V>(Index c) { return load<V>(inverse + c); }, []<class V>(Index) { return V{}; });
    for (const int side : {2 * d, 2 * d + 1}) {
      const LineEnd& end = side % 2 == 0 ? ends.low : ends.high;
      if (end.factor == 0.0) continue;
      for_border(grid_, side, [&](Index face, Index cell) {
        entered += end.factor * coupling.template operator()<double>(face) *
                   (end.value - s[static_cast<std::size_t>(cell)]);
      });
    }
  }
  return entered;
}

}  // namespace samara::flow
