#pragma once

#include <bit>
#include <cstdint>

/// Sets of small numbers, as the bits of a word.
namespace samara {

/// what(k) for each bit k that is set, the lowest first.
template <class What>
void for_bits(std::uint64_t bits, const What& what) {
  for (; bits != 0; bits &= bits - 1) what(std::countr_zero(bits));
}

/// Whether bit k, 0 to 63, is set.
inline bool has_bit(std::uint64_t bits, int k) {
  return (bits >> k & 1) != 0;
}

}  // namespace samara
