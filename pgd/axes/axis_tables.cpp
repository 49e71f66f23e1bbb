#include "samara/pgd/axes/axis_tables.h"

#include <array>

#include "samara/pgd/axes/enum_names.h"

namespace samara::pgd {

namespace {
constexpr std::array kRoleNames = {"time", "space", "parameter", "initial", "boundary"};
}  // namespace

std::string to_string(AxisRole role) {
  return kRoleNames.at(static_cast<std::size_t>(role));
}

AxisRole role_from_string(const std::string& name) {
  return from_name<AxisRole>("role", name, kRoleNames);
}

}  // namespace samara::pgd
