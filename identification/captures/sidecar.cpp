#include "samara/identification/captures/sidecar.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <system_error>

#include <fmt/format.h>
#include <glob.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/identification/captures/number_cells.h"
#include "samara/io/delimited_table.h"

namespace samara::identification {

namespace {

using io::TomlTable;

/// One of the words a key may have.
template <class Value>
Value choice(const TomlTable& table, const std::string& key,
             const std::vector<std::pair<std::string, Value>>& words) {
  const std::string word = table.string(key);
  std::vector<std::string> known;
  for (const auto& [candidate, value] : words) {
    if (candidate == word) return value;
    known.push_back(candidate);
  }
  throw table.error(key, fmt::format("\"{}\" is none of its words{}", word, suggestion(word, known)));
}

Unit unit_of(const TomlTable& table, const std::string& key) {
  try {
    return parse_unit(table.string(key));
  } catch (const ArgumentError& error) {
    throw table.error(key, error.what());
  }
}

std::vector<ColumnMeaning> read_columns(const TomlTable& columns) {
  std::vector<ColumnMeaning> meanings;
  for (const std::string& column : columns.keys()) {
    const TomlTable entry = columns.table(column);
    entry.expect_keys({"quantity", "unit"});
    meanings.push_back({column, entry.string("quantity"), unit_of(entry, "unit")});
  }
  return meanings;
}

bool is_comparison(const std::string& text) {
  return text.starts_with('<') || text.starts_with('>');
}

/// Of "< 2".
std::optional<double> bound_of(const std::string& text) {
  return number_in(trimmed(std::string_view(text).substr(1)));
}

std::map<std::string, std::vector<std::string>> read_where(const TomlTable& where) {
  std::map<std::string, std::vector<std::string>> allowed;
  for (const std::string& column : where.keys()) {
    allowed[column] =
        where.is_string(column) ? std::vector<std::string>{where.string(column)} : where.strings(column);
    if (allowed[column].empty()) throw where.error(column, "no value is allowed; at least one was expected");
    for (const std::string& text : allowed[column]) {
      if (is_comparison(text) && !bound_of(text))
        throw where.error(column, fmt::format("\"{}\" compares with no number; \"< 2\" was expected", text));
    }
  }
  return allowed;
}

PixelScale read_scale(const TomlTable& entry) {
  entry.expect_keys({"value", "length", "over"});
  PixelScale scale;
  if (entry.has("value")) {
    if (entry.has("length"))
      throw entry.error("length", "stands beside `value`; one of the two was expected");
    if (entry.has("over")) throw entry.error("over", "stands beside `value`; it belongs to `length`");
    scale.value = entry.quantity("value", "m/px");
    if (scale.value == 0.0) throw entry.error("value", "the scale is 0; another value was expected");
    return scale;
  }
  scale.length = entry.quantity("length", "m");
  if (!(scale.length > 0.0)) {
    throw entry.error(
        "length",
        fmt::format("the length is {} m; more than 0 was expected, and `flip` turns an axis", scale.length));
  }
  scale.span = choice<ScaleSpan>(entry, "over",
                                 {{"largest - first", ScaleSpan::largest_minus_first},
                                  {"largest - smallest", ScaleSpan::largest_minus_smallest}});
  return scale;
}

/// "60 Hz", "60 1/s", "60 frame/s", or plainly 60.
double read_frame_rate(const TomlTable& root) {
  const std::string key = "frame_rate";
  const bool counts_frames = root.is_string(key) && root.string(key).find("frame") != std::string::npos;
  const double rate = root.quantity(key, counts_frames ? "frame/s" : "Hz");
  if (!(rate > 0.0)) throw root.error(key, fmt::format("{} frames a second; more than 0 was expected", rate));
  return rate;
}

/// A file may lie beside a table, with its stem, and be none of its sidecars: a config, for one.
void check_keys(const TomlTable& root, const std::filesystem::path& table,
                const std::vector<std::string>& known) {
  if (table.empty()) root.expect_keys(known);
  for (const std::string& key : root.keys()) {
    if (std::ranges::count(known, key) > 0) continue;
    throw root.error(key, fmt::format("unknown key{}; the file was read as the sidecar of \"{}\"",
                                      suggestion(key, known), table.filename().string()));
  }
}

std::filesystem::path read_table_path(const TomlTable& root, const std::filesystem::path& sidecar,
                                      const std::filesystem::path& table) {
  if (!table.empty() && !root.has("file")) return table;
  if (!root.has("file")) {
    throw root.error(
        "file",
        "is missing: the sidecar names no table; give the tables, and the sidecar by --sidecar, or lay "
        "it beside a table of its name");
  }
  const std::filesystem::path named = sidecar.parent_path() / root.string("file");
  if (!table.empty() && named.filename() != table.filename()) {
    throw root.error("file",
                     fmt::format("names \"{}\", but stands beside \"{}\" as its sidecar; name the sidecar "
                                 "itself, or rename it",
                                 root.string("file"), table.filename().string()));
  }
  return named;
}

/// "tracks_*.csv", "[0-9]*.csv": the files that match, sorted; empty if the path is no pattern.
std::vector<std::filesystem::path> matching_files(const TomlTable& root,
                                                  const std::filesystem::path& pattern) {
  if (pattern.filename().string().find_first_of("*?[") == std::string::npos) return {};
  ::glob_t matches{};
  std::vector<std::filesystem::path> found;
  if (::glob(pattern.c_str(), 0, nullptr, &matches) == 0)
    found.assign(matches.gl_pathv, matches.gl_pathv + matches.gl_pathc);
  ::globfree(&matches);
  if (found.empty()) throw root.error("file", fmt::format("no file matches \"{}\"", pattern.string()));
  return found;
}

EulerColumns read_euler(const TomlTable& attitude) {
  attitude.expect_keys({"euler", "order", "unit"});
  EulerColumns euler{attitude.strings("euler"), attitude.string("order"), unit_of(attitude, "unit")};
  if (euler.columns.size() != 3)
    throw attitude.error("euler", fmt::format("{} columns; three were expected", euler.columns.size()));
  const std::string& order = euler.order;
  const bool is_order = order.size() == 3 && order.find_first_not_of("xyz") == std::string::npos &&
                        order[0] != order[1] && order[1] != order[2];
  if (!is_order) {
    throw attitude.error("order",
                         fmt::format("\"{}\"; three of x, y, z, none twice in a row, were expected", order));
  }
  if (!euler.unit.dimension.is_dimensionless())
    throw attitude.error("unit", "is no unit of an angle; \"deg\" or \"rad\" was expected");
  return euler;
}

std::map<std::string, double> read_periods(const TomlTable& table) {
  std::map<std::string, double> periods;
  for (const std::string& quantity : table.keys()) {
    periods[quantity] = table.quantity(quantity, "rad");
    if (!(periods[quantity] > 0.0))
      throw table.error(quantity, fmt::format("{}; more than 0 was expected", periods[quantity]));
  }
  return periods;
}

std::map<std::string, std::pair<double, double>> read_intervals(const TomlTable& table) {
  std::map<std::string, std::pair<double, double>> intervals;
  for (const std::string& quantity : table.keys()) {
    const std::vector<double> ends = table.quantities(quantity, "m");
    if (ends.size() != 2 || !(ends[0] < ends[1]))
      throw table.error(quantity, "an interval, [lower, upper] with lower < upper, was expected");
    intervals[quantity] = {ends[0], ends[1]};
  }
  return intervals;
}

CleaningSteps read_cleaning(const TomlTable& clean) {
  clean.expect_keys(
      {"frame_grid", "before_impact", "inside", "outliers", "bandwidth", "window", "periods", "longest_gap"});
  const std::string bandwidth = clean.renamed("bandwidth", "window");
  CleaningSteps steps;
  if (clean.has("frame_grid") && !clean.is_boolean("frame_grid"))
    steps.frame_period = clean.quantity("frame_grid", "s");
  steps.frame_grid = steps.frame_period || clean.optional_boolean("frame_grid").value_or(false);
  steps.impact = clean.optional_quantity("before_impact", "m/s");
  steps.outliers = clean.optional_number("outliers");
  steps.bandwidth = clean.optional_quantity(bandwidth, "s");
  steps.longest_gap = clean.optional_quantity("longest_gap", "s");
  using Step = std::pair<std::string, std::optional<double>>;
  for (const auto& [key, value] :
       {Step("frame_grid", steps.frame_period), Step("before_impact", steps.impact),
        Step("outliers", steps.outliers), Step(bandwidth, steps.bandwidth),
        Step("longest_gap", steps.longest_gap)}) {
    if (value && !(*value > 0.0)) throw clean.error(key, fmt::format("{}; more than 0 was expected", *value));
  }
  if (clean.has("inside")) steps.inside = read_intervals(clean.table("inside"));
  if (clean.has("periods")) steps.periods = read_periods(clean.table("periods"));
  for (const std::string& key : {bandwidth, std::string("periods")}) {
    if (clean.has(key) && !steps.outliers)
      throw clean.error(key, "belongs to `outliers`, which is not there");
  }
  return steps;
}

std::string read_length_unit(const TomlTable& root) {
  const Dimension dimension = unit_of(root, "length_unit").dimension;
  if (dimension != Dimension{.metre = 1} && dimension != Dimension{.pixel = 1})
    throw root.error("length_unit",
                     fmt::format("\"{}\" is no unit of length, nor px", root.string("length_unit")));
  return root.string("length_unit");
}

std::string read_time_unit(const TomlTable& root) {
  if (unit_of(root, "time_unit").dimension != Dimension{.second = 1})
    throw root.error("time_unit", fmt::format("\"{}\" is no unit of time", root.string("time_unit")));
  return root.string("time_unit");
}

std::vector<std::string> read_flip(const TomlTable& root) {
  const std::vector<std::string> flip =
      root.is_string("flip") ? std::vector<std::string>{root.string("flip")} : root.strings("flip");
  for (const std::string& quantity : flip) {
    if (std::ranges::count(flip, quantity) > 1)
      throw root.error("flip", fmt::format("\"{}\" stands there twice", quantity));
    if (quantity == kTimeQuantity)
      throw root.error("flip", "time counts forward; a measured quantity was expected");
  }
  return flip;
}

/// Which frames, and how the world lies.
void read_frame_keys(const TomlTable& root, Sidecar& sidecar) {
  if (root.has("start")) {
    sidecar.start = choice<CaptureStart>(
        root, "start",
        {{"first visible", CaptureStart::first_visible}, {"as given", CaptureStart::as_given}});
  }
  sidecar.from = root.optional_quantity("from", "s");
  sidecar.until = root.optional_quantity("until", "s");
  if (root.has("repeated_times")) {
    sidecar.keep_first_of_repeated_times =
        choice<bool>(root, "repeated_times", {{"refuse", false}, {"keep first", true}});
  }
  if (root.has("flip")) sidecar.flip = read_flip(root);
  if (root.has("up")) {
    const std::vector<std::string> axes = {"x", "y", "z", "-x", "-y", "-z"};
    std::vector<std::pair<std::string, std::string>> words;
    for (const std::string& axis : axes) words.emplace_back(axis, axis);
    sidecar.up = choice<std::string>(root, "up", words);
  }
}

}  // namespace

bool Sidecar::has_label(const std::string& column) const {
  std::error_code ignored;
  if (!labels || column == labels->column || !std::filesystem::is_regular_file(labels->file, ignored))
    return false;
  return io::DelimitedTable::read(labels->file).has(column);
}

InputError Sidecar::error(const std::string& section, const std::string& key,
                          const std::string& sentence) const {
  if (!document) return InputError(table.string(), sentence);
  const bool is_stated = !section.empty() && document->has(section);
  return (is_stated ? document->table(section) : *document)
      .error(is_stated || section.empty() ? key : section, sentence);
}

std::string with_decimal_point(const std::string& cell, char decimal) {
  if (decimal != ',' || std::ranges::count(cell, ',') != 1) return cell;
  std::string pointed = cell;
  std::ranges::replace(pointed, ',', '.');
  return number_in(pointed) ? pointed : cell;
}

bool is_allowed(const std::string& cell, const std::vector<std::string>& allowed) {
  return std::ranges::any_of(allowed, [&](const std::string& text) {
    // The name of a body may look like a comparison: "<ball".
    if (cell == text) return true;
    if (!is_comparison(text)) return false;
    const std::optional<double> value = number_in(cell), bound = bound_of(text);
    return value && bound && (text[0] == '<' ? *value < *bound : *value > *bound);
  });
}

Sidecar read_sidecar(const std::filesystem::path& path, const std::filesystem::path& table) {
  const TomlTable root = TomlTable::read(path, "a sidecar");
  check_keys(root, table,
             {"file",  "delimiter",  "decimal",        "header",      "columns",   "attitude", "group_by",
              "where", "frame_rate", "least_frames",   "length_unit", "time_unit", "scale",    "start",
              "from",  "until",      "repeated_times", "flip",        "up",        "clean",    "labels"});
  Sidecar sidecar;
  sidecar.document = root;
  sidecar.table = read_table_path(root, path, table);
  sidecar.tables = matching_files(root, sidecar.table);
  sidecar.header = root.optional_strings("header").value_or(std::vector<std::string>{});
  if (root.has("delimiter")) {
    sidecar.delimiter =
        choice<char>(root, "delimiter", {{",", ','}, {";", ';'}, {"tab", '\t'}, {"\t", '\t'}});
  }
  if (root.has("decimal")) sidecar.decimal = choice<char>(root, "decimal", {{".", '.'}, {",", ','}});
  if (root.has("columns")) sidecar.columns = read_columns(root.table("columns"));
  if (root.has("columns") && sidecar.columns.empty()) throw root.error("columns", "no column is named");
  sidecar.group_by = root.optional_strings("group_by").value_or(std::vector<std::string>{});
  if (root.has("where")) sidecar.where = read_where(root.table("where"));
  if (root.has("least_frames")) {
    const std::int64_t least = root.integer("least_frames");
    if (least < 3 || least > std::numeric_limits<int>::max())
      throw root.error("least_frames", fmt::format("{} frames; at least 3 were expected", least));
    sidecar.least_frames = static_cast<int>(least);
  }
  if (root.has("frame_rate")) sidecar.frame_rate = read_frame_rate(root);
  if (root.has("scale")) {
    const TomlTable scales = root.table("scale");
    for (const std::string& quantity : scales.keys()) {
      sidecar.scales[quantity] = read_scale(scales.table(quantity));
    }
  }
  if (root.has("length_unit")) sidecar.length_unit = read_length_unit(root);
  if (root.has("time_unit")) sidecar.time_unit = read_time_unit(root);
  if (root.has("attitude")) sidecar.euler = read_euler(root.table("attitude"));
  if (root.has("clean")) sidecar.clean = read_cleaning(root.table("clean"));
  if (root.has("labels")) {
    const TomlTable labels = root.table("labels");
    labels.expect_keys({"file", "column"});
    sidecar.labels = {(table.empty() ? path : table).parent_path() / labels.string("file"),
                      labels.string("column")};
  }
  read_frame_keys(root, sidecar);
  return sidecar;
}

}  // namespace samara::identification
