#pragma once

#include <string>

#include "samara/base/units.h"

namespace samara::identification {

/// The name of the time column's quantity.
inline constexpr const char* kTimeQuantity = "t";

/// A column that holds a measured quantity, or time ("t").
struct ColumnMeaning {
  std::string column;
  std::string quantity;
  Unit unit;
};

}  // namespace samara::identification
