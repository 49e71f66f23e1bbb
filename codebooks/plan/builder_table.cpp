#include "samara/codebooks/plan/builder_table.h"

#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include <fmt/format.h>

#include "samara/codebooks/model/model_file.h"
#include "samara/pgd/nonlinear/march.h"
#include "samara/pgd/sampling/leja.h"

namespace samara::codebooks {

namespace {

using io::TomlTable;

using Builder = BuildRequest::Builder;

/// A key with a whole number, and where it stands; one that is optional is the builder's own choice where it is left
/// out.
struct CountKey {
  std::string key;
  std::int64_t lower, upper;
  std::variant<int Builder::*, long Builder::*, std::uint64_t Builder::*, std::optional<int> Builder::*>
      member;

  bool is_optional() const { return std::holds_alternative<std::optional<int> Builder::*>(member); }
};

const std::vector<CountKey>& count_keys() {
  static const std::vector<CountKey> keys = {{"max_cells", 1, 100'000, &Builder::max_cells},
                                             {"max_calls", 0, 1'000'000'000'000, &Builder::max_calls},
                                             {"threads", 0, 1024, &Builder::threads},
                                             {"seed", 0, INT64_MAX, &Builder::seed},
                                             {"max_nodes", 7, 1000, &Builder::max_nodes},
                                             {"max_rank", 1, 10'000, &Builder::max_rank},
                                             {"guards", 1, 100'000, &Builder::guards}};
  return keys;
}

void read_count(const TomlTable& table, const CountKey& key, Builder& builder) {
  const auto value = table.optional_integer(key.key);
  if (!value) return;
  if (*value < key.lower || *value > key.upper)
    throw table.error(key.key, fmt::format("is {}, expected {} to {}", *value, key.lower, key.upper));
  const auto assign = [&]<class T>(T Builder::*member) {
    if constexpr (std::is_same_v<T, std::optional<int>>) {
      builder.*member = static_cast<int>(*value);
    } else {
      builder.*member = static_cast<T>(*value);
    }
  };
  std::visit(assign, key.member);
}

/// None where it is left out.
std::optional<std::string> count_text(const CountKey& key, const Builder& builder) {
  const auto text = [&]<class T>(T Builder::*member) -> std::optional<std::string> {
    if constexpr (std::is_same_v<T, std::optional<int>>) {
      if (!(builder.*member)) return std::nullopt;
      return std::to_string(*(builder.*member));
    } else {
      return std::to_string(builder.*member);
    }
  };
  return std::visit(text, key.member);
}

/// Fields are solved by enrichment, which counts no evaluations and does not split the box.
void check_builder_fits_field(const TomlTable& root, const Plan& plan) {
  const BuildRequest::Builder& builder = plan.builder;
  const auto refuse = [&](const std::string& key, const std::string& is, const char* why) {
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
  for (const CountKey& key : count_keys()) {
    const auto value = count_text(key, builder);
    if (key.is_optional() && value) refuse(key.key, *value, "the builder of fields chooses that by itself");
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
  std::vector<std::string> known = {"kind", "strategy"};
  for (const CountKey& key : count_keys()) known.push_back(key.key);
  table->expect_keys(known);
  plan.builder.kind = table->choice("kind", {"auto", "pgd", "sampling"});
  std::vector<std::string> strategies = {"auto", "newton", "steps"};
  const std::vector<std::string>& named = pgd::strategy_names();
  strategies.insert(strategies.end(), named.begin(), named.end());
  plan.builder.strategy = table->choice("strategy", strategies);
  for (const CountKey& key : count_keys()) read_count(*table, key, plan.builder);
  check_builder_fits(root, plan);
}

std::string builder_text(const BuildRequest::Builder& builder) {
  std::string text = fmt::format("[builder]\nkind = {}\nstrategy = {}\n", quoted_toml(builder.kind),
                                 quoted_toml(builder.strategy));
  for (const CountKey& key : count_keys())
    if (const auto value = count_text(key, builder)) text += fmt::format("{} = {}\n", key.key, *value);
  return text;
}

}  // namespace samara::codebooks
