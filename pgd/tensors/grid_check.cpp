#include "samara/pgd/tensors/grid_check.h"

#include <fmt/format.h>

#include "samara/base/errors.h"

namespace samara::pgd {

void require_same_sizes(const char* what, const std::vector<int>& a, const std::vector<int>& b) {
  if (a == b) return;
  throw ArgumentError(fmt::format("{} of tensors of {} and {} nodes, expected the same grid", what,
                                  fmt::join(a, " x "), fmt::join(b, " x ")));
}

void require_mode(int mode, int modes) {
  if (mode >= 0 && mode < modes) return;
  throw ArgumentError(
      fmt::format("mode {} of a tensor of {} modes, expected 0 to {}", mode, modes, modes - 1));
}

void require_index(int index, int mode, int size) {
  if (index >= 0 && index < size) return;
  throw ArgumentError(fmt::format("index {} of mode {}, expected 0 to {}", index, mode, size - 1));
}

void require_length(const char* what, long count, int mode, int size) {
  if (count == size) return;
  throw ArgumentError(fmt::format("{} for {} nodes, but mode {} has {}", what, count, mode, size));
}

}  // namespace samara::pgd
