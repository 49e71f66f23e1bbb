#include "samara/codebooks/book/argument_checks.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"

namespace samara::codebooks {

void require_inside(std::span<const Coordinate> coordinates, std::span<const double> x) {
  if (x.size() != coordinates.size()) {
    throw ArgumentError(
        fmt::format("the point has {} coordinates, expected {}", x.size(), coordinates.size()));
  }
  for (std::size_t k = 0; k < x.size(); ++k) {
    const Coordinate& c = coordinates[k];
    if (!std::isfinite(x[k])) {
      throw ArgumentError(fmt::format("{} is {}, expected a finite number", c.name, x[k]));
    }
    if (x[k] < c.lower || x[k] > c.upper) {
      throw OutsideBoxError(fmt::format("{} = {}{} is outside the codebook's box [{}, {}]", c.name, x[k],
                                        unit_suffix(c.unit), c.lower, c.upper));
    }
  }
}

void require_size(const char* what, Size found, Size expected) {
  if (found == expected) return;
  throw ArgumentError(
      fmt::format("the {} given for the answer have {} rows and {} columns, expected {} and {}", what,
                  found.rows, found.columns, expected.rows, expected.columns));
}

}  // namespace samara::codebooks
