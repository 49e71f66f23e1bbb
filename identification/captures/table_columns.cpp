#include "samara/identification/captures/table_columns.h"

#include <algorithm>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/names.h"
#include "samara/base/units.h"

namespace samara::identification {

namespace {

std::string_view without_blanks_behind(std::string_view text) {
  const std::size_t last = text.find_last_not_of(" \t");
  return text.substr(0, last == std::string_view::npos ? 0 : last + 1);
}

/// "theta[deg]" or "theta [deg]".
ColumnMeaning canonical_meaning(const io::DelimitedTable& table, const std::string& header) {
  const std::size_t open = header.find('[');
  const std::string_view name = without_blanks_behind(std::string_view(header).substr(0, open));
  if (open == std::string::npos || header.back() != ']' || name.empty()) {
    throw InputError(
        table.file(), table.line_of_header(),
        fmt::format("column \"{}\" has no unit; a header like \"x[m]\" was expected, or a sidecar that "
                    "says what the columns are",
                    header));
  }
  try {
    const std::string_view unit = std::string_view(header).substr(open + 1, header.size() - open - 2);
    return {header, std::string(name), parse_unit(unit)};
  } catch (const ArgumentError& error) {
    throw InputError(table.file(), table.line_of_header(),
                     fmt::format("column \"{}\": {}", header, error.what()));
  }
}

/// Columns that only group or select rows need no unit.
bool is_label(const Sidecar& sidecar, const std::string& column) {
  return std::ranges::count(sidecar.group_by, column) > 0 || sidecar.where.contains(column);
}

/// Where the meaning of a column was stated.
InputError meaning_error(const io::DelimitedTable& table, const Sidecar& sidecar, const std::string& column,
                         const std::string& sentence) {
  if (!sidecar.columns.empty()) return sidecar.error("columns", column, sentence);
  return InputError(table.file(), table.line_of_header(), fmt::format("column \"{}\": {}", column, sentence));
}

std::vector<ColumnMeaning> meanings_of(const io::DelimitedTable& table, const Sidecar& sidecar) {
  std::vector<ColumnMeaning> meanings = sidecar.columns;
  if (meanings.empty()) {
    for (const std::string& header : table.header()) {
      const bool is_euler = sidecar.euler && std::ranges::count(sidecar.euler->columns, header) > 0;
      if (!is_label(sidecar, header) && !is_euler) meanings.push_back(canonical_meaning(table, header));
    }
  }
  for (std::size_t k = 0; k < meanings.size(); ++k) {
    const ColumnMeaning& meaning = meanings[k];
    if (!table.has(meaning.column)) {
      throw meaning_error(table, sidecar, meaning.column,
                          fmt::format("\"{}\" has no such column{}", table.file(),
                                      suggestion(meaning.column, table.header())));
    }
    const auto earlier =
        std::ranges::find(meanings.begin(), meanings.begin() + static_cast<std::ptrdiff_t>(k),
                          meaning.quantity, &ColumnMeaning::quantity);
    if (earlier != meanings.begin() + static_cast<std::ptrdiff_t>(k)) {
      throw meaning_error(
          table, sidecar, meaning.column,
          fmt::format("quantity \"{}\" is already in column \"{}\"", meaning.quantity, earlier->column));
    }
  }
  return meanings;
}

/// Time in s, from seconds or from frame numbers.
Column time_column(const io::DelimitedTable& table, const Sidecar& sidecar, const ColumnMeaning& meaning) {
  Column column{meaning.column, meaning.quantity, "s", table.numbers(meaning.column)};
  const bool in_frames = meaning.unit.dimension == Dimension{.frame = 1};
  if (!in_frames && meaning.unit.dimension != Dimension{.second = 1}) {
    throw meaning_error(table, sidecar, meaning.column,
                        fmt::format("time has a unit of dimension {}; a time, or \"frame\", was expected",
                                    to_string(meaning.unit.dimension)));
  }
  if (in_frames && !sidecar.frame_rate) {
    throw meaning_error(table, sidecar, meaning.column,
                        "time is in frames; the sidecar's `frame_rate` is missing");
  }
  if (!in_frames && sidecar.frame_rate) {
    throw sidecar.error("", "frame_rate", "is given, but time is not in frames; one of the two was expected");
  }
  const double rate = sidecar.frame_rate.value_or(1.0);
  for (double& time : column.values) time = meaning.unit.to_si(time) / rate;
  return column;
}

Column measured_column(const io::DelimitedTable& table, const ColumnMeaning& meaning) {
  Column column{meaning.column, meaning.quantity, to_string(meaning.unit.dimension),
                table.numbers(meaning.column)};
  for (double& value : column.values) value = meaning.unit.to_si(value);
  return column;
}

std::vector<Column> euler_columns(const io::DelimitedTable& table, const Sidecar& sidecar) {
  std::vector<Column> columns;
  for (const std::string& name : sidecar.euler->columns) {
    if (!table.has(name)) {
      throw sidecar.error(
          "attitude", "euler",
          fmt::format("\"{}\" has no column \"{}\"{}", table.file(), name, suggestion(name, table.header())));
    }
    columns.push_back({name, name, "1", table.numbers(name)});
    for (double& value : columns.back().values) value = sidecar.euler->unit.to_si(value);
  }
  return columns;
}

/// Every scale belongs to a measured quantity in px.
void check_scales(const Columns& columns, const Sidecar& sidecar) {
  std::vector<std::string> known;
  for (const Column& column : columns.measured) known.push_back(column.quantity);
  for (const auto& [quantity, scale] : sidecar.scales) {
    const auto column = std::ranges::find(columns.measured, quantity, &Column::quantity);
    if (column == columns.measured.end()) {
      throw sidecar.error("scale", quantity,
                          fmt::format("no column holds this quantity{}", suggestion(quantity, known)));
    }
    if (column->unit != "px") {
      throw sidecar.error(
          "scale", quantity,
          fmt::format("its column \"{}\" has dimension {}; a scale is for px", column->name, column->unit));
    }
  }
}

}  // namespace

Columns read_columns(const io::DelimitedTable& table, const Sidecar& sidecar) {
  std::optional<Column> time;
  Columns columns;
  for (const ColumnMeaning& meaning : meanings_of(table, sidecar)) {
    if (meaning.quantity == kTimeQuantity) {
      time = time_column(table, sidecar, meaning);
    } else {
      columns.measured.push_back(measured_column(table, meaning));
    }
  }
  const auto refuse = [&](const std::string& sentence) {
    if (!sidecar.columns.empty()) throw sidecar.error("", "columns", sentence);
    throw InputError(table.file(), table.line_of_header(), sentence);
  };
  if (!time && !sidecar.frame_rate) {
    refuse(
        "no column holds the time; one with the quantity \"t\" was expected, or a frame_rate at which rows "
        "follow one another");
  }
  if (sidecar.euler) columns.euler = euler_columns(table, sidecar);
  if (columns.measured.empty() && columns.euler.empty())
    refuse("no column holds a measured quantity beside the time");
  columns.time = std::move(time);
  check_scales(columns, sidecar);
  return columns;
}

}  // namespace samara::identification
