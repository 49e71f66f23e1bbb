#include "samara/io/toml_document.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <toml++/toml.h>

#include "samara/base/limits.h"
#include "samara/base/names.h"
#include "samara/base/number_text.h"
#include "samara/base/text.h"
#include "samara/base/unit_labels.h"
#include "samara/base/units.h"
#include "samara/io/text_file.h"

namespace samara::io {

namespace {

constexpr std::string_view kAnyToml = "TOML";  // the default of `expected`

}  // namespace

struct TomlTable::Node {
  std::shared_ptr<const toml::table> document;  // keeps `table` alive
  const toml::table* table = nullptr;
  std::string file;
  std::string path;
  std::string expected;  // what the file should be

  bool is_root() const { return table == document.get(); }
  const toml::node* find(const std::string& key) const { return table->get(key); }
  int line_of(const toml::node& value) const { return static_cast<int>(value.source().begin.line); }
  int line() const { return is_root() ? 0 : line_of(*table); }
  std::shared_ptr<const Node> below(const toml::table& child, const std::string& name) const;
  InputError error(int line_number, const std::string& key, const std::string& sentence) const;
  const toml::node& require(const std::string& key) const;
};

namespace {

/// A key as it must be written in TOML.
std::string written(std::string_view key) {
  const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
  return bare ? std::string(key) : in_quotes(key);
}

/// What a message says was found.
std::string description(const toml::node& value) {
  switch (value.type()) {
    case toml::node_type::string:
      return "the string " + in_quotes(value.as_string()->get());
    case toml::node_type::integer:
      return "the integer " + std::to_string(value.as_integer()->get());
    case toml::node_type::floating_point:
      return "the number " + number_text(value.as_floating_point()->get());
    case toml::node_type::boolean:
      return value.as_boolean()->get() ? "the boolean true" : "the boolean false";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::table:
      return "a table";
    default:
      return "a date or a time";
  }
}

/// @throws ArgumentError, as all conversions do: why a value could not be converted. The caller adds the place.
[[noreturn]] void expected(const std::string& what, const toml::node& found) {
  throw ArgumentError("expected " + what + ", found " + description(found));
}

std::string as_string(const toml::node& value) {
  if (!value.is_string()) expected("a string", value);
  return value.as_string()->get();
}

/// A number to calculate with.
double in_size(double number) {
  const double size = std::abs(number);
  if (!(size <= kLargestInput))
    throw ArgumentError("has the number " + number_text(number) + ", expected at most " +
                        number_text(kLargestInput) + " in size");
  if (size > 0.0 && size < kSmallestInput)
    throw ArgumentError("has the number " + number_text(number) + ", expected at least " +
                        number_text(kSmallestInput) + " in size, or 0");
  return number;
}

double as_number(const toml::node& value) {
  if (value.is_integer()) return static_cast<double>(value.as_integer()->get());
  if (!value.is_floating_point()) expected("a number", value);
  const double number = value.as_floating_point()->get();
  if (!std::isfinite(number)) expected("a finite number", value);
  return in_size(number);
}

double as_quantity(const toml::node& value, std::string_view unit,
                   double (*to_si)(std::string_view, std::string_view) = quantity_to_si) {
  if (!value.is_string()) {
    if (!value.is_number()) expected("a number, or a string with a unit", value);
    return as_number(value);
  }
  return in_size(to_si(value.as_string()->get(), unit));
}

template <typename Convert>
auto as_list(const toml::node& value, const std::string& of_what, const Convert& convert) {
  if (!value.is_array()) expected("an array of " + of_what, value);
  std::vector<decltype(convert(value))> list;
  for (const toml::node& element : *value.as_array()) {
    try {
      list.push_back(convert(element));
    } catch (const ArgumentError& refusal) {
      throw ArgumentError("element " + std::to_string(list.size()) + ": " + refusal.what());
    }
  }
  return list;
}

/// The value of a required key, with a refusal turned into a located error.
template <typename Node, typename Convert>
auto converted(const Node& node, const std::string& key, const Convert& convert) {
  const toml::node& value = node.require(key);
  try {
    return convert(value);
  } catch (const ArgumentError& refusal) {
    throw node.error(node.line_of(value), key, refusal.what());
  }
}

double more_than_zero(const TomlTable& table, const std::string& key, double value, std::string_view unit) {
  if (std::isfinite(value) && value > 0.0) return value;
  throw table.error(key, "is " + number_text(value) + unit_suffix(unit) + "; more than 0 was expected");
}

/// Calls `get` if the key is there.
template <typename Get>
auto if_present(bool present, const Get& get) -> std::optional<decltype(get())> {
  if (!present) return std::nullopt;
  return get();
}

std::string with_full_stop_removed(std::string_view sentence) {
  std::string one_line(sentence);
  std::replace(one_line.begin(), one_line.end(), '\n', ' ');
  while (!one_line.empty() && (one_line.back() == '.' || one_line.back() == ' ')) one_line.pop_back();
  return one_line;
}

/// toml++ bounds the depth of arrays, but not that of dotted keys, which would exhaust the stack.
void check_depth_of_keys(std::string_view text, const std::string& name) {
  constexpr int kMostDots = 200;
  int line = 1;
  int dots = 0;
  char quote = 0;  // of the string we are in, or 0
  for (const char c : text) {
    if (c == '\n') ++line;
    if (quote != 0 && c != '\n') {
      if (c == quote) quote = 0;
      continue;
    }
    quote = c == '"' || c == '\'' ? c : '\0';
    if (c == '.') ++dots;
    if (dots > kMostDots) throw InputError(name, line, "a key has more than 200 dots");
    if (std::string_view("=,[]{}#\n").find(c) != std::string_view::npos) dots = 0;
  }
}

/// What a text is that is no TOML, where its beginning shows it.
std::string kind_without_keys(std::string_view text) {
  std::array<std::string_view, 2> lines;
  std::size_t count = 0;
  while (!text.empty() && count < lines.size()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (!line.empty() && !line.starts_with('#')) lines[count++] = line;
  }
  if (lines[0].starts_with('{')) return "JSON";
  if (lines[0].starts_with('<')) return "a page or a picture (HTML, XML)";
  if (lines[0].find('=') != std::string_view::npos || lines[0].starts_with('[')) return {};
  for (const char delimiter : {',', ';', '\t'}) {
    const auto cells = std::ranges::count(lines[0], delimiter);
    if (cells > 0 && std::ranges::count(lines[1], delimiter) == cells) return "a table";
  }
  return {};
}

/// Keys by which whole files of one kind are told from those of others.
struct KindOfFile {
  std::string_view name;
  std::array<std::string_view, 6> keys;
};
constexpr std::array<KindOfFile, 8> kKinds = {{
    {"a plan of a codebook", {"time", "builder", "command", "equations"}},
    {"a config of a fit", {"loss", "cluster_by", "noise", "shared", "per_capture", "prediction"}},
    {"a sidecar", {"columns", "group_by", "frame_rate", "scale", "clean", "length_unit"}},
    {"a model", {"states", "rates"}},
    {"a plan of a sweep", {"axes", "releases", "run"}},
    {"a plan of a flow", {"flow"}},
    {"a wind", {"mean", "gusts"}},
    {"a motion to plan", {"release", "landing", "database", "sequence"}},
}};

/// The kind that most of the keys tell of; `expected` where others have no more. Empty where none tells of any.
std::string kind_by_keys(const std::vector<std::string>& keys, const std::string& expected) {
  std::string_view best;
  std::ptrdiff_t most = 0;
  for (const KindOfFile& kind : kKinds) {
    const auto count = std::ranges::count_if(
        keys, [&](const std::string& key) { return std::ranges::count(kind.keys, key) > 0; });
    if (count > most || (count > 0 && count == most && kind.name == expected)) {
      best = kind.name;
      most = count;
    }
  }
  return std::string(best);
}

}  // namespace

std::shared_ptr<const TomlTable::Node> TomlTable::Node::below(const toml::table& child,
                                                              const std::string& name) const {
  const std::string parent = path.empty() ? "" : path.substr(1, path.size() - 2) + ".";
  return std::make_shared<const Node>(Node{document, &child, file, "[" + parent + name + "]", expected});
}

InputError TomlTable::Node::error(int line_number, const std::string& key,
                                  const std::string& sentence) const {
  const std::string table_name = path.empty() ? "" : path + " ";
  return InputError(file, line_number, table_name + written(key) + ": " + sentence);
}

const toml::node& TomlTable::Node::require(const std::string& key) const {
  if (const toml::node* value = find(key)) return *value;
  throw error(line(), key, "the key is missing");
}

TomlTable TomlTable::read(const std::filesystem::path& path, const std::string& expected) {
  return parse(read_text_file(path, {.expected = expected}), path.string(), expected);
}

TomlTable TomlTable::parse(std::string_view text, const std::string& name, const std::string& expected) {
  check_depth_of_keys(text, name);
  try {
    auto document = std::make_shared<const toml::table>(toml::parse(text, name));
    const toml::table* root = document.get();
    return TomlTable(std::make_shared<const Node>(Node{std::move(document), root, name, "", expected}));
  } catch (const toml::parse_error& error) {
    if (const std::string kind = kind_without_keys(text); !kind.empty())
      throw InputError(name, "is " + kind + ", expected " + expected);
    throw InputError(name, static_cast<int>(error.source().begin.line),
                     "not valid TOML: " + with_full_stop_removed(error.description()));
  }
}

const std::string& TomlTable::file() const {
  return node_->file;
}
const std::string& TomlTable::path() const {
  return node_->path;
}

int TomlTable::line(const std::string& key) const {
  const auto entry = node_->table->find(key);
  return entry == node_->table->end() ? node_->line() : static_cast<int>(entry->first.source().begin.line);
}

bool TomlTable::has(const std::string& key) const {
  return node_->find(key) != nullptr;
}

std::string TomlTable::renamed(const std::string& key, const std::string& former) const {
  if (!has(former)) return key;
  if (has(key)) throw error(former, "it is `" + key + "` under its former name; one of the two was expected");
  return former;
}

std::vector<std::string> TomlTable::keys() const {
  std::vector<const toml::key*> entries;
  for (auto&& [key, value] : *node_->table) entries.push_back(&key);
  std::stable_sort(entries.begin(), entries.end(), [](const toml::key* a, const toml::key* b) {
    const toml::source_position& at = a->source().begin;
    const toml::source_position& bt = b->source().begin;
    return std::pair(at.line, at.column) < std::pair(bt.line, bt.column);
  });
  std::vector<std::string> names;
  for (const toml::key* key : entries) names.emplace_back(key->str());
  return names;
}

void TomlTable::expect_keys(const std::vector<std::string>& known) const {
  for (const std::string& key : keys()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      const std::string kind = node_->is_root() ? kind_by_keys(keys(), node_->expected) : "";
      if (!kind.empty() && kind != node_->expected && node_->expected != kAnyToml)
        throw InputError(node_->file, "is " + kind + ", expected " + node_->expected);
      throw error(key, "unknown key" + suggestion(key, known));
    }
  }
}

