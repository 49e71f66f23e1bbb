#include "samara/base/number_text.h"

#include <array>
#include <charconv>

namespace samara {

namespace {
constexpr std::size_t kLongest = 32;  // sign, 17 digits, point, exponent
}

std::string number_text(double value) {
  std::array<char, kLongest> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  return std::string(buffer.data(), result.ptr);
}

std::string number_text(double value, int digits) {
  std::array<char, kLongest> buffer;
  const auto result =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits);
  return std::string(buffer.data(), result.ptr);
}

}  // namespace samara
