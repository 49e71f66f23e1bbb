#include "samara/base/positive.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"

namespace samara {

namespace {

[[noreturn]] void refuse(double value, std::string_view what, std::string_view where, const char* expected) {
  throw ArgumentError(fmt::format("{}{}{} is {}; {} was expected", where, where.empty() ? "" : ": ", what,
                                  number_text(value), expected));
}

}  // namespace

void require_positive(double value, std::string_view what, std::string_view where) {
  if (!(std::isfinite(value) && value > 0.0)) refuse(value, what, where, "a positive finite number");
}

void require_not_negative(double value, std::string_view what, std::string_view where) {
  if (!(std::isfinite(value) && value >= 0.0)) refuse(value, what, where, "a positive finite number or 0");
}

}  // namespace samara