InputError TomlTable::error(const std::string& key, const std::string& sentence) const {
  return node_->error(line(key), key, sentence);
}

bool TomlTable::is_string(const std::string& key) const {
  return has(key) && node_->find(key)->is_string();
}
bool TomlTable::is_boolean(const std::string& key) const {
  return has(key) && node_->find(key)->is_boolean();
}
bool TomlTable::is_integer(const std::string& key) const {
  return has(key) && node_->find(key)->is_integer();
}
bool TomlTable::is_number(const std::string& key) const {
  return has(key) && node_->find(key)->is_number();
}
bool TomlTable::is_array(const std::string& key) const {
  return has(key) && node_->find(key)->is_array();
}
bool TomlTable::is_table(const std::string& key) const {
  return has(key) && node_->find(key)->is_table();
}

std::string TomlTable::string(const std::string& key) const {
  return converted(*node_, key, as_string);
}

bool TomlTable::boolean(const std::string& key) const {
  return converted(*node_, key, [](const toml::node& value) {
    if (!value.is_boolean()) expected("true or false", value);
    return value.as_boolean()->get();
  });
}

std::int64_t TomlTable::integer(const std::string& key) const {
  return converted(*node_, key, [](const toml::node& value) {
    if (!value.is_integer()) expected("an integer", value);
    return value.as_integer()->get();
  });
}

