#include "samara/identification/fit/prediction_config.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/io/toml_document.h"

namespace samara::identification {

namespace {

using io::TomlTable;

LabelChoice read_choice(const TomlTable& root, const std::string& key) {
  LabelChoice choice;
  if (!root.has(key)) return choice;
  const TomlTable table = root.table(key);
  for (const std::string& label : table.keys()) {
    choice[label] =
        table.is_string(label) ? std::vector<std::string>{table.string(label)} : table.strings(label);
    if (choice[label].empty()) throw table.error(label, "the list is empty; one text or more was expected");
  }
  if (choice.empty()) throw root.error(key, "names no label; at least one was expected");
  return choice;
}

int read_count(const TomlTable& table, const std::string& key) {
  constexpr std::int64_t kMost = 1000;
  const std::int64_t count = table.integer(key);
  if (count >= 2 && count <= kMost) return static_cast<int>(count);
  throw table.error(key, fmt::format("the value is {}; 2 to {} were expected", count, kMost));
}

/// `folds = 5`, or a table with a seed.
Folds read_folds(const TomlTable& root) {
  if (!root.is_table("folds")) return {.count = read_count(root, "folds")};
  const TomlTable table = root.table("folds");
  table.expect_keys({"count", "seed"});
  Folds folds{.count = read_count(table, "count")};
  if (!table.has("seed")) return folds;
  const std::int64_t seed = table.integer("seed");
  if (seed < 0) throw table.error("seed", fmt::format("the value is {}; 0 or more was expected", seed));
  folds.seed = static_cast<std::uint64_t>(seed);
  return folds;
}

std::vector<ViewPair> read_views(const TomlTable& table, bool mixture) {
  if (!table.has("views")) return {};
  if (!mixture)
    throw table.error("views",
                      "only trained forecasts look at views; `mixture = true` beside it was expected");
  std::vector<ViewPair> views;
  std::set<std::string> named;
  for (const std::vector<std::string>& pair : table.string_lists("views")) {
    if (pair.size() != 2)
      throw table.error("views", fmt::format("element {}: expected a pair of channels, that seen along x and "
                                             "that seen along y, found an array of {}",
                                             views.size(), pair.size()));
    for (const std::string& channel : pair) {
      if (!named.insert(channel).second)
        throw table.error("views",
                          fmt::format("the channel \"{}\" is named twice; once was expected", channel));
    }
    views.push_back({.along_first = pair[0], .along_second = pair[1]});
  }
  if (views.empty())
    throw table.error("views", "the list is empty; one pair of channels or more was expected");
  return views;
}

PredictionConfig read(const TomlTable& root) {
  PredictionConfig config;
  if (!root.has("prediction")) return config;
  const TomlTable table = root.table("prediction");
  table.expect_keys(
      {"span", "window", "ahead", "stride", "left_out", "fitted", "folds", "hidden", "mixture", "views"});
  config.span = table.optional_positive(table.renamed("span", "window"), "s");
  config.ahead = table.optional_positive("ahead", "s");
  config.stride = table.optional_positive("stride", "s");
  config.left_out = read_choice(table, "left_out");
  config.fitted = read_choice(table, "fitted");
  if (table.has("mixture")) config.mixture = table.boolean("mixture");
  config.views = read_views(table, config.mixture);
  config.hidden = table.optional_strings("hidden").value_or(std::vector<std::string>{});
  if (!table.has("folds")) return config;
  if (!config.left_out.empty())
    throw table.error("folds", "stands beside `left_out`; with folds, every capture is left out once");
  config.folds = read_folds(table);
  return config;
}

/// The text of a label; empty where the capture has none.
std::optional<std::string> label_of(const Capture& capture, const std::string& label) {
  if (const auto found = capture.labels.find(label); found != capture.labels.end()) return found->second;
  if (label == "id") return capture.id;
  if (label == "file") return std::filesystem::path(capture.file).stem().string();
  return {};
}

bool is_chosen(const Capture& capture, const LabelChoice& choice) {
  return std::ranges::all_of(choice, [&](const auto& entry) {
    const std::optional<std::string> text = label_of(capture, entry.first);
    return text && std::ranges::count(entry.second, *text) > 0;
  });
}

/// A text that no capture has is a mistake.
void check(std::span<const Capture> captures, const std::string& key, const LabelChoice& choice) {
  for (const auto& [label, texts] : choice) {
    std::vector<std::string> known;
    for (const Capture& capture : captures) {
      if (const auto text = label_of(capture, label)) known.push_back(*text);
    }
    if (known.empty())
      throw ArgumentError(fmt::format("prediction.{}: no capture has a label \"{}\"", key, label));
    for (const std::string& text : texts) {
      if (std::ranges::count(known, text) > 0) continue;
      throw ArgumentError(fmt::format("prediction.{}: no capture has \"{}\" as its label \"{}\"{}", key, text,
                                      label, suggestion(text, known)));
    }
  }
}

}  // namespace

PredictionConfig read_prediction_config(const std::filesystem::path& path) {
  return read(TomlTable::read(path, "a config of a fit"));
}

PredictionConfig parse_prediction_config(std::string_view text, const std::string& name) {
  return read(TomlTable::parse(text, name, "a config of a fit"));
}

CaptureSplit split(std::span<const Capture> captures, const PredictionConfig& config) {
  check(captures, "fitted", config.fitted);
  check(captures, "left_out", config.left_out);
  CaptureSplit result;
  for (const Capture& capture : captures) {
    const bool is_left_out = !config.left_out.empty() && is_chosen(capture, config.left_out);
    const bool is_fitted = config.fitted.empty() ? !is_left_out : is_chosen(capture, config.fitted);
    if (is_left_out && is_fitted) {
      throw ArgumentError(
          fmt::format("prediction: capture \"{}\" is fitted as well as left out; one of the two was expected",
                      capture.id));
    }
    if (is_fitted) result.fitted.push_back(capture);
    if (is_left_out) result.left_out.push_back(capture);
  }
  return result;
}

}  // namespace samara::identification
