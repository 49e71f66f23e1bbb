// What a term costs as dimensions and nodes grow, and which sparse solver is fastest.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "examples/linear_engine/disc.h"
#include "examples/linear_engine/poisson.h"
#include "samara/base/errors.h"
#include "samara/pgd/linear/enrichment.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

constexpr int kTerms = 6;

/// The same work for every size: as many terms, iterations and sweeps.
EnrichOptions equal_work() {
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = 1e-15;
  options.residual = ResidualKind::fast;
  options.max_rank = kTerms;
  options.stagnation_terms = kTerms;
  options.max_fixed_point_iterations = 5;
  options.fixed_point_tolerance = 1e-15;
  return options;
}

/// Slope of log y against log x, by least squares.
double slope(const std::vector<double>& x, const std::vector<double>& y) {
  const auto n = static_cast<double>(x.size());
  double sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double a = std::log(x[i]);
    const double b = std::log(y[i]);
    sx += a, sy += b, sxx += a * a, sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

double seconds_per_term(const LinearProblem& problem) {
  double best = 1e300;
  for (int repeat = 0; repeat < 3; ++repeat) best = std::min(best, enrich(problem, equal_work()).seconds);
  return best / kTerms;
}

/// Peak memory in bytes of a process that solves on so many nodes: a new one (--memory N), because this one
/// keeps what it has touched.
double peak_memory(int nodes) {
  const std::string self = std::filesystem::canonical("/proc/self/exe").string();
  const std::string command = fmt::format("'{}' --memory {}", self, nodes);
  FILE* pipe = popen(command.c_str(), "r");
  double kilobytes = 0.0;
  if (pipe == nullptr || std::fscanf(pipe, "%lf", &kilobytes) != 1 || pclose(pipe) != 0)
    throw Error("cannot run " + command);
  return 1024.0 * kilobytes;
}

}  // namespace

void solve_for_memory(int nodes) {
  enrich(poisson(3, nodes), equal_work());
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with("VmHWM:")) std::printf("%ld\n", std::stol(line.substr(6)));
  }
}

void run_costs(const Options& options) {
  constexpr const char* kName = "cost";
  if (!options.wants(kName)) return;
  const std::vector<double> sizes = {12500, 25000, 50000, 100000};
  const double nothing = peak_memory(10);
  std::vector<double> memory;
  for (const double n : sizes) memory.push_back(peak_memory(static_cast<int>(n)) - nothing);

  const std::vector<double> dimensions = {8, 16, 32, 64};
  std::vector<double> times;
  for (const double d : dimensions) times.push_back(seconds_per_term(poisson(static_cast<int>(d), 63)));
  print({kLinearEngine, kName, "slope_dimensions", slope(dimensions, times), "1"});
  print({kLinearEngine, kName, "time_64_dimensions", times.back(), "s"});
  times.clear();
  for (const double n : sizes) times.push_back(seconds_per_term(poisson(3, static_cast<int>(n))));
  print({kLinearEngine, kName, "slope_nodes", slope(sizes, times), "1"});
  print({kLinearEngine, kName, "time_100000_nodes", times.back(), "s"});
  print({kLinearEngine, kName, "slope_memory", slope(sizes, memory), "1"});
  print({kLinearEngine, kName, "memory_100000_nodes", memory.back(), "B"});
}

void run_solvers(const Options& options) {
  constexpr const char* kName = "sparse_solvers";
  if (!options.wants(kName)) return;
  const HeatedDisc disc(100);
  const LinearProblem plate = disc.problem().assemble();
  const LinearProblem line = poisson(3, 20000);
  for (const SparseSolverKind kind :
       {SparseSolverKind::automatic, SparseSolverKind::eigen_ldlt, SparseSolverKind::eigen_lu,
        SparseSolverKind::cholmod, SparseSolverKind::umfpack}) {
    if (!is_available(kind)) continue;
    EnrichOptions with = equal_work();
    with.max_rank = 4;
    with.solver = kind;
    print({kLinearEngine, kName, fmt::format("mesh_{}", to_string(kind)), enrich(plate, with).seconds, "s"});
    print({kLinearEngine, kName, fmt::format("line_{}", to_string(kind)), enrich(line, with).seconds, "s"});
  }
}

}  // namespace samara::benchmarks