double TomlTable::number(const std::string& key) const {
  return converted(*node_, key, as_number);
}

double TomlTable::quantity(const std::string& key, std::string_view unit) const {
  return converted(*node_, key, [&](const toml::node& value) { return as_quantity(value, unit); });
}

double TomlTable::difference(const std::string& key, std::string_view unit) const {
  return converted(*node_, key,
                   [&](const toml::node& value) { return as_quantity(value, unit, difference_to_si); });
}

double TomlTable::positive(const std::string& key, std::string_view unit) const {
  return more_than_zero(*this, key, quantity(key, unit), unit);
}

double TomlTable::positive_difference(const std::string& key, std::string_view unit) const {
  return more_than_zero(*this, key, difference(key, unit), unit);
}

std::vector<std::vector<std::string>> TomlTable::string_lists(const std::string& key) const {
  return converted(*node_, key, [](const toml::node& value) {
    return as_list(value, "arrays of strings",
                   [](const toml::node& element) { return as_list(element, "strings", as_string); });
  });
}

std::vector<std::string> TomlTable::strings(const std::string& key) const {
  return converted(*node_, key, [](const toml::node& value) { return as_list(value, "strings", as_string); });
}

std::vector<double> TomlTable::numbers(const std::string& key) const {
  return converted(*node_, key, [](const toml::node& value) { return as_list(value, "numbers", as_number); });
}

