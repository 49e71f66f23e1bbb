#include "samara/codebooks/plan/body_table.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <string>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/units.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

models::BodyDescription read_description(const TomlTable& root, const TomlTable& table) {
  table.expect_keys({"shape", "mesh", "size", "unit", "density", "fluid_density", "added_mass"});
  models::BodyDescription description;
  if (table.has("shape") == table.has("mesh"))
    throw root.error("body", table.has("mesh") ? "has a shape and a mesh, expected one of the two"
                                               : "has neither a shape nor a mesh, expected one of them");
  if (table.has("mesh")) {
    description.shape = (std::filesystem::path(table.file()).parent_path() / table.string("mesh")).string();
    try {
      description.unit = quantity_to_si("1 " + table.string("unit"), "m");
    } catch (const ArgumentError& error) {
      throw table.error("unit", error.what());
    }
  } else {
    description.shape = table.choice("shape", {"ellipsoid", "disc", "plate"});
    description.sizes = table.quantities("size", "m");
  }
  if (table.has("mesh") && table.has("size"))
    throw table.error("size", "is of a shape only: a mesh has its own");
  if (!table.has("mesh") && table.has("unit"))
    throw table.error("unit", "is of a mesh only: what one unit of its file means");
  description.density = table.quantity("density", "kg/m^3");
  description.fluid_density = table.quantity("fluid_density", "kg/m^3");
  if (table.has("added_mass")) description.added_mass = table.choice("added_mass", {"panels", "ellipsoid"});
  return description;
}

}  // namespace

void read_body(const TomlTable& root, const BodyReader& body_reader, Plan& plan) {
  const auto table = root.optional_table("body");
  if (!table) return;
  if (plan.model != "kirchhoff_body")
    throw root.error(
        "body", fmt::format("is for the model \"kirchhoff_body\", the plan is one of {}",
                            plan.command ? std::string("a command") : fmt::format("\"{}\"", plan.model)));
  if (!body_reader) throw root.error("body", "cannot be read: this program knows no bodies");
  const models::BodyDescription description = read_description(root, *table);
  std::map<std::string, double> parameters;
  try {
    parameters = body_reader(description);
  } catch (const ArgumentError& error) {
    throw root.error("body", error.what());
  }
  for (const auto& [name, value] : parameters) {
    const bool is_free =
        std::ranges::any_of(plan.box, [&name = name](const BoxEntry& entry) { return entry.name == name; });
    if (is_free || !plan.fixed.emplace(name, value).second) continue;
    plan.of_body[name] = value;
  }
}

}  // namespace samara::codebooks
