#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "samara/base/streams.h"

/// Texts that differ from a sound one in a few places, as damaged files do.
class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : stream_(1, seed) {}

  /// One to three changes: cut off, a bit, a word or a cell by another, bytes or lines left out, doubled or exchanged.
  std::string operator()(std::string text);

  std::size_t below(std::size_t count) {
    return count == 0 ? 0 : static_cast<std::size_t>(stream_.bits() % count);
  }

 private:
  std::string once(std::string text);

  samara::Stream stream_;
};
