#include "samara/identification/captures/exports/export_lines.h"

#include <algorithm>
#include <cctype>

#include "samara/base/text.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

/// As RFC 4180 wants it; an empty cell stays empty.
std::string protected_cell(const std::string& cell) {
  if (cell.empty()) return cell;
  std::string result = "\"";
  for (const char c : cell) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + '"';
}

}  // namespace

std::vector<std::string> lines_of(std::string_view text) {
  std::vector<std::string> lines;
  if (text.starts_with(io::kByteOrderMark)) text.remove_prefix(io::kByteOrderMark.size());
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    std::string_view line = text.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    lines.emplace_back(line);
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return lines;
}

std::vector<std::string> cells_of(std::string_view line, char delimiter) {
  std::vector<std::string> cells;
  std::string cell;
  bool inside_quotes = false;
  for (const char c : line) {
    if (c == '"') {
      inside_quotes = !inside_quotes;
    } else if (c == delimiter && !inside_quotes) {
      cells.emplace_back(trimmed(cell));
      cell.clear();
    } else {
      cell += c;
    }
  }
  cells.emplace_back(trimmed(cell));
  return cells;
}

std::string joined(std::vector<std::string> cells, std::size_t columns, char delimiter) {
  while (cells.size() > columns && cells.back().empty()) cells.pop_back();
  if (cells.size() < columns) cells.resize(columns);
  std::string line;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (k > 0) line += delimiter;
    line += protected_cell(cells[k]);
  }
  return line;
}

bool has_decimal_comma(const std::string& cell) {
  return std::ranges::count(cell, ',') == 1 && std::ranges::all_of(cell, [](char c) {
           return std::isdigit(static_cast<unsigned char>(c)) != 0 ||
                  std::string_view(",+-eE").find(c) != std::string_view::npos;
         });
}

std::vector<std::string> made_unique(std::vector<std::string> names) {
  std::vector<std::string> unique;
  for (const std::string& name : names) {
    std::string candidate = name;
    for (int k = 2; std::ranges::count(unique, candidate) > 0; ++k) {
      candidate = name;
      candidate += " (";
      candidate += std::to_string(k);
      candidate += ')';
    }
    unique.push_back(candidate);
  }
  return unique;
}

std::string table_text(const std::vector<std::string>& lines, std::size_t header) {
  std::string text;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    text += k < header ? std::string("#") : lines[k];
    text += '\n';
  }
  return text;
}

}  // namespace samara::identification
