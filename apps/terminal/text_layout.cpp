#include "terminal/text_layout.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
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

/// Bytes that go on with a character of UTF-8 do not.
bool begins_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;
}

/// As it is shown: bytes that go on with a character of UTF-8 take no column.
std::size_t columns_of(std::string_view text) {
  return static_cast<std::size_t>(std::ranges::count_if(text, begins_character));
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

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

bool is_row(const std::string& line) {
  return line.find("  ", std::min(line.find_first_not_of(' '), line.size())) != std::string::npos;
}

std::string wrapped_line(const std::string& line, std::size_t width) {
  if (columns_of(line) <= width) return line;
  const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
  return line.substr(0, indent) + wrapped(line.substr(indent), indent + 4, width, indent);
}

/// Of a line as it is shown: the bytes from one column to another, where there are so many.
std::string between(const std::string& line, std::size_t from, std::size_t to) {
  std::string part;
  std::size_t columns = 0;  // that have begun
  for (const char byte : line) {
    if (begins_character(byte)) ++columns;
    if (columns > from && columns <= to) part += byte;
  }
  return part;
}

/// Where cells end that stand one below the other: two blanks or more follow in every row.
std::vector<std::size_t> ends_of_cells(std::span<const std::string> rows, std::size_t longest) {
  std::string filled(longest, ' ');
  for (const std::string& row : rows) {
    std::size_t columns = 0;
    for (const char byte : row) {
      if (begins_character(byte)) ++columns;
      if (byte != ' ') filled[columns - 1] = 'x';
    }
  }
  std::vector<std::size_t> ends;
  for (std::size_t at = filled.find("x  "); at != std::string::npos; at = filled.find("x  ", at + 1))
    ends.push_back(at + 1);
  ends.push_back(longest);
  return ends;
}

/// How many of the first columns tell rows apart.
std::size_t telling_columns(std::span<const std::string> rows, const std::vector<std::size_t>& ends) {
  for (std::size_t count = 1; count < ends.size(); ++count) {
    std::set<std::string> heads;
    for (const std::string& row : rows) heads.insert(between(row, 0, ends[count - 1]));
    if (heads.size() == rows.size()) return count;
  }
  return 1;
}

/// A table that is too wide as several, one below the other, each with the first columns.
std::vector<std::string> parted_table(std::span<const std::string> rows, std::size_t width) {
  std::size_t longest = 0;
  for (const std::string& row : rows) longest = std::max(longest, columns_of(row));
  const std::vector<std::size_t> ends = ends_of_cells(rows, longest);
  if (rows.size() < 2 || longest <= width) return {rows.begin(), rows.end()};
  std::vector<std::string> lines;
  const std::size_t count = telling_columns(rows, ends), head = ends[count - 1];
  for (std::size_t first = count - 1; first + 1 < ends.size();) {
    std::size_t last = first + 1;
    while (last + 1 < ends.size() && head + ends[last + 1] - ends[first] <= width) ++last;
    for (const std::string& row : rows) {
      std::string line = between(row, 0, head);
      line.append(head - columns_of(line), ' ');
      line += between(row, ends[first], ends[last]);
      lines.push_back(line.substr(0, line.find_last_not_of(' ') + 1));
    }
    first = last;
  }
  return lines.empty() ? std::vector<std::string>(rows.begin(), rows.end()) : lines;
}

}  // namespace

std::string wrapped_lines(const std::string& text, std::size_t width) {
  std::vector<std::string> lines = lines_of(text);
  for (std::string& line : lines) line = wrapped_line(line, width);
  return fmt::format("{}{}", fmt::join(lines, "\n"), text.ends_with('\n') ? "\n" : "");
}

std::string wrapped_prose(const std::string& text, std::size_t width) {
  const std::vector<std::string> lines = lines_of(text);
  std::vector<std::string> result;
  for (std::size_t k = 0; k < lines.size();) {
    std::size_t end = k;
    while (end < lines.size() && is_row(lines[end])) ++end;
    if (end == k) {
      result.push_back(wrapped_line(lines[k++], width));
      continue;
    }
    for (std::string& line : parted_table(std::span(lines).subspan(k, end - k), width))
      result.push_back(std::move(line));
    k = end;
  }
  return fmt::format("{}{}", fmt::join(result, "\n"), text.ends_with('\n') ? "\n" : "");
}

}  // namespace samara::apps
