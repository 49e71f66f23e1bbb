#include "samara/base/require.h"

#include <cmath>
#include <string>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/number_text.h"

namespace samara {

void require(bool holds, std::string_view field, CheckedNumber value, std::string_view expected,
             std::string_view where) {
  if (holds) return;
  const std::string number = value.is_whole ? std::to_string(value.whole) : number_text(value.value);
  throw ArgumentError(fmt::format("{}{}{} is {}; {} was expected", where, where.empty() ? "" : ": ", field,
                                  number, expected));
}

void require_positive(double value, std::string_view field, std::string_view where) {
  require(std::isfinite(value) && value > 0.0, field, value, "a positive finite number", where);
}

void require_not_negative(double value, std::string_view field, std::string_view where) {
  require(std::isfinite(value) && value >= 0.0, field, value, "a positive finite number or 0", where);
}

}  // namespace samara
