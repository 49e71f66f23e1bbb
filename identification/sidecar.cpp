#include "samara/identification/sidecar.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

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

io::Unit unit_of(const TomlTable& table, const std::string& key) {
  try {
    return io::parse_unit(table.string(key));
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

std::map<std::string, std::vector<std::string>> read_where(const TomlTable& where) {
  std::map<std::string, std::vector<std::string>> allowed;
  for (const std::string& column : where.keys()) {
    allowed[column] =
        where.is_string(column) ? std::vector<std::string>{where.string(column)} : where.strings(column);
    if (allowed[column].empty()) throw where.error(column, "no value is allowed; at least one was expected");
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
  if (scale.length == 0.0) throw entry.error("length", "the length is 0; another value was expected");
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

std::filesystem::path read_table_path(const TomlTable& root, const std::filesystem::path& sidecar,
                                      const std::filesystem::path& table) {
  if (!table.empty() && !root.has("file")) return table;
  const std::filesystem::path named = sidecar.parent_path() / root.string("file");
  if (!table.empty() && named.filename() != table.filename()) {
    throw root.error("file",
                     fmt::format("names \"{}\", but stands beside \"{}\" as its sidecar; name the sidecar "
                                 "itself, or rename it",
                                 root.string("file"), table.filename().string()));
  }
  return named;
}

}  // namespace

InputError Sidecar::error(const std::string& section, const std::string& key,
                          const std::string& sentence) const {
  if (!document) return InputError(table.string(), sentence);
  return (section.empty() ? *document : document->table(section)).error(key, sentence);
}

Sidecar read_sidecar(const std::filesystem::path& path, const std::filesystem::path& table) {
  const TomlTable root = TomlTable::read(path);
  root.expect_keys({"file", "delimiter", "columns", "group_by", "where", "frame_rate", "scale", "start"});
  Sidecar sidecar;
  sidecar.document = root;
  sidecar.table = read_table_path(root, path, table);
  if (root.has("delimiter")) {
    sidecar.delimiter =
        choice<char>(root, "delimiter", {{",", ','}, {";", ';'}, {"tab", '\t'}, {"\t", '\t'}});
  }
  if (root.has("columns")) sidecar.columns = read_columns(root.table("columns"));
  if (root.has("columns") && sidecar.columns.empty()) throw root.error("columns", "no column is named");
  sidecar.group_by = root.optional_strings("group_by").value_or(std::vector<std::string>{});
  if (root.has("where")) sidecar.where = read_where(root.table("where"));
  if (root.has("frame_rate")) sidecar.frame_rate = read_frame_rate(root);
  if (root.has("scale")) {
    const TomlTable scales = root.table("scale");
    for (const std::string& quantity : scales.keys()) {
      sidecar.scales[quantity] = read_scale(scales.table(quantity));
    }
  }
  if (root.has("start")) {
    sidecar.start = choice<CaptureStart>(
        root, "start",
        {{"first visible", CaptureStart::first_visible}, {"as given", CaptureStart::as_given}});
  }
  return sidecar;
}

}  // namespace samara::identification
