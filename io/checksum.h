#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace samara::io {

/// FNV-1a (Fowler, Noll and Vo, 1991) over bytes; not for secrets. Of numbers it depends on the byte order of the
/// machine.
/// @param hash of the bytes before
inline std::uint64_t fnv1a(std::span<const std::byte> bytes, std::uint64_t hash = 0xcbf29ce484222325) {
  for (const std::byte byte : bytes) hash = (hash ^ std::to_integer<std::uint64_t>(byte)) * 0x100000001b3;
  return hash;
}

inline std::uint64_t fnv1a(std::string_view text) {
  return fnv1a(std::as_bytes(std::span(text)));
}

}  // namespace samara::io
