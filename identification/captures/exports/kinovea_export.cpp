#include "samara/identification/captures/exports/kinovea_export.h"

#include <algorithm>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "samara/base/text.h"
#include "samara/identification/captures/exports/export_lines.h"

namespace samara::identification {

namespace {

using KinoveaCells = std::vector<std::string>;

constexpr std::string_view kGnuplotTitle = "#Kinovea Trajectory data export";
constexpr char kRewritten = ';';

/// Of "ball/0/X" the point "ball/0"; nothing of other names.
std::optional<std::string> point_of(const std::string& name, std::string_view axis) {
  if (name.size() <= axis.size() || !name.ends_with(axis)) return {};
  return name.substr(0, name.size() - axis.size());
}

/// A point that is its object's only one, "ball/0", goes by the name of the object.
std::string body_name(const std::string& point) {
  return point.size() > 2 && point.ends_with("/0") ? point.substr(0, point.size() - 2) : point;
}

/// The delimiter of "Time","ball/0/X","ball/0/Y", ..; nothing if a line is no such header.
std::optional<char> table_delimiter(const std::string& line) {
  for (const char delimiter : {',', ';'}) {
    const KinoveaCells names = cells_of(line, delimiter);
    if (names.size() < 3 || names.size() % 2 == 0 || names[0] != "Time") continue;
    bool in_pairs = true;
    for (std::size_t k = 1; in_pairs && k < names.size(); k += 2)
      in_pairs = point_of(names[k], "/X") && point_of(names[k], "/X") == point_of(names[k + 1], "/Y");
    if (in_pairs) return delimiter;
  }
  return {};
}

std::string with_point(std::string cell) {
  if (has_decimal_comma(cell)) std::ranges::replace(cell, ',', '.');
  return cell;
}

/// Of "1:02:03:45" or "1:02:03:450", hours, minutes, seconds and their hundredths or, from 100 frames a second on,
/// thousandths, the seconds; nothing of other texts.
std::optional<double> seconds_of(const std::string& timecode) {
  const KinoveaCells texts = cells_of(timecode, ':');
  if (texts.size() != 4 || texts[3].size() < 2 || texts[3].size() > 3) return {};
  const double weights[] = {3600.0, 60.0, 1.0, texts[3].size() == 2 ? 0.01 : 0.001};
  double seconds = 0.0;
  for (std::size_t part = 0; part < 4; ++part) {
    const NumberPrefix number = read_number(texts[part]);
    const bool is_whole = number.problem == NumberProblem::none && number.length == texts[part].size() &&
                          texts[part].find_first_not_of("0123456789") == std::string::npos;
    if (!is_whole) return {};
    seconds += weights[part] * number.value;
  }
  return seconds;
}

/// The units that Kinovea does not name. @param line of the first time, for the error
std::pair<Unit, Unit> named_units(const ExportHints& hints, int line, bool has_timecodes) {
  const bool lacks_time = !hints.time_unit && !has_timecodes;
  if (hints.time_unit && has_timecodes)
    throw InputError(hints.file, line, "the times are timecodes, which need no time_unit; none was expected");
  if (!hints.has_columns && (!hints.length_unit || lacks_time)) {
    throw InputError(
        hints.file, line,
        fmt::format("a Kinovea export names no units; a sidecar with length_unit = \"m\" (or another){} "
                    "was expected",
                    lacks_time ? " and time_unit = \"s\" (or \"ms\")" : ""));
  }
  return {parse_unit(hints.length_unit.value_or("m")),
          parse_unit(has_timecodes ? "s" : hints.time_unit.value_or("s"))};
}

Export read_kinovea_table(const std::vector<std::string>& lines, const ExportHints& hints, char delimiter) {
  const KinoveaCells names = cells_of(lines[0], delimiter);
  const auto [length, time] = named_units(hints, 1, false);
  std::vector<std::string> rewritten = lines;
  rewritten[0] = joined(names, names.size(), kRewritten);
  int rows = 0, short_rows = 0;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    KinoveaCells cells = cells_of(lines[k], delimiter);
    if (std::ranges::all_of(cells, &std::string::empty)) {
      rewritten[k].clear();
      continue;
    }
    std::ranges::transform(cells, cells.begin(), with_point);
    rewritten[k] = joined(cells, names.size(), kRewritten);
    ++rows;
    if (cells.size() < names.size()) ++short_rows;
  }
  Export result{io::DelimitedTable::parse(table_text(rewritten, 0), hints.file, {.delimiter = kRewritten}),
                {},
                "Kinovea",
                "",
                rows,
                short_rows};
  for (std::size_t k = 1; k < names.size(); k += 2)
    result.bodies.push_back(
        {body_name(*point_of(names[k], "/X")),
         {{names[0], kTimeQuantity, time}, {names[k], "x", length}, {names[k + 1], "y", length}}});
  return result;
}

/// Sections, one for each track, parted by blank lines; since version 0.9.6 below "# name".
Export read_gnuplot_text(const std::vector<std::string>& lines, const ExportHints& hints) {
  std::vector<std::string> rewritten(lines.size()), names;
  rewritten[0] = joined({"body", "t", "x", "y"}, 4, kRewritten);
  std::string name;
  std::map<std::string, int> seen;
  bool is_open = false, has_timecodes = false;
  int first_line = 0, rows = 0;
  for (std::size_t k = 1; k < lines.size(); ++k) {
    const std::string_view line = trimmed(lines[k]);
    if (line.starts_with('#')) {
      if (line != "#T X Y") name = trimmed(line.substr(1));
      continue;
    }
    if (line.empty()) {
      if (is_open) name.clear();
      is_open = false;
      continue;
    }
    if (!is_open) {
      if (name.empty()) name = fmt::format("track {}", names.size() + 1);
      const int before = seen[name]++;
      names.push_back(before == 0 ? name : fmt::format("{} ({})", name, before + 1));
    }
    is_open = true;
    KinoveaCells cells;
    for (std::string& cell : cells_of(line, ' ')) {
      if (!cell.empty()) cells.push_back(with_point(std::move(cell)));
    }
    if (cells.size() != 3)
      throw InputError(hints.file, static_cast<int>(k) + 1,
                       fmt::format("{} numbers stand there, expected time, x and y", cells.size()));
    const std::optional<double> seconds = seconds_of(cells[0]);
    if (!seconds && cells[0].find(':') != std::string::npos)
      throw InputError(
          hints.file, static_cast<int>(k) + 1,
          fmt::format("the time \"{}\" is no timecode: h:mm:ss: and two digits (hundredths) or three "
                      "(thousandths) were expected",
                      cells[0]));
    if (rows++ == 0) {
      has_timecodes = seconds.has_value();
      first_line = static_cast<int>(k) + 1;
    }
    if (seconds.has_value() != has_timecodes)
      throw InputError(hints.file, static_cast<int>(k) + 1,
                       fmt::format("the time \"{}\" is {} timecode as the first one is", cells[0],
                                   has_timecodes ? "no" : "a"));
    if (seconds) cells[0] = fmt::format("{}", *seconds);
    rewritten[k] = joined({names.back(), cells[0], cells[1], cells[2]}, 4, kRewritten);
  }
  if (names.empty()) throw InputError(hints.file, "a Kinovea export without a track");
  const auto [length, time] = named_units(hints, first_line, has_timecodes);
  Export result{io::DelimitedTable::parse(table_text(rewritten, 0), hints.file, {.delimiter = kRewritten}),
                {},
                "Kinovea",
                "",
                rows,
                0};
  for (const std::string& body : names)
    result.bodies.push_back(
        {body, {{"t", kTimeQuantity, time}, {"x", "x", length}, {"y", "y", length}}, "body"});
  return result;
}

}  // namespace

bool is_kinovea_export(const std::vector<std::string>& lines) {
  return !lines.empty() && (lines[0].starts_with(kGnuplotTitle) || table_delimiter(lines[0]));
}

Export read_kinovea_export(const std::vector<std::string>& lines, const ExportHints& hints) {
  if (lines[0].starts_with(kGnuplotTitle)) return read_gnuplot_text(lines, hints);
  return read_kinovea_table(lines, hints, table_delimiter(lines[0]).value());
}

}  // namespace samara::identification
