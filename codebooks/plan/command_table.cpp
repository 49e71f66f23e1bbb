#include "samara/codebooks/plan/command_table.h"

#include <algorithm>
#include <cctype>
#include <set>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/units.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

/// Names stand in files, on command lines ("name=value") and in heads of columns.
void check_new_name(const TomlTable& table, const std::string& name, std::set<std::string>& taken) {
  const auto fits = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
  const bool is_name = !name.empty() && std::isdigit(static_cast<unsigned char>(name.front())) == 0 &&
                       std::all_of(name.begin(), name.end(), fits);
  if (!is_name) throw table.error(name, "is no name, expected letters, digits and underscores");
  if (!taken.insert(name).second)
    throw table.error(name, "is taken by another input or output, or by the time t");
}

void check_unit(const TomlTable& table, const std::string& name, const std::string& text) {
  Unit unit;
  try {
    unit = parse_unit(text);
  } catch (const ArgumentError& error) {
    throw table.error(name, error.what());
  }
  if (unit.factor() == 1.0) return;
  throw table.error(
      name, fmt::format("has the unit \"{}\", expected one of the SI, here \"{}\": codebooks are in SI, and "
                        "numbers go to the program as they are",
                        text, to_string(unit.dimension)));
}

std::vector<CommandQuantity> read_quantities(const TomlTable& command, const std::string& key,
                                             std::set<std::string>& taken) {
  const TomlTable table = command.table(key);
  std::vector<CommandQuantity> quantities;
  for (const std::string& name : table.keys()) {
    check_new_name(table, name, taken);
    quantities.push_back({name, table.string(name)});
    check_unit(table, name, quantities.back().unit);
  }
  if (quantities.empty())
    throw command.error(key, "is empty, expected names and their units, as in { drag = \"N\" }");
  return quantities;
}

int count_in(const TomlTable& table, const std::string& key, int fallback, int lower, int upper) {
  const std::int64_t value = table.optional_integer(key).value_or(fallback);
  if (value >= lower && value <= upper) return static_cast<int>(value);
  throw table.error(key, fmt::format("is {}, expected {} to {}", value, lower, upper));
}

}  // namespace

PlannedCommand read_command(const TomlTable& table) {
  if (table.has("certificate_points")) {
    throw table.error(
        "certificate_points",
        "is no key any more: [tolerance] assurance = 0.99 asks for 300 points, 3/(1 - assurance)");
  }
  table.expect_keys({"run", "inputs", "outputs", "timeout", "batch", "persistent"});
  PlannedCommand command;
  command.run = table.strings("run");
  if (command.run.empty() || command.run.front().empty())
    throw table.error("run", "is empty, expected a program and its arguments");
  for (const std::string& word : command.run) {
    if (word.find('\0') != std::string::npos)
      throw table.error("run", "has a zero byte in it, which no program can be given");
  }
  std::set<std::string> taken = {"t"};
  command.inputs = read_quantities(table, "inputs", taken);
  command.outputs = read_quantities(table, "outputs", taken);
  command.timeout = table.optional_quantity("timeout", "s").value_or(command.timeout);
  constexpr double kLongest = 1e7;  // s
  if (!(command.timeout > 0.0 && command.timeout <= kLongest)) {
    throw table.error("timeout",
                      fmt::format("is {} s, expected more than 0 and at most {}", command.timeout, kLongest));
  }
  command.persistent = table.optional_boolean("persistent").value_or(command.persistent);
  command.batch = count_in(table, "batch", command.batch, 1, 1'000'000);
  return command;
}

}  // namespace samara::codebooks
