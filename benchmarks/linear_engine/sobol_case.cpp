// Sobol' indices of Ishigami's function from a separated field, against their closed form.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "cases.h"
#include "samara/pgd/cross/separate_function.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/fields/statistics.h"

namespace samara::benchmarks {

void run_sobol(const Options& options) {
  using namespace pgd;
  constexpr const char* kName = "sobol_ishigami";
  if (!options.wants(kName)) return;
  constexpr double kA = 7.0;
  constexpr double kB = 0.1;
  constexpr double kPi = std::numbers::pi;
  std::vector<Axis> axes;
  for (const char* name : {"x1", "x2", "x3"}) axes.push_back(Axis::chebyshev({name}, -kPi, kPi, 26));
  const SeparatedFunction f = separate(
      [](std::span<const double> x) {
        return std::sin(x[0]) + kA * std::pow(std::sin(x[1]), 2) + kB * std::pow(x[2], 4) * std::sin(x[0]);
      },
      axes, {.tolerance = 1e-10});
  const SeparatedField field(axes, {{"f"}}, f.tensor.factors, f.tensor.weights.transpose());
  const Statistics found = statistics(field);
  // Saltelli et al. 2008, section 4.
  const double v1 = 0.5 * std::pow(1.0 + kB * std::pow(kPi, 4) / 5.0, 2);
  const double v2 = kA * kA / 8.0;
  const double v13 = kB * kB * std::pow(kPi, 8) * (1.0 / 18.0 - 1.0 / 50.0);
  const double v = v1 + v2 + v13;
  const double first[] = {v1 / v, v2 / v, 0.0};
  const double total[] = {(v1 + v13) / v, v2 / v, v13 / v};
  double error =
      std::max(std::abs(found.mean(0, 0) - kA / 2.0) / (kA / 2.0), std::abs(found.variance(0, 0) / v - 1.0));
  for (std::size_t k = 0; k < 3; ++k) {
    error = std::max(
        {error, std::abs(found.first_order[k](0, 0) - first[k]), std::abs(found.total[k](0, 0) - total[k])});
  }
  print({kLinearEngine, kName, "error", error, "1"});
  print({kLinearEngine, kName, "terms", static_cast<double>(f.tensor.rank()), "1"});
  print({kLinearEngine, kName, "evaluations", static_cast<double>(f.evaluations), "1"});
}

}  // namespace samara::benchmarks
