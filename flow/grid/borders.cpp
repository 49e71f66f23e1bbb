#include "samara/flow/grid/borders.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::flow {

namespace {

const char* border_name(int side) {
  constexpr std::array kNames = {"x low", "x high", "y low", "y high", "z low", "z high"};
  return kNames.at(static_cast<std::size_t>(side));
}

/// body(place) of the cells of the first layer at a lower border, margins of the other directions included.
template <class Body>
void for_layer(const MacGrid& grid, int direction, const Body& body) {
  std::array<int, 3> begin = {}, end = {};
  for (int d = 0; d < 3; ++d) {
    const auto at = static_cast<std::size_t>(d);
    const int margin = d < grid.dimensions && d != direction ? MacGrid::kMargin : 0;
    begin[at] = -margin;
    end[at] = d == direction ? 1 : grid.cells[at] + margin;
  }
  for (int k = begin[2]; k < end[2]; ++k) {
    for (int j = begin[1]; j < end[1]; ++j) {
      for (int i = begin[0]; i < end[0]; ++i) body(grid.at(i, j, k));
    }
  }
}

/// Copies across a periodic direction; faces at both ends are one.
void wrap(const MacGrid& grid, int direction, Field& field) {
  const auto d = static_cast<std::size_t>(direction);
  const Index s = grid.stride[d], n = grid.cells[d];
  for_layer(grid, direction, [&](Index c) {
    double* const row = field.data() + c;
    for (Index m = 1; m <= MacGrid::kMargin; ++m) row[-m * s] = row[((2 * n - m) % n) * s];
    for (Index m = 0; m < MacGrid::kMargin; ++m) row[(n + m) * s] = row[(m % n) * s];
  });
}

/// Normal component beyond its border face, which holds the value there.
void continue_normal(Field& u, Index face, Index inward, const Border& border) {
  const bool mirrored = border.kind == BorderKind::wall || border.kind == BorderKind::slip;
  double* const at = u.data() + face;
  at[-inward] = mirrored ? -at[inward] : at[0];
}

/// Tangential component in the margin, from the two values inside.
void continue_tangential(Field& u, Index cell, Index inward, double border_value, const Border& border) {
  double* const at = u.data() + cell;
  const bool given =
      border.kind == BorderKind::inflow || (border.kind == BorderKind::wall && !border.wall_law);
  for (Index m = 1; m <= MacGrid::kMargin; ++m) {
    const double inside = at[(m - 1) * inward];
    at[-m * inward] = given ? 2.0 * border_value - inside : inside;
  }
}

}  // namespace

bool Borders::has_outflow() const {
  return std::any_of(side.begin(), side.end(), [](const Border& b) { return b.kind == BorderKind::outflow; });
}

void Borders::check(int dimensions) const {
  for (int s = 0; s < 2 * dimensions; ++s) {
    const Border& border = side[static_cast<std::size_t>(s)];
    const Border& opposite = side[static_cast<std::size_t>(s ^ 1)];
    if (!border.velocity.allFinite())
      throw ArgumentError(fmt::format("the velocity at the border {} is not finite", border_name(s)));
    if (!std::isfinite(border.k) || !std::isfinite(border.epsilon) || border.k < 0.0 ||
        (border.k > 0.0) != (border.epsilon > 0.0))
      throw ArgumentError(fmt::format(
          "k and epsilon at the border {} are {} and {}, expected both positive and finite, or both 0",
          border_name(s), border.k, border.epsilon));
    if (border.kind == BorderKind::periodic && opposite.kind != BorderKind::periodic) {
      throw ArgumentError(fmt::format("the border {} is periodic, and the opposite one is not: expected both",
                                      border_name(s)));
    }
    if (border.kind == BorderKind::outflow && s % 2 == 0)
      throw ArgumentError(
          fmt::format("the border {} is an outflow, expected one at an upper border", border_name(s)));
    if (border.kind == BorderKind::wall && border.velocity(s / 2) != 0.0)
      throw ArgumentError(fmt::format("the wall at the border {} moves across itself, at {}", border_name(s),
                                      border.velocity(s / 2)));
  }
}

void set_border_faces(const MacGrid& grid, const Borders& borders, FaceField& velocity) {
  for (int side = 0; side < 2 * grid.dimensions; ++side) {
    const int d = side / 2;
    const auto at = static_cast<std::size_t>(d);
    const Border& border = borders.side[static_cast<std::size_t>(side)];
    if (border.kind == BorderKind::periodic || border.kind == BorderKind::outflow) continue;
    Range faces = {{0, 0, 0}, grid.cells};
    faces.begin[at] = side % 2 == 0 ? 0 : grid.cells[at];
    faces.end[at] = faces.begin[at] + 1;
    for (int k = faces.begin[2]; k < faces.end[2]; ++k) {
      for (int j = faces.begin[1]; j < faces.end[1]; ++j) {
        for (int i = faces.begin[0]; i < faces.end[0]; ++i) {
          double value = 0.0;
          if (border.kind == BorderKind::inflow)
            value = border.profile ? border.profile(grid.face_centre(d, i, j, k)) : border.velocity(d);
          if (!std::isfinite(value))
            throw ArgumentError(
                fmt::format("the profile of the inflow at {} is {} at ({}, {}, {}), expected a number",
                            border_name(side), value, grid.face_centre(d, i, j, k).x(),
                            grid.face_centre(d, i, j, k).y(), grid.face_centre(d, i, j, k).z()));
          velocity[at][static_cast<std::size_t>(grid.at(i, j, k))] = value;
        }
      }
    }
  }
}

void fill_margins(const MacGrid& grid, const Borders& borders, FaceField& velocity) {
  for (int j = 0; j < grid.dimensions; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const Index s = grid.stride[at], n = grid.cells[at];
    for (int d = 0; d < grid.dimensions; ++d) {
      Field& u = velocity[static_cast<std::size_t>(d)];
      if (borders.periodic(j)) {
        wrap(grid, j, u);
        continue;
      }
      for_layer(grid, j, [&](Index c) {
        if (d == j) {
          continue_normal(u, c, s, borders.low(j));
          continue_normal(u, c + n * s, -s, borders.high(j));
        } else {
          continue_tangential(u, c, s, borders.low(j).velocity(d), borders.low(j));
          continue_tangential(u, c + (n - 1) * s, -s, borders.high(j).velocity(d), borders.high(j));
        }
      });
    }
  }
}

void fill_margins(const MacGrid& grid, const Borders& borders, Field& scalar,
                  const std::array<double, 6>& given, bool on_border) {
  for (int j = 0; j < grid.dimensions; ++j) {
    const auto at = static_cast<std::size_t>(j);
    const Index s = grid.stride[at], n = grid.cells[at];
    if (borders.periodic(j)) {
      wrap(grid, j, scalar);
      continue;
    }
    const double low = given[2 * at], high = given[2 * at + 1];
    for_layer(grid, j, [&](Index c) {
      double* const row = scalar.data() + c;
      for (Index m = 1; m <= MacGrid::kMargin; ++m) {
        const auto beyond = [&](double value, double inside, double nearest) {
          if (value < 0.0) return nearest;
          return on_border ? 2.0 * value - inside : value;
        };
        row[-m * s] = beyond(low, row[(m - 1) * s], row[0]);
        row[(n - 1 + m) * s] = beyond(high, row[(n - m) * s], row[(n - 1) * s]);
      }
    });
  }
}

}  // namespace samara::flow
