#include "samara/models/positive.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::models {

void require_positive(double value, std::string_view what, std::string_view where) {
  if (std::isfinite(value) && value > 0.0) return;
  throw ArgumentError(fmt::format("{}: {} is {}; a positive number is needed", where, what, value));
}

}  // namespace samara::models
