#include "samara/identification/captures/exports/tracker_export.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/identification/captures/exports/export_lines.h"

namespace samara::identification {

namespace {

using TrackerCells = std::vector<std::string>;

char delimiter_of(std::string_view header) {
  for (const char candidate : {'\t', ';', ','}) {
    if (header.find(candidate) != std::string_view::npos) return candidate;
  }
  return '\t';
}

bool is_multi(const std::vector<std::string>& lines) {
  return lines[0].size() < 16 && lines[0].find("multi:") != std::string::npos;
}

/// "v_{x}" and "θ_{r}" are what newer versions call vx and θr.
std::string plain_name(std::string name) {
  std::erase_if(name, [](char c) { return c == '_' || c == '{' || c == '}'; });
  return name;
}

/// What Tracker measures, by its names, with exponents of length and time.
struct TrackerQuantity {
  std::string name;
  std::string quantity;
  int length;
  int time;
};

const std::vector<TrackerQuantity>& tracker_quantities() {
  static const std::vector<TrackerQuantity> all = {
      {"t", "t", 0, 1},    {"x", "x", 1, 0},    {"y", "y", 1, 0},  {"r", "r", 1, 0},
      {"vx", "vx", 1, -1}, {"vy", "vy", 1, -1}, {"v", "v", 1, -1},
  };
  return all;
}

std::string unit_text(const TrackerQuantity& quantity, const std::string& length) {
  if (quantity.length == 0) return "s";
  return quantity.time == 0 ? length : fmt::format("({})/s", length);
}

/// The columns of one mass: from `first` on, up to `end`; time is shared.
ExportedBody body_of(const TrackerCells& names, const TrackerCells& header, const std::string& mass,
                     std::size_t first, std::size_t end, const std::string& length) {
  ExportedBody body{mass, {}};
  const auto add = [&](std::size_t column) {
    for (const TrackerQuantity& known : tracker_quantities()) {
      if (plain_name(names[column]) == known.name)
        body.columns.push_back({header[column], known.quantity, parse_unit(unit_text(known, length))});
    }
  };
  for (std::size_t column = 0; column < end; ++column) {
    if (column >= first || plain_name(names[column]) == "t") add(column);
  }
  return body;
}

/// The line of the header; none if this is no export of Tracker.
std::optional<std::size_t> header_line(const std::vector<std::string>& lines) {
  if (lines.empty()) return std::nullopt;
  const std::size_t at = is_multi(lines) ? 2 : 1;
  if (lines.size() <= at) return std::nullopt;
  const char delimiter = delimiter_of(lines[at]);
  const TrackerCells names = cells_of(lines[at], delimiter);
  if (names.size() < 2 || names[0] != "t") return std::nullopt;
  // Above the header of a single mass stands its name alone; a table's own header would fill its line.
  const TrackerCells above = cells_of(lines[at - 1], delimiter);
  const bool is_name = std::ranges::count_if(above, [](const std::string& c) { return !c.empty(); }) == 1 &&
                       !above[0].empty() && !above[0].starts_with('#');
  return is_multi(lines) || is_name ? std::optional(at) : std::nullopt;
}

}  // namespace

bool is_tracker_export(const std::vector<std::string>& lines) {
  return header_line(lines).has_value();
}

Export read_tracker_export(const std::vector<std::string>& lines, const ExportHints& hints) {
  const std::size_t at = header_line(lines).value();
  const char delimiter = delimiter_of(lines[at]);
  TrackerCells names = cells_of(lines[at], delimiter);
  while (names.back().empty()) names.pop_back();
  TrackerCells above = cells_of(lines[at - 1], delimiter);

  const std::string file = hints.file;
  if (!hints.length_unit && !hints.has_columns) {
    throw InputError(file, static_cast<int>(at) + 1,
                     "a Tracker export names no units; a sidecar with length_unit = \"m\" (or another) was "
                     "expected");
  }
  const std::string length = hints.length_unit.value_or("m");
  const TrackerCells header = made_unique(names);
  std::vector<std::string> rewritten = lines;
  rewritten[at] = joined(header, header.size(), delimiter);
  int rows = 0;
  int short_rows = 0;
  for (std::size_t k = at + 1; k < lines.size(); ++k) {
    TrackerCells cells = cells_of(lines[k], delimiter);
    if (std::ranges::all_of(cells, &std::string::empty)) {
      rewritten[k].clear();
      continue;
    }
    for (std::string& cell : cells) {
      if (has_decimal_comma(cell)) std::ranges::replace(cell, ',', '.');
    }
    rewritten[k] = joined(cells, header.size(), delimiter);
    ++rows;
    if (cells.size() < header.size()) ++short_rows;
  }
  Export result{io::DelimitedTable::parse(table_text(rewritten, at), file, {.delimiter = delimiter}),
                {},
                "Tracker",
                "",
                rows,
                short_rows};
  above.resize(header.size() + 1);
  if (!is_multi(lines)) {
    result.bodies.push_back(body_of(names, header, above[0], 0, header.size(), length));
    return result;
  }
  for (std::size_t first = 0; first < header.size(); ++first) {
    if (above[first].empty()) continue;
    std::size_t end = first + 1;
    while (end < header.size() && above[end].empty()) ++end;
    result.bodies.push_back(body_of(names, header, above[first], first, end, length));
  }
  if (result.bodies.empty())
    throw InputError(file, 2, "names of masses were expected below the line \"multi:\"");
  return result;
}

}  // namespace samara::identification
