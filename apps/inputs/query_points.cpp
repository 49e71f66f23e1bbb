#include "inputs/query_points.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "inputs/assignments.h"
#include "inputs/value_lists.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/unit_labels.h"
#include "samara/base/units.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/io/csv.h"
#include "samara/io/text_file.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;
using codebooks::Coordinate;
using Eigen::Index;

std::vector<double> times_of(const Codebook& book, const QueryArguments& arguments) {
  const bool is_composed = !arguments.until.empty();
  const Coordinate& time = book.time(is_composed ? "--until" : arguments.frames ? "--frames" : "--at");
  const std::vector<double> times = numbers_of("--at", arguments.at, time.unit);
  if (!times.empty()) return times;
  const double end = is_composed ? positive_quantity("--until", arguments.until, time.unit) : time.upper;
  const double begin = is_composed ? 0.0 : time.lower;
  constexpr int kUsualTimes = 11;
  const Eigen::VectorXd all = even_times(arguments.frames.value_or(kUsualTimes), begin, end);
  return {all.begin(), all.end()};
}

/// A column of a table: "v(0)[cm/s]".
struct Column {
  std::string name, unit;  ///< no unit: SI
};

Column column_of(const std::string& header) {
  const std::size_t open = header.find('[');
  if (open == std::string::npos || !header.ends_with(']')) return {header, ""};
  return {header.substr(0, open), header.substr(open + 1, header.size() - open - 2)};
}

/// The columns of --points, and which coordinate each is; then the rows.
struct GivenPoints {
  std::string file;
  io::DelimitedTable head;
  std::vector<Index> coordinates;          ///< of the columns
  std::vector<std::optional<Unit>> units;  ///< of the columns; none: SI
  std::optional<io::NumberTable> table;    ///< once its numbers are read

  InputError error(const std::string& sentence) const {
    return InputError(file, head.line_of_header(), sentence);
  }
};

/// @param text all of it
GivenPoints given_columns(const std::string& path, std::string& text) {
  const bool is_stdin = path == "-";
  const std::string file = is_stdin ? "stdin" : path;
  if (is_stdin) require_stdin("a table of points");
  text = io::read_text_file(is_stdin ? "/dev/stdin" : path, {.expected = "a table of points"});
  return {file, io::NumberTable::head(text, file), {}, {}, {}};
}

void read_rows(std::string text, GivenPoints& given) {
  given.table = io::NumberTable::parse(std::move(text), given.file);
  if (given.table->values().rows() == 0) throw InputError(given.file, "has no rows; points were expected");
}

/// Whether points of a mesh are asked for, instead of its nodes.
bool asks_for_places(const Codebook& book, const QueryArguments& arguments,
                     const std::optional<GivenPoints>& given) {
  if (book.mesh() == nullptr) return false;
  const auto is_direction = [&](const std::string& name) {
    return std::ranges::count(book.mesh()->directions(), name) > 0;
  };
  return std::ranges::any_of(
             arguments.set,
             [&](const std::string& text) { return is_direction(text.substr(0, text.find('='))); }) ||
         (given && std::ranges::any_of(given->head.header(), [&](const std::string& header) {
            return is_direction(column_of(header).name);
          }));
}

/// The unit of a column; none if its numbers are in SI.
std::optional<Unit> unit_of(const GivenPoints& given, const std::string& header,
                            const Coordinate& coordinate) {
  const std::string unit = column_of(header).unit;
  if (unit.empty() || unit == coordinate.unit) return std::nullopt;
  try {
    if (!same_dimension(unit, coordinate.unit))
      throw ArgumentError(fmt::format("{} is in {}, expected {}", coordinate.name, unit, coordinate.unit));
    return parse_unit(unit);
  } catch (const ArgumentError& error) {
    throw given.error(error.what());
  }
}

/// Which coordinate each column is, and in which unit.
void find_columns(GivenPoints& given, const std::vector<Coordinate>& coordinates) {
  std::vector<std::string> known;
  for (const Coordinate& c : coordinates) known.push_back(c.name);
  for (const std::string& header : given.head.header()) {
    const std::string name = full_name(column_of(header).name, known);
    const auto found = std::ranges::find(known, name);
    if (found == known.end()) {
      throw given.error(fmt::format("the column \"{}\" is no coordinate of the codebook{}", header,
                                    suggestion(name, known)));
    }
    const Index at = found - known.begin();
    if (std::ranges::count(given.coordinates, at) > 0)
      throw given.error(fmt::format("two columns hold \"{}\"; one was expected", name));
    given.coordinates.push_back(at);
    given.units.push_back(unit_of(given, header, coordinates[static_cast<std::size_t>(at)]));
  }
}

/// A column to coordinate k of the points, in SI. All times of a point follow one another.
void read_column(const GivenPoints& given, Index column, const Coordinate& coordinate, Index k,
                 QueryPoints& points) {
  const std::optional<Unit>& unit = given.units[static_cast<std::size_t>(column)];
  const io::NumberTable& table = *given.table;
  for (Index row = 0; row < table.values().rows(); ++row) {
    const double value = table.values()(row, column);
    if (std::isnan(value))
      throw table.error(row, fmt::format("has no {}, but a number was expected", coordinate.name));
    points.x.col(k).segment(row * points.times, points.times).setConstant(unit ? unit->to_si(value) : value);
  }
  if (!unit && table.has_cells()) points.columns[static_cast<std::size_t>(k)] = column;
}

