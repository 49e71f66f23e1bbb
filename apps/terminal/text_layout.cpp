#include "terminal/text_layout.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>
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

/// What stands in a line between two blanks or more.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (std::size_t begin = 0; begin < line.size();) {
    const std::size_t end = std::min(line.find("  ", begin), line.size());
    cells.push_back(line.substr(begin, end - begin));
    begin = std::min(line.find_first_not_of(' ', end), line.size());
  }
  return cells;
}

/// Rows of as many cells, one below the other.
class TextTable {
 public:
  explicit TextTable(std::vector<std::vector<std::string>> rows) : rows_(std::move(rows)) {
    widths_.resize(rows_.front().size(), 0);
    for (const auto& row : rows_) {
      for (std::size_t c = 0; c < row.size(); ++c) widths_[c] = std::max(widths_[c], columns_of(row[c]));
    }
  }

  /// As several tables of at most `width`, each with the first columns, as many as tell the rows apart. Empty where
  /// these have no room beside every other.
  std::vector<std::string> parted(std::size_t width) const {
    const std::size_t heads = telling_columns();
    if (heads == widths_.size()) return {};
    const std::size_t widest =
        *std::max_element(widths_.begin() + static_cast<std::ptrdiff_t>(heads), widths_.end());
    if (columns_together(0, heads) + 2 + widest > width) return {};
    std::vector<std::string> lines;
    for (std::size_t first = heads; first < widths_.size();) {
      std::size_t last = first + 1;
      while (last < widths_.size() &&
             columns_together(0, heads) + 2 + columns_together(first, last + 1) <= width)
        ++last;
      for (const auto& row : rows_) lines.push_back(line_of(row, heads, first, last));
      first = last;
    }
    return lines;
  }

 private:
  std::size_t columns_together(std::size_t first, std::size_t last) const {
    std::size_t sum = 2 * (last - first - 1);
    for (std::size_t c = first; c < last; ++c) sum += widths_[c];
    return sum;
  }

  std::size_t telling_columns() const {
    for (std::size_t count = 1; count < widths_.size(); ++count) {
      std::set<std::vector<std::string>> heads;
      for (const auto& row : rows_)
        heads.emplace(row.begin(), row.begin() + static_cast<std::ptrdiff_t>(count));
      if (heads.size() == rows_.size()) return count;
    }
    return widths_.size();
  }

  /// The first columns begin below each other, the others end so, as numbers do.
  std::string line_of(const std::vector<std::string>& row, std::size_t heads, std::size_t first,
                      std::size_t last) const {
    std::string line;
    const auto blanks = [&](std::size_t c) { return std::string(widths_[c] - columns_of(row[c]), ' '); };
    for (std::size_t c = 0; c < heads; ++c) line += (c > 0 ? "  " : "") + row[c] + blanks(c);
    for (std::size_t c = first; c < last; ++c) line += "  " + blanks(c) + row[c];
    return line;
  }

  std::vector<std::vector<std::string>> rows_;
  std::vector<std::size_t> widths_;
};

/// Rows from the first line on, to the next that is none.
std::span<const std::string> rows_from(std::span<const std::string> lines) {
  const auto end = std::ranges::find_if_not(lines, is_row);
  return lines.first(static_cast<std::size_t>(end - lines.begin()));
}

/// Too wide rows in parts, if all have as many cells; else as they are.
std::vector<std::string> fitted_rows(std::span<const std::string> rows, std::size_t width) {
  std::vector<std::vector<std::string>> cells;
  for (const std::string& row : rows) cells.push_back(cells_of(row));
  const bool is_table = rows.size() > 1 && std::ranges::all_of(cells, [&](const auto& row) {
                          return row.size() == cells.front().size();
                        });
  const bool is_wide = std::ranges::any_of(rows, [&](const auto& row) { return columns_of(row) > width; });
  std::vector<std::string> parts;
  if (is_table && is_wide) parts = TextTable(std::move(cells)).parted(width);
  return parts.empty() ? std::vector<std::string>(rows.begin(), rows.end()) : parts;
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
    const std::span<const std::string> rows = rows_from(std::span(lines).subspan(k));
    if (rows.empty()) {
      result.push_back(wrapped_line(lines[k++], width));
      continue;
    }
    k += rows.size();
    std::vector<std::string> parts = fitted_rows(rows, width);
    std::ranges::move(parts, std::back_inserter(result));
  }
  return fmt::format("{}{}", fmt::join(result, "\n"), text.ends_with('\n') ? "\n" : "");
}

}  // namespace samara::apps
