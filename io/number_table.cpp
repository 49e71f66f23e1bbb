#include "samara/io/number_table.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "samara/base/parallel.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"

namespace samara::io {

namespace {

using Eigen::Index;

/// The offset after the header: the first line that is neither blank nor a comment, which, as in DelimitedTable, begins
/// with its sign.
std::size_t behind_header(std::string_view text) {
  for (std::size_t begin = text.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
       begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::string_view line = text.substr(begin, end - begin);
    if (line.ends_with('\r')) line.remove_suffix(1);
    begin = std::min(end + 1, text.size());
    if (!line.starts_with('#') && !trimmed(line).empty()) return begin;
  }
  return text.size();
}

/// Whole lines of the text, about as many bytes in each part.
std::vector<std::string_view> parts_of(std::string_view text) {
  constexpr std::size_t kBytes = std::size_t{1} << 18;
  std::vector<std::string_view> parts;
  while (!text.empty()) {
    const std::size_t end = text.size() <= kBytes ? std::string_view::npos : text.find('\n', kBytes);
    const std::size_t size = end == std::string_view::npos ? text.size() : end + 1;
    parts.push_back(text.substr(0, size));
    text.remove_prefix(size);
  }
  return parts;
}

void skip_blanks(const char*& at, const char* end) {
  while (at < end && (*at == ' ' || *at == '\t')) ++at;
}

/// Numbers of rows, and where each row begins in the text.
struct Part {
  std::vector<double> numbers;
  std::vector<std::size_t> begins;
};

/// Rows of plain finite numbers, row by row. @returns whether that is all there is
bool read_part(std::string_view text, Index columns, char delimiter, Part& part) {
  const char* at = text.data();
  const char* const end = at + text.size();
  const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n')) + 1;
  // A number takes a digit and what parts it from the next, whatever the header promises.
  part.numbers.reserve(std::min(lines * static_cast<std::size_t>(columns), text.size() / 2 + 1));
  part.begins.reserve(std::min(lines, text.size() / static_cast<std::size_t>(2 * columns) + 1));
  while (at < end) {
    part.begins.push_back(static_cast<std::size_t>(at - text.data()));
    for (Index column = 0; column < columns; ++column) {
      if (delimiter != '\t') skip_blanks(at, end);
      if (at < end && *at == '+' && ++at < end && *at == '-') return false;
      double value = 0.0;
      const auto [rest, problem] = std::from_chars(at, end, value);
      if (problem != std::errc() || !std::isfinite(value)) return false;
      at = rest;
      if (delimiter != '\t') skip_blanks(at, end);
      if (column + 1 < columns && (at == end || *at++ != delimiter)) return false;
      part.numbers.push_back(value);
    }
    if (at < end && *at == '\r') ++at;
    if (at < end && *at++ != '\n') return false;
  }
  return true;
}

}  // namespace

/// @returns false for tables that have anything but rows of numbers, which the other reader takes, or refuses
bool NumberTable::read_plain_rows(std::size_t begin) {
  const std::vector<std::string_view> parts = parts_of(std::string_view(text_).substr(begin));
  const Index columns = std::ssize(header_);
  std::vector<Part> read(parts.size());
  std::vector<char> is_plain(parts.size(), 0);
  parallel_for(parts.size(),
               [&](std::size_t k) { is_plain[k] = read_part(parts[k], columns, delimiter_, read[k]); });
  if (std::ranges::count(is_plain, 0) > 0) return false;
  std::vector<Index> first(parts.size() + 1, 0);  // row of each part
  for (std::size_t k = 0; k < parts.size(); ++k) first[k + 1] = first[k] + std::ssize(read[k].begins);
  values_.resize(first.back(), columns);
  row_begins_.resize(static_cast<std::size_t>(first.back()));
  parallel_for(parts.size(), [&](std::size_t k) {
    std::ranges::copy(read[k].numbers, values_.data() + first[k] * columns);
    const auto offset = static_cast<std::size_t>(parts[k].data() - text_.data());
    std::ranges::transform(read[k].begins, row_begins_.begin() + first[k],
                           [&](std::size_t at) { return offset + at; });
  });
  return true;
}

DelimitedTable NumberTable::head(std::string_view text, const std::string& name) {
  return DelimitedTable::parse(text.substr(0, behind_header(text)), name);
}

NumberTable NumberTable::parse(std::string text, const std::string& name) {
  NumberTable table;
  table.text_ = std::move(text);
  table.name_ = name;
  const DelimitedTable first = head(table.text_, name);
  table.header_ = first.header();
  table.delimiter_ = first.delimiter();
  if (table.read_plain_rows(behind_header(table.text_))) return table;
  const DelimitedTable whole = DelimitedTable::parse(table.text_, name);
  table.header_ = whole.header();
  table.values_.resize(static_cast<Index>(whole.rows()), std::ssize(table.header_));
  for (Index column = 0; column < table.values_.cols(); ++column)
    table.values_.col(column) = whole.numbers(table.header_[static_cast<std::size_t>(column)]);
  return table;
}

void NumberTable::read_cells(Index row, std::span<std::string_view> cells) const {
  const char* at = text_.data() + row_begins_[static_cast<std::size_t>(row)];
  const char* const end = text_.data() + text_.size();
  const auto ends_number = [&](char c) {
    return c == delimiter_ || c == ' ' || c == '\t' || c == '\r' || c == '\n';
  };
  for (std::string_view& cell : cells) {
    while (at < end && (*at == ' ' || *at == '\t' || *at == '+' || *at == delimiter_)) ++at;
    const char* const begin = at;
    while (at < end && !ends_number(*at)) ++at;
    cell = {begin, static_cast<std::size_t>(at - begin)};
  }
}

NumberTable NumberTable::read(const std::filesystem::path& path) {
  return parse(read_text_file(path, {.expected = "a table"}), path.string());
}

InputError NumberTable::error(Eigen::Index row, const std::string& sentence) const {
  return DelimitedTable::parse(text_, name_).error(static_cast<std::size_t>(row), sentence);
}

}  // namespace samara::io
