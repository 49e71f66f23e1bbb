#include "samara/codebooks/plan/make_plan.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/plan/box_table.h"
#include "samara/codebooks/plan/builder_table.h"
#include "samara/codebooks/plan/tolerance_table.h"

namespace samara::codebooks {

namespace {

/// Checks are those of a plan in a file, and the codebook keeps a text from which it can be built again.
std::string plan_text(const models::ParametricModel& model, const BuildRequest& request) {
  std::string text = fmt::format("model = {}\n", quoted_toml(model.model().info().name));
  if (!request.title.empty()) text += fmt::format("title = {}\n", quoted_toml(request.title));
  text += "[fixed]\n";
  for (const auto& [name, value] : model.fixed()) text += fmt::format("{} = {}\n", quoted_toml(name), value);
  text += "[box]\n";
  for (const BoxEntry& entry : request.box) {
    text +=
        fmt::format("{} = {}\n", quoted_toml(entry.name),
                    box_entry_text(entry, fmt::format("{}", entry.lower), fmt::format("{}", entry.upper)));
  }
  text += fmt::format("[time]\nend = {}\n", request.end);
  return text + tolerance_text(request) + builder_text(request.builder);
}

}  // namespace

Plan make_plan(const models::ParametricModel& model, const BuildRequest& request) {
  for (const models::FreeCoordinate& free : model.free()) {
    if (std::ranges::count(request.box, free.name, &BoxEntry::name) == 1) continue;
    throw ArgumentError(
        fmt::format("the free coordinate \"{}\" has no interval in the box, or several; one was "
                    "expected",
                    free.name));
  }
  for (const BoxEntry& entry : request.box) {
    if (std::ranges::count(model.free(), entry.name, &models::FreeCoordinate::name) == 1) continue;
    throw ArgumentError(fmt::format(
        "the box has an interval of \"{}\", which is no free coordinate of the model", entry.name));
  }
  try {
    return parse_plan(plan_text(model, request), "the build request", model.shared_model());
  } catch (const InputError& error) {
    throw ArgumentError(error.what());
  }
}

}  // namespace samara::codebooks
