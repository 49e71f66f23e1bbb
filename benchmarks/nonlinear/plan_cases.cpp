// Every strategy that a plan may name, from the plan to the certified codebook, saved and queried.
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "problems.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"

namespace samara::benchmarks {

namespace {

/// With the tolerance that it is documented to reach.
struct NamedStrategy {
  const char* name;
  double tolerance;
};

constexpr NamedStrategy kStrategies[] = {
    {"enrichment", 1e-2}, {"decoupling", 1e-3},  {"piecewise_linear", 2e-2}, {"asymptotic", 1e-3},
    {"polynomial", 1e-3}, {"incremental", 1e-3}, {"empirical", 1e-3},        {"cross", 1e-3}};

/// (6.22) over its initial values to t = 0.8.
codebooks::Plan triple_plan(double tolerance) {
  return codebooks::parse_plan(
      fmt::format("model = 'coupled_triple'\n[box]\n'u1(0)' = [0, 1]\n'u2(0)' = [0, 1]\n'u3(0)' = [0, 1]\n"
                  "[time]\nend = 0.8\n[tolerance]\nrelative = {}\n",
                  tolerance),
      "triple.toml");
}

Eigen::VectorXd values_at_middle(const codebooks::Codebook& book) {
  codebooks::Query query(book);
  std::vector<double> x;
  for (const auto& coordinate : book.coordinates()) x.push_back(0.5 * (coordinate.lower + coordinate.upper));
  Eigen::VectorXd values(book.output_count());
  query.values(x, values);
  return values;
}

/// By how much answers change when the codebook is stored and read.
double change_by_storing(const codebooks::Codebook& book) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "samara_plan_case.h5";
  codebooks::save(book, file);
  const codebooks::Codebook read = codebooks::load(file);
  std::filesystem::remove(file);
  return (values_at_middle(read) - values_at_middle(book)).cwiseAbs().maxCoeff();
}

void run_plan(const std::string& name, const char* suffix, codebooks::Plan plan,
              const NamedStrategy& strategy) {
  plan.builder.kind = "pgd";
  plan.builder.strategy = strategy.name;
  const codebooks::BuildResult result = codebooks::build(plan);
  print({kNonlinear, name, fmt::format("certificate_max{}", suffix), result.book.certificate()->max_error});
  print({kNonlinear, name, fmt::format("met{}", suffix), result.met ? 1.0 : 0.0});
  print({kNonlinear, name, fmt::format("time{}", suffix), result.book.provenance().build_seconds, "s"});
  print({kNonlinear, name, fmt::format("change_by_storing{}", suffix), change_by_storing(result.book)});
}

}  // namespace

void run_plans(const Options& options) {
  for (const NamedStrategy& strategy : kStrategies) {
    const std::string name = fmt::format("plan_{}", strategy.name);
    if (!options.wants(name)) continue;
    run_plan(name, "", plate_plan(3, 2.0, strategy.tolerance), strategy);
    run_plan(name, "_products", triple_plan(strategy.tolerance), strategy);
  }
}

}  // namespace samara::benchmarks
