#include "samara/identification/series/series_config.h"

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/toml_document.h"

namespace samara::identification {

namespace {

using io::TomlTable;

double positive_quantity(const TomlTable& table, const std::string& key, const std::string& unit) {
  const double value = table.quantity(key, unit);
  if (!(value > 0.0)) throw table.error(key, fmt::format("the value is {}; more than 0 was expected", value));
  return value;
}

std::optional<SeriesOptions> read_series(const TomlTable& root, const ConfigNames& names) {
  if (!root.has("series")) return {};
  const TomlTable table = root.table("series");
  table.expect_keys({"coefficients", "span", "window", "stride", "order", "smoothness"});
  std::vector<std::string> known;
  for (const auto& [name, unit] : names.coordinates) known.push_back(name);
  SeriesOptions series;
  series.coefficients = table.strings("coefficients");
  if (series.coefficients.empty()) {
    throw table.error(
        "coefficients",
        "the list is empty; at least one coefficient that changes along the captures was expected");
  }
  for (const std::string& name : series.coefficients) {
    if (names.coordinates.contains(name)) continue;
    throw table.error("coefficients", fmt::format("unknown name \"{}\"{}", name, suggestion(name, known)));
  }
  series.span = positive_quantity(table, table.renamed("span", "window"), "s");
  if (table.has("stride")) series.stride = positive_quantity(table, "stride", "s");
  if (table.has("order")) series.order = static_cast<int>(table.integer("order"));
  if (table.has("smoothness")) {
    const TomlTable scales = table.table("smoothness");
    scales.expect_keys(series.coefficients);
    for (const std::string& name : scales.keys())
      series.scales[name] = positive_quantity(scales, name, names.coordinates.at(name));
  }
  try {
    validate(series);
  } catch (const ArgumentError& error) {
    throw root.error("series", error.what());
  }
  return series;
}

}  // namespace

std::optional<SeriesOptions> parse_series_config(std::string_view text, const std::string& name,
                                                 const ConfigNames& names) {
  return read_series(TomlTable::parse(text, name, "a config of a fit"), names);
}

}  // namespace samara::identification
