#pragma once

#include <array>
#include <cstdint>
#include <span>

/// Standard normals by counter, of the generator of streams.h.
namespace samara {

/// An address of random numbers: any may be asked for at any time, in any order. Stream 0 has the blocks of
/// Stream(seed, realisation): leave it to that where both are used.
struct RandomPlace {
  std::uint64_t realisation = 0;
  std::uint64_t step = 0;    ///< less than 2^48
  std::uint16_t stream = 0;  ///< of several for one step
};

/// Four independent standard normals, of 32 bits each: at most 6.7 in size.
std::array<double, 4> normals_at(std::uint64_t seed, const RandomPlace& place);

/// The same of this step and those that follow, as many as there is room for: many at once cost a fraction.
void normals_from(std::uint64_t seed, const RandomPlace& first, std::span<std::array<double, 4>> steps);

}  // namespace samara
