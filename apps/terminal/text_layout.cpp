#include "terminal/text_layout.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <string_view>

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

namespace samara::apps {

namespace {

constexpr std::size_t kLeastWidth = 50, kMostWidth = 160;

std::size_t asked_width() {
  winsize window = {};
  if (isatty(STDOUT_FILENO) != 0 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0)
    return window.ws_col;
  const char* columns = std::getenv("COLUMNS");
  if (columns == nullptr) return kUsualWidth;
  std::size_t width = 0;
  const std::string_view text = columns;
  const auto [rest, problem] = std::from_chars(text.data(), text.data() + text.size(), width);
  return problem == std::errc() && rest == text.data() + text.size() ? width : kUsualWidth;
}

/// As it is shown: bytes that go on with a character of UTF-8 take no column.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

}  // namespace

std::size_t screen_width() {
  return std::clamp(asked_width(), kLeastWidth, kMostWidth);
}

std::string wrapped(const std::string& text, std::size_t indent, std::size_t width, std::size_t column) {
  std::string lines;
  bool is_first = true;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string_view word = std::string_view(text).substr(begin, end - begin);
    const std::size_t size = columns_of(word);
    if (!is_first && column + 1 + size > width) {
      lines.erase(lines.find_last_not_of(' ') + 1);  // what stood between two words, also several blanks
      lines += fmt::format("\n{:{}}", "", indent);
      column = indent;
    } else if (!is_first) {
      lines += ' ';
      ++column;
    }
    lines += word;
    column += size;
    is_first = false;
    begin = end + 1;
  }
  return lines;
}

namespace {

std::string wrapped_where(const std::string& text, std::size_t width, bool are_rows_kept) {
  std::string result;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const bool is_row = line.find("  ", indent) != std::string::npos;
    result += columns_of(line) <= width || (is_row && are_rows_kept)
                  ? line
                  : line.substr(0, indent) + wrapped(line.substr(indent), indent + 4, width, indent);
    if (end < text.size()) result += '\n';
    begin = end + 1;
  }
  return result;
}

}  // namespace

std::string wrapped_lines(const std::string& text, std::size_t width) {
  return wrapped_where(text, width, false);
}

std::string wrapped_prose(const std::string& text, std::size_t width) {
  return wrapped_where(text, width, true);
}

}  // namespace samara::apps
