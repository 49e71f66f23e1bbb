#include "samara/identification/pages/base64.h"

#include <bit>
#include <cstdint>

namespace samara::identification {

std::string base64(std::span<const double> values) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((8 * values.size() + 2) / 3 * 4);
  std::uint32_t bits = 0;  // of up to three bytes
  int count = 0;
  const auto write = [&] {
    bits <<= 8 * (3 - count);
    for (int k = 0; k < 4; ++k) text += k <= count ? kDigits[(bits >> (18 - 6 * k)) & 63U] : '=';
    bits = 0;
    count = 0;
  };
  for (const double value : values) {
    const auto word = std::bit_cast<std::uint64_t>(value);
    for (int k = 0; k < 8; ++k) {
      bits = (bits << 8) | static_cast<std::uint32_t>((word >> (8 * k)) & 255U);
      if (++count == 3) write();
    }
  }
  if (count > 0) write();
  return text;
}

}  // namespace samara::identification
