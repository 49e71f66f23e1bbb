#include "samara/identification/series/series_config.h"

#include <cstdint>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/toml_document.h"

namespace samara::identification {

namespace {

using io::TomlTable;

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
  series.span = table.positive(table.renamed("span", "window"), "s");
  if (table.has("stride")) series.stride = table.positive("stride", "s");
  if (table.has("order")) {
    const std::int64_t order = table.integer("order");
    if (order != 1 && order != 2)
      throw table.error("order", fmt::format("is {}; 1 or 2 was expected", order));
    series.order = static_cast<int>(order);
  }
  if (table.has("smoothness")) {
    const TomlTable scales = table.table("smoothness");
    scales.expect_keys(series.coefficients);
    for (const std::string& name : scales.keys())
      series.scales[name] = scales.positive_difference(name, names.coordinates.at(name));
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
