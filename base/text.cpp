#include "samara/base/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

namespace samara {

NumberPrefix read_number(std::string_view text) {
  NumberPrefix number;
  const std::size_t sign = !text.empty() && text.front() == '+' ? 1 : 0;
  // std::from_chars takes no plus sign; "+-1" must not pass either.
  const std::string_view digits = text.substr(sign);
  if (sign == 1 && !digits.empty() && digits.front() == '-') return {.problem = NumberProblem::malformed};
  const auto [end, code] = std::from_chars(digits.data(), digits.data() + digits.size(), number.value);
  if (code == std::errc::invalid_argument) return {.problem = NumberProblem::malformed};
  number.length = sign + static_cast<std::size_t>(end - digits.data());
  if (code == std::errc::result_out_of_range) {
    number.problem = NumberProblem::out_of_range;
  } else if (!std::isfinite(number.value)) {
    number.problem = NumberProblem::not_finite;
  }
  return number;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

std::string ending_of(const std::filesystem::path& file) {
  return lower_case(file.extension().string());
}

std::string in_quotes(std::string_view text) {
  constexpr std::size_t kLongestQuote = 60;
  std::size_t shown = std::min(text.size(), kLongestQuote);
  while (shown > 0 && shown < text.size() && (static_cast<unsigned char>(text[shown]) & 0xC0) == 0x80)
    --shown;                                                     // within a character
  if (shown == 0) shown = std::min(text.size(), kLongestQuote);  // no characters: bytes
  std::string quote = "\"";
  for (const char c : text.substr(0, shown)) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x20 && code != 0x7F) {
      quote += c;
    } else {
      constexpr std::string_view kDigits = "0123456789abcdef";
      quote += "\\x";
      quote += kDigits[code / 16];
      quote += kDigits[code % 16];
    }
  }
  return quote.append(shown == text.size() ? "\"" : "...\"");
}

std::string escaped_for_markup(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      case '\t':
      case '\n':
      case '\r':
        result += c;
        break;
      default:
        // No markup may hold other control characters, escaped or not.
        result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return result;
}

}  // namespace samara
