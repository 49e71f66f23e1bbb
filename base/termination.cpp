#include "samara/base/termination.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace samara {

namespace {

constexpr std::array<std::string_view, 19> kTerminationNames = {
    "converged",      "missed",         "not_resolved", "ceases",      "no_contraction",
    "diverged",       "max_iterations", "rank_limit",   "exhausted",   "stagnated",
    "noise",          "refuted",        "not_finite",   "sign_change", "failed",
    "not_determined", "max_calls",      "max_seconds",  "cancelled"};
static_assert(kTerminationNames.size() == static_cast<std::size_t>(Termination::cancelled) + 1);

}  // namespace

std::string to_string(Termination termination) {
  return std::string(kTerminationNames[static_cast<std::size_t>(termination)]);
}

std::optional<Termination> termination_of(std::string_view name) {
  const auto found = std::find(kTerminationNames.begin(), kTerminationNames.end(), name);
  if (found == kTerminationNames.end()) return std::nullopt;
  return static_cast<Termination>(found - kTerminationNames.begin());
}

}  // namespace samara
