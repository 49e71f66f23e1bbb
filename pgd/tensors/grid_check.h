#pragma once

#include <vector>

/// Checks shared by the algebra of sums and of trains.
namespace samara::pgd {

/// @throws ArgumentError `what` of tensors of `a` and `b` nodes if these differ.
void require_same_sizes(const char* what, const std::vector<int>& a, const std::vector<int>& b);
/// @throws ArgumentError if `mode` is none of 0 .. modes - 1.
void require_mode(int mode, int modes);
/// @throws ArgumentError if the mode of `size` nodes has no node `index`.
void require_index(int index, int mode, int size);
/// @throws ArgumentError if something for `count` nodes is to act on a mode of `size` nodes.
void require_length(const char* what, long count, int mode, int size);

}  // namespace samara::pgd
