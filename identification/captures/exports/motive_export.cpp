#include "samara/identification/captures/exports/motive_export.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/captures/exports/export_lines.h"

namespace samara::identification {

namespace {

using Cells = std::vector<std::string>;

constexpr char kComma = ',';

std::map<std::string, std::string> preamble_of(const std::string& line) {
  const Cells cells = cells_of(line, kComma);
  std::map<std::string, std::string> values;
  for (std::size_t k = 0; k + 1 < cells.size(); k += 2) values[cells[k]] = cells[k + 1];
  return values;
}

bool is_header(const Cells& cells) {
  return cells.size() > 2 && cells[0] == "Frame" && cells[1].starts_with("Time");
}

/// The rows between the preamble and the header: what each column belongs to. Rows may begin with the name of
/// what they say ("Type"), and there may be rows for IDs and parents between.
struct ColumnRows {
  Cells kind;       ///< "Rigid Body", "Rigid Body Marker", "Marker", "Bone"
  Cells name;       ///< of the body
  Cells component;  ///< "Rotation", "Position"
};

ColumnRows column_rows(const std::vector<std::string>& lines, std::size_t header, const std::string& file) {
  std::vector<Cells> rows;
  for (std::size_t k = 1; k < header; ++k) {
    Cells cells = cells_of(lines[k], kComma);
    if (!std::ranges::all_of(cells, &std::string::empty)) rows.push_back(std::move(cells));
  }
  if (rows.size() < 3) {
    throw InputError(file, static_cast<int>(header) + 1,
                     fmt::format("{} rows stand above the header of a Motive export; at least 3 (kind, name, "
                                 "component) were expected",
                                 rows.size()));
  }
  const std::size_t columns = cells_of(lines[header], kComma).size();
  ColumnRows result{rows.front(), rows[1], rows.back()};
  for (Cells* row : {&result.kind, &result.name, &result.component}) row->resize(columns);
  return result;
}

Unit length_unit(const std::map<std::string, std::string>& preamble, const ExportHints& hints) {
  if (hints.length_unit) return parse_unit(*hints.length_unit);
  const std::map<std::string, std::string> symbols = {
      {"Meters", "m"}, {"Centimeters", "cm"}, {"Millimeters", "mm"}, {"m", "m"}, {"cm", "cm"}, {"mm", "mm"}};
  for (const std::string key : {"Length Units", "Export Units", "Units"}) {
    const auto entry = preamble.find(key);
    if (entry == preamble.end()) continue;
    const auto symbol = symbols.find(entry->second);
    if (symbol != symbols.end()) return parse_unit(symbol->second);
    throw InputError(hints.file, 1,
                     fmt::format("lengths are in \"{}\"; Meters, Centimeters or Millimeters were expected",
                                 entry->second));
  }
  throw InputError(hints.file, 1,
                   "a Motive export without \"Length Units\"; a sidecar with length_unit was expected");
}

/// Names that say which column it is, as a sidecar would name them.
Cells header_names(const ColumnRows& rows, const Cells& header) {
  Cells names;
  for (std::size_t k = 0; k < header.size(); ++k) {
    names.push_back(rows.name[k].empty() || k < 2
                        ? header[k]
                        : fmt::format("{}.{}.{}", rows.name[k], rows.component[k], header[k]));
    if (names.back().empty()) names.back() = fmt::format("column {}", k + 1);
  }
  return made_unique(names);
}

std::string quantity_of(const std::string& component, std::string axis) {
  std::ranges::transform(axis, axis.begin(), [](char c) { return static_cast<char>(std::tolower(c)); });
  if (axis.size() != 1 || std::string("xyzw").find(axis) == std::string::npos) return "";
  if (component == "Rotation") return "q" + axis;
  return component == "Position" && axis != "w" ? axis : "";
}

/// Bodies of a kind, in the order in which they appear.
std::vector<ExportedBody> bodies_of(const std::string& kind, const ColumnRows& rows, const Cells& header,
                                    const Cells& names, const Unit& length) {
  std::vector<ExportedBody> bodies;
  const Unit one = parse_unit("1");
  for (std::size_t k = 2; k < header.size(); ++k) {
    const std::string quantity = quantity_of(rows.component[k], header[k]);
    if (rows.kind[k] != kind || quantity.empty()) continue;
    // The columns of a body stand together; one name may stand for several bodies.
    const bool goes_on = !bodies.empty() && bodies.back().name == rows.name[k] &&
                         std::ranges::count(bodies.back().columns, quantity, &ColumnMeaning::quantity) == 0;
    if (!goes_on) bodies.push_back({rows.name[k], {{names[1], kTimeQuantity, parse_unit("s")}}});
    bodies.back().columns.push_back({names[k], quantity, rows.component[k] == "Rotation" ? one : length});
  }
  return bodies;
}

}  // namespace

bool is_motive_export(const std::vector<std::string>& lines) {
  return !lines.empty() && lines[0].starts_with("Format Version");
}

Export read_motive_export(const std::vector<std::string>& lines, const ExportHints& hints) {
  const std::string file = hints.file;
  const auto preamble = preamble_of(lines[0]);
  const auto at =
      std::ranges::find_if(lines, [](const std::string& line) { return is_header(cells_of(line, kComma)); });
  if (at == lines.end())
    throw InputError(file, "a Motive export without its header \"Frame,Time (Seconds),...\"");
  const auto header_line = static_cast<std::size_t>(at - lines.begin());
  const ColumnRows rows = column_rows(lines, header_line, file);
  const auto rotation = preamble.find("Rotation Type");
  const bool has_rotation = std::ranges::count(rows.component, "Rotation") > 0;
  if (has_rotation && rotation != preamble.end() && rotation->second != "Quaternion") {
    throw InputError(
        file, 1,
        fmt::format("rotations are of the type \"{}\"; export them as Quaternion", rotation->second));
  }
  const Cells header = cells_of(*at, kComma);
  const Cells names = header_names(rows, header);
  std::vector<std::string> rewritten = lines;
  rewritten[header_line] = joined(names, names.size(), kComma);
  int rows_read = 0;
  int short_rows = 0;
  for (std::size_t k = header_line + 1; k < lines.size(); ++k) {
    if (lines[k].empty()) continue;
    const Cells cells = cells_of(lines[k], kComma);
    rewritten[k] = joined(cells, names.size(), kComma);
    ++rows_read;
    if (cells.size() < names.size()) ++short_rows;
  }
  Export result{io::DelimitedTable::parse(table_text(rewritten, header_line), file, {.delimiter = kComma}),
                {},
                "Motive",
                "y",
                rows_read,
                short_rows};
  const Unit length = length_unit(preamble, hints);
  for (const std::string kind : {"Rigid Body", "Bone", "Marker"}) {
    result.bodies = bodies_of(kind, rows, header, names, length);
    if (!result.bodies.empty()) return result;
  }
  throw InputError(file, static_cast<int>(header_line) + 1,
                   "no rigid body, bone or marker has positions in this Motive export");
}

}  // namespace samara::identification