/// A table names the line where a point leaves the box.
void check_inside(const GivenPoints& given, const std::vector<Coordinate>& coordinates,
                  const io::NumberTable::Rows& x, Index times) {
  for (Index row = 0; row < x.rows(); ++row) {
    for (const Index k : given.coordinates) {
      const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
      if (x(row, k) >= c.lower && x(row, k) <= c.upper) continue;
      const std::string unit = unit_suffix(c.unit);
      throw OutsideBoxError(
          given.table
              ->error(row / times, fmt::format("{} = {}{} is outside the box, [{}, {}]{}", c.name, x(row, k),
                                               unit, c.lower, c.upper, unit))
              .what());
    }
  }
}

/// What one asks for may not take all the memory there is.
/// @param outputs that the codebook holds
void check_count(Index rows, Index coordinates, Index outputs, const QueryArguments& arguments) {
  constexpr double kMost = 1e8, kCopiesOfJson = 3.0;
  const Index columns = coordinates + outputs * (arguments.gradient ? 1 + coordinates : 1);
  const double numbers = static_cast<double>(rows) * static_cast<double>(columns);
  if (numbers * (arguments.json ? kCopiesOfJson : 1.0) > kMost)
    throw ArgumentError(fmt::format(
        "{} points are asked for at once, {:.3g} numbers; fewer times or a part of the table were "
        "expected",
        rows, numbers));
}

void clamp(QueryPoints& points, const std::vector<Coordinate>& coordinates) {
  for (Index k = 0; k < points.x.cols(); ++k) {
    const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
    const Eigen::VectorXd inside = points.x.col(k).cwiseMax(c.lower).cwiseMin(c.upper);
    if (inside == points.x.col(k)) continue;
    points.clamped.push_back(c.name);
    points.columns[static_cast<std::size_t>(k)] = -1;
    points.x.col(k) = inside;
  }
}

}  // namespace

void QueryPoints::append_cells(Index point, std::vector<std::string_view>& cells, std::string& text) const {
  if (table && table->has_cells()) {
    cells.resize(table->header().size());
    if (point % times == 0 || cells.front().empty()) table->read_cells(point / times, cells);
  }
  for (Index k = 0; k < x.cols(); ++k) {
    if (k > 0) text += ',';
    const Index column = columns[static_cast<std::size_t>(k)];
    if (column < 0) {
      io::append_number(text, x(point, k));
    } else {
      text += cells[static_cast<std::size_t>(column)];
    }
  }
}

QueryPoints points_of(const Codebook& book, const QueryArguments& arguments) {
  std::optional<GivenPoints> given;
  std::string text;
  if (!arguments.points.empty()) given = given_columns(arguments.points, text);
  QueryPoints points;
  points.of_places = asks_for_places(book, arguments, given);
  points.coordinates = points.of_places ? codebooks::PlaceQuery(book).coordinates() : book.coordinates();
  const std::vector<Coordinate>& coordinates = points.coordinates;
  if (given) {
    find_columns(*given, coordinates);
    read_rows(std::move(text), *given);
  }
  const auto is_column = [&](Index k) { return given && std::ranges::count(given->coordinates, k) > 0; };
  const bool has_time = book.has_time();
  const auto count = std::ssize(coordinates);
  const Index first = has_time ? 1 : 0;
  std::map<std::string, std::string> units;
  for (Index k = first; k < count; ++k) {
    const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
    if (!is_column(k)) units[c.name] = c.unit;
  }
  for (const std::string& setting : arguments.set) {
    const std::string name = setting_of("--set", setting).name;
    for (Index k = first; k < count; ++k)
      if (is_column(k) && coordinates[static_cast<std::size_t>(k)].name == name)
        throw ArgumentError(fmt::format("--set names \"{}\", which is a column of {}", name, given->file));
  }
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);

  const bool asks_times = !arguments.at.empty() || !arguments.until.empty() || arguments.frames;
  if (is_column(0) && has_time && asks_times)
    throw ArgumentError(
        fmt::format("{} has a column of the time: neither --at nor --frames was expected", given->file));
  std::vector<double> times;
  if ((has_time && !is_column(0)) || (asks_times && !has_time)) times = times_of(book, arguments);
  const Index rows = given ? given->table->values().rows() : 1,
              repeats = std::max<Index>(1, std::ssize(times));
  check_count(rows * repeats, count, book.output_count(), arguments);

  points.x.resize(rows * repeats, count);
  points.times = repeats;
  points.columns.assign(static_cast<std::size_t>(count), -1);
  if (!times.empty()) {
    const Eigen::Map<const Eigen::VectorXd> all(times.data(), std::ssize(times));
    points.x.col(0) = all.replicate(rows, 1);
  }
  for (Index column = 0; given && column < std::ssize(given->coordinates); ++column) {
    const Index k = given->coordinates[static_cast<std::size_t>(column)];
    read_column(*given, column, coordinates[static_cast<std::size_t>(k)], k, points);
  }
  for (Index k = first; k < count; ++k) {
    if (is_column(k)) continue;
    const Coordinate& c = coordinates[static_cast<std::size_t>(k)];
    const auto value = values.find(c.name);
    if (value == values.end()) {
      throw ArgumentError(fmt::format("{} is not set, expected --set \"{}=VALUE\" with a value in [{}, {}]{}",
                                      c.name, c.name, c.lower, c.upper, unit_suffix(c.unit)));
    }
    points.x.col(k).setConstant(value->second);
  }
  if (arguments.clamp) {
    clamp(points, coordinates);
  } else if (given) {
    check_inside(*given, coordinates, points.x, repeats);
  }
  if (given) points.table = std::move(given->table);
  return points;
}

}  // namespace samara::apps
