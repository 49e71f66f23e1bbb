#include "samara/codebooks/plan/plan_changes.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/text.h"
#include "samara/codebooks/plan/box_table.h"
#include "samara/io/toml_document.h"
#include "samara/io/toml_edit.h"

namespace samara::codebooks {

namespace {

/// A number as it is, anything else as a string.
std::string as_toml(const std::string& value) {
  const NumberPrefix number = read_number(value);
  const bool is_plain = number.problem == NumberProblem::none && number.length == value.size();
  // TOML wants a digit on both sides of the point.
  if (is_plain) return fmt::format("{}", number.value);
  std::string text = "\"";
  for (const char c : value) {
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + "\"";
}

/// The interval of an entry that has other keys, too.
bool has_table(const std::string& text, const std::string& name, const std::string& key) {
  const io::TomlTable root = io::TomlTable::parse(text, name, "a plan of a codebook");
  const auto box = root.optional_table("box");
  return box && box->has(key) && box->is_table(key);
}

std::string interval(const PlanChanges::Coordinate& c) {
  return fmt::format("[{}, {}]", as_toml(c.value), as_toml(c.upper));
}

std::vector<io::TomlChange> changes_of(const Plan& plan, const std::string& text,
                                       const PlanChanges& changes) {
  std::vector<io::TomlChange> edits;
  for (const PlanChanges::Coordinate& c : changes.coordinates) {
    const auto entry = std::ranges::find(plan.box, c.name, &BoxEntry::name);
    if (c.upper.empty()) {
      if (entry != plan.box.end()) edits.push_back({"box", c.name, ""});
      edits.push_back({"fixed", c.name, as_toml(c.value)});
      continue;
    }
    if (plan.fixed.contains(c.name) && !plan.of_body.contains(c.name)) edits.push_back({"fixed", c.name, ""});
    const bool in_table = entry != plan.box.end() && has_table(text, plan.source, c.name);
    edits.push_back(
        {"box", c.name, in_table ? box_entry_text(*entry, as_toml(c.value), as_toml(c.upper)) : interval(c)});
  }
  if (changes.relative) edits.push_back({"tolerance", "relative", fmt::format("{}", *changes.relative)});
  if (changes.threads) edits.push_back({"builder", "threads", std::to_string(*changes.threads)});
  return edits;
}

}  // namespace

Plan changed_plan(const std::string& text, const std::string& name, const PlanChanges& changes,
                  const BodyReader& body_reader) {
  const Plan plan = parse_plan(text, name, {}, body_reader);
  if (changes.empty()) return plan;
  const std::string changed = io::changed_toml(text, name, changes_of(plan, text, changes));
  try {
    return parse_plan(changed, name, {}, body_reader);
  } catch (const InputError& error) {
    throw ArgumentError(fmt::format("the plan with what is set in the call: {}", error.what()));
  }
}

}  // namespace samara::codebooks
