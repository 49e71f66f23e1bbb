#include "samara/motion/sweeps/plan_numbers.h"

#include <cmath>

#include <fmt/format.h>

#include "samara/base/limits.h"

namespace samara::motion {

double in_size(const io::TomlTable& table, const std::string& key, double value) {
  if (std::abs(value) <= kLargestInput) return value;
  throw table.error(key, fmt::format("has the number {}, expected at most {} in size", value, kLargestInput));
}

}  // namespace samara::motion
