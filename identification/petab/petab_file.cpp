#include "samara/identification/petab/petab_file.h"

#include <algorithm>
#include <map>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/io/text_file.h"

namespace samara::identification {

namespace {

using PetabPaths = std::vector<std::filesystem::path>;

const std::vector<std::string>& petab_keys() {
  static const std::vector<std::string> keys = {
      "format_version",   "parameter_file",    "problems",   "sbml_files",         "condition_files",
      "observable_files", "measurement_files", "extensions", "visualization_files"};
  return keys;
}

/// Without a comment after it: a # after a blank, or at the beginning.
std::string_view without_comment(std::string_view line) {
  bool in_single = false, in_double = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '\'' && !in_double) in_single = !in_single;
    if (line[k] == '"' && !in_single) in_double = !in_double;
    const bool stands_alone = k == 0 || line[k - 1] == ' ' || line[k - 1] == '\t';
    if (line[k] == '#' && !in_single && !in_double && stands_alone) return line.substr(0, k);
  }
  return line;
}

std::string unquoted(std::string_view text) {
  text = trimmed(text);
  const bool is_quoted =
      text.size() >= 2 && (text.front() == '"' || text.front() == '\'') && text.back() == text.front();
  return std::string(is_quoted ? text.substr(1, text.size() - 2) : text);
}

/// Reads line by line.
class PetabReader {
 public:
  explicit PetabReader(const std::filesystem::path& path) : path_(path) {}

  void take(std::string_view line, int number) {
    line_ = number;
    std::string_view text = trimmed(without_comment(line));
    if (text.empty() || text == "---") return;
    bool begins_problem = false;
    if (text == "-" || text.starts_with("- ")) {
      text = trimmed(text.substr(1));
      if (!is_key(text)) return add(unquoted(text));
      begins_problem = true;
    }
    if (!is_key(text))
      throw error(fmt::format("{} is neither \"key: value\" nor \"- item\"", in_quotes(text)));
    const std::size_t colon = text.find(':');
    key_ = unquoted(text.substr(0, colon));
    if (std::ranges::count(petab_keys(), key_) == 0)
      throw error(fmt::format("the key {} is unknown{}", in_quotes(key_), suggestion(key_, petab_keys())));
    if (begins_problem && ++problems_ > 1) throw error("a second problem begins; one was expected");
    values(trimmed(text.substr(colon + 1)));
  }

  PetabFile finished() {
    line_ = 0;
    PetabFile file;
    file.file = path_;
    if (values_["format_version"] != std::vector<std::string>{"1"})
      throw error(fmt::format("format_version is \"{}\"; 1 was expected",
                              values_["format_version"].empty() ? "" : values_["format_version"].front()));
    if (!values_["extensions"].empty()) throw error("extensions are not read");
    file.parameters = paths("parameter_file", true);
    if (file.parameters.size() > 1) throw error("several parameter files; one was expected");
    file.conditions = paths("condition_files", true);
    file.observables = paths("observable_files", true);
    file.measurements = paths("measurement_files", true);
    file.models = paths("sbml_files", false);
    return file;
  }

 private:
  InputError error(const std::string& sentence) const { return InputError(path_.string(), line_, sentence); }

  static bool is_key(std::string_view text) {
    const std::size_t colon = text.find(':');
    return colon != std::string_view::npos && colon > 0 &&
           (colon + 1 == text.size() || text[colon + 1] == ' ') && text.find_first_of(" \t/\\") > colon;
  }

  void values(std::string_view text) {
    if (text.empty() || text == "{}" || text == "[]") return;
    if (!text.starts_with('[')) return add(unquoted(text));
    if (!text.ends_with(']'))
      throw error("a list in brackets goes over several lines; one line, or \"- item\" was expected");
    text = text.substr(1, text.size() - 2);
    while (!trimmed(text).empty()) {
      const std::size_t comma = std::min(text.find(','), text.size());
      add(unquoted(text.substr(0, comma)));
      text.remove_prefix(std::min(comma + 1, text.size()));
    }
  }

  void add(std::string value) {
    if (key_.empty()) throw error("an item without a key above it");
    if (value.empty()) throw error(fmt::format("an empty item of {}", key_));
    values_[key_].push_back(std::move(value));
  }

  PetabPaths paths(const std::string& key, bool is_needed) {
    PetabPaths paths;
    for (const std::string& name : values_[key]) paths.push_back(path_.parent_path() / name);
    if (is_needed && paths.empty()) throw error(fmt::format("{} is missing", key));
    return paths;
  }

  std::filesystem::path path_;
  std::map<std::string, std::vector<std::string>> values_;
  std::string key_;
  int line_ = 0;
  int problems_ = 0;
};

}  // namespace

std::vector<std::filesystem::path> PetabFile::files() const {
  PetabPaths all = {file};
  for (const PetabPaths* some : {&parameters, &conditions, &observables, &measurements})
    all.insert(all.end(), some->begin(), some->end());
  return all;
}

bool is_petab_file(const std::filesystem::path& path) {
  const std::string ending = ending_of(path);
  return ending == ".yaml" || ending == ".yml";
}

PetabFile read_petab_file(const std::filesystem::path& path) {
  const std::string text = io::read_text_file(path, {.expected = "a PEtab problem"});
  PetabReader reader(path);
  std::string_view rest = text;
  for (int number = 1; !rest.empty(); ++number) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    std::string_view line = rest.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    reader.take(line, number);
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return reader.finished();
}

}  // namespace samara::identification
