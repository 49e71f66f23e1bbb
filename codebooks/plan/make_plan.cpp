#include "samara/codebooks/plan/make_plan.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/model/model_file.h"

namespace samara::codebooks {

namespace {

std::string box_text(const BoxEntry& entry) {
  std::string text = fmt::format("range = [{}, {}]", entry.lower, entry.upper);
  if (entry.nodes) text += fmt::format(", nodes = {}", *entry.nodes);
  if (entry.basis != pgd::Basis::chebyshev) text += fmt::format(", basis = \"{}\"", to_string(entry.basis));
  if (entry.transform != pgd::Transform::none)
    text += fmt::format(", transform = \"{}\"", to_string(entry.transform));
  return text;
}

/// Checks are those of a plan in a file, and the codebook keeps a text from which it can be built again.
std::string plan_text(const models::ParametricModel& model, const BuildRequest& request) {
  std::string text = fmt::format("model = {}\n", quoted_toml(model.model().info().name));
  if (!request.title.empty()) text += fmt::format("title = {}\n", quoted_toml(request.title));
  text += "[fixed]\n";
  for (const auto& [name, value] : model.fixed()) text += fmt::format("{} = {}\n", quoted_toml(name), value);
  text += "[box]\n";
  for (const BoxEntry& entry : request.box)
    text += fmt::format("{} = {{ {} }}\n", quoted_toml(entry.name), box_text(entry));
  text += fmt::format("[time]\nend = {}\n[tolerance]\nrelative = {}\n", request.end, request.relative);
  if (request.assurance) text += fmt::format("assurance = {}\n", *request.assurance);
  if (!request.absolute.empty()) text += "[tolerance.absolute]\n";
  for (const auto& [name, value] : request.absolute)
    text += fmt::format("{} = {}\n", quoted_toml(name), value);
  const BuildRequest::Builder& builder = request.builder;
  text += fmt::format(
      "[builder]\nkind = {}\nstrategy = {}\nmax_cells = {}\nmax_calls = {}\nthreads = {}\n"
      "seed = {}\n",
      quoted_toml(builder.kind), quoted_toml(builder.strategy), builder.max_cells, builder.max_calls,
      builder.threads, builder.seed);
  for (const auto& [key, value] : {std::pair{"max_nodes", builder.max_nodes},
                                   {"max_rank", builder.max_rank},
                                   {"guards", builder.guards}}) {
    if (value) text += fmt::format("{} = {}\n", key, *value);
  }
  return text;
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
