#include "samara/codebooks/plan/plan_builder.h"

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "samara/pgd/nonlinear/march.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

std::int64_t integer_in(const TomlTable& table, const std::string& key, std::int64_t fallback,
                        std::int64_t lower, std::int64_t upper) {
  const std::int64_t value = table.optional_integer(key).value_or(fallback);
  if (value >= lower && value <= upper) return value;
  throw table.error(key, fmt::format("is {}, expected {} to {}", value, lower, upper));
}

std::optional<int> optional_integer_in(const TomlTable& table, const std::string& key, std::int64_t lower,
                                       std::int64_t upper) {
  if (!table.has(key)) return std::nullopt;
  return static_cast<int>(integer_in(table, key, lower, lower, upper));
}

/// Fields are solved by enrichment, which counts no evaluations and does not split the box.
void check_builder_fits_field(const TomlTable& root, const Plan& plan) {
  const BuildRequest::Builder& builder = plan.builder;
  const auto refuse = [&](const char* key, const std::string& is, const char* why) {
    throw root.table("builder").error(key, fmt::format("is {}, but {}", is, why));
  };
  if (builder.kind == "sampling")
    refuse("kind", "\"sampling\"", "a field has no trajectories to sample: expected \"pgd\" or \"auto\"");
  if (builder.strategy != "auto" && builder.strategy != "enrichment") {
    refuse("strategy", fmt::format("\"{}\"", builder.strategy),
           "a field is solved by enrichment: expected \"enrichment\" or \"auto\"");
  }
  if (builder.max_cells != 1)
    refuse("max_cells", std::to_string(builder.max_cells), "the box of a field is never split");
  if (builder.max_calls != 0) {
    refuse("max_calls", std::to_string(builder.max_calls),
           "a field is solved without evaluations that could be counted");
  }
  for (const auto& [key, value] : {std::pair{"max_nodes", builder.max_nodes},
                                   {"max_rank", builder.max_rank},
                                   {"guards", builder.guards}}) {
    if (value) refuse(key, std::to_string(*value), "the builder of fields chooses that by itself");
  }
  for (const BoxEntry& entry : plan.box) {
    if (entry.basis == pgd::Basis::fourier)
      throw root.table("box").error(entry.name,
                                    "has the basis \"fourier\", but a field has no period in a parameter");
  }
}

/// Sampling finds nodes by itself, on Chebyshev axes. Commands can only be sampled.
void check_builder_fits(const TomlTable& root, const Plan& plan) {
  if (plan.field != nullptr) return check_builder_fits_field(root, plan);
  if (plan.command && plan.builder.kind == "pgd") {
    throw root.table("builder").error(
        "kind", "is \"pgd\", which solves the equations of a model: a command can only be sampled");
  }
  const bool by_steps = plan.builder.strategy == "steps";
  if (by_steps && (plan.builder.kind != "sampling" || plan.command)) {
    throw root.table("builder").error(
        "strategy", "is \"steps\", which is one of the builder \"sampling\", of the trajectories of a model");
  }
  if (plan.builder.kind != "sampling" && !plan.command) return;
  if (plan.builder.strategy != "auto" && !by_steps) {
    throw root.table("builder").error(
        "strategy", fmt::format("is \"{}\", which is one of the builder \"pgd\", not of \"sampling\"",
                                plan.builder.strategy));
  }
  if (plan.builder.max_cells != 1) {
    throw root.table("builder").error(
        "max_cells", fmt::format("is {}, but the builder of kind \"sampling\" never splits the box",
                                 plan.builder.max_cells));
  }
  if (plan.builder.max_nodes && !by_steps && *plan.builder.max_nodes > pgd::kMostLejaPoints) {
    throw root.table("builder").error("max_nodes",
                                      fmt::format("is {}, expected at most {} of the builder \"sampling\"",
                                                  *plan.builder.max_nodes, pgd::kMostLejaPoints));
  }
  for (const BoxEntry& entry : plan.box) {
    if (!entry.prescribes_axis()) continue;
    throw root.table("box").error(
        entry.name, fmt::format("prescribes {}, but the builder of kind \"sampling\" chooses that by itself",
                                entry.nodes ? "nodes" : "a basis"));
  }
}

}  // namespace

void read_builder(const TomlTable& root, Plan& plan) {
  const auto table = root.optional_table("builder");
  if (!table) return check_builder_fits(root, plan);
  table->expect_keys(
      {"kind", "strategy", "max_calls", "max_cells", "max_nodes", "max_rank", "guards", "threads", "seed"});
  plan.builder.kind = table->choice("kind", {"auto", "pgd", "sampling"});
  std::vector<std::string> strategies = {"auto", "newton", "steps"};
  const std::vector<std::string>& named = pgd::strategy_names();
  strategies.insert(strategies.end(), named.begin(), named.end());
  plan.builder.strategy = table->choice("strategy", strategies);
  plan.builder.max_calls = integer_in(*table, "max_calls", 0, 0, 1'000'000'000'000);
  plan.builder.max_cells = static_cast<int>(integer_in(*table, "max_cells", 1, 1, 100'000));
  plan.builder.max_nodes = optional_integer_in(*table, "max_nodes", 7, 1000);
  plan.builder.max_rank = optional_integer_in(*table, "max_rank", 1, 10'000);
  plan.builder.guards = optional_integer_in(*table, "guards", 1, 100'000);
  plan.builder.threads = static_cast<int>(integer_in(*table, "threads", 0, 0, 1024));
  plan.builder.seed = static_cast<std::uint64_t>(integer_in(*table, "seed", 1, 0, INT64_MAX));
  check_builder_fits(root, plan);
}

}  // namespace samara::codebooks