std::vector<double> TomlTable::quantities(const std::string& key, std::string_view unit) const {
  return converted(*node_, key, [&](const toml::node& value) {
    return as_list(value, "quantities",
                   [&](const toml::node& element) { return as_quantity(element, unit); });
  });
}

TomlTable TomlTable::table(const std::string& key) const {
  return converted(*node_, key, [&](const toml::node& value) {
    if (!value.is_table()) expected("a table", value);
    return TomlTable(node_->below(*value.as_table(), written(key)));
  });
}

std::vector<TomlTable> TomlTable::tables(const std::string& key) const {
  return converted(*node_, key, [&](const toml::node& value) {
    std::size_t index = 0;
    return as_list(value, "tables", [&](const toml::node& element) {
      if (!element.is_table()) expected("a table", element);
      const std::string name = written(key) + "[" + std::to_string(index++) + "]";
      return TomlTable(node_->below(*element.as_table(), name));
    });
  });
}

std::optional<std::string> TomlTable::optional_string(const std::string& key) const {
  return if_present(has(key), [&] { return string(key); });
}
std::string TomlTable::choice(const std::string& key, const std::vector<std::string>& known) const {
  const std::string value = optional_string(key).value_or(known.front());
  if (std::ranges::find(known, value) != known.end()) return value;
  throw error(key, "is \"" + value + "\"" + suggestion(value, known));
}
std::optional<bool> TomlTable::optional_boolean(const std::string& key) const {
  return if_present(has(key), [&] { return boolean(key); });
}
std::optional<std::int64_t> TomlTable::optional_integer(const std::string& key) const {
  return if_present(has(key), [&] { return integer(key); });
}
std::optional<double> TomlTable::optional_number(const std::string& key) const {
  return if_present(has(key), [&] { return number(key); });
}
std::optional<double> TomlTable::optional_quantity(const std::string& key, std::string_view unit) const {
  return if_present(has(key), [&] { return quantity(key, unit); });
}
std::optional<double> TomlTable::optional_positive(const std::string& key, std::string_view unit) const {
  return if_present(has(key), [&] { return positive(key, unit); });
}
std::optional<std::vector<std::string>> TomlTable::optional_strings(const std::string& key) const {
  return if_present(has(key), [&] { return strings(key); });
}
std::optional<std::vector<double>> TomlTable::optional_numbers(const std::string& key) const {
  return if_present(has(key), [&] { return numbers(key); });
}
std::optional<std::vector<double>> TomlTable::optional_quantities(const std::string& key,
                                                                  std::string_view unit) const {
  return if_present(has(key), [&] { return quantities(key, unit); });
}
std::optional<TomlTable> TomlTable::optional_table(const std::string& key) const {
  return if_present(has(key), [&] { return table(key); });
}
std::optional<std::vector<TomlTable>> TomlTable::optional_tables(const std::string& key) const {
  return if_present(has(key), [&] { return tables(key); });
}

}  // namespace samara::io
