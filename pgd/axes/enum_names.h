#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

/// Names of enumerators in files; internal to pgd/.
namespace samara::pgd {

/// The enumerator whose number is the place of `name` in `names`.
/// @param what such names stand for, for the message
/// @throws ArgumentError for an unknown name.
template <typename Enum, std::size_t N>
Enum from_name(const char* what, const std::string& name, const std::array<const char*, N>& names) {
  const auto it = std::find(names.begin(), names.end(), name);
  if (it == names.end()) {
    const std::vector<std::string> known(names.begin(), names.end());
    throw ArgumentError(fmt::format("{} is \"{}\"{}", what, name, suggestion(name, known)));
  }
  return static_cast<Enum>(it - names.begin());
}

}  // namespace samara::pgd
