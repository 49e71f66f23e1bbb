// Heat conduction for all conductivities of a decade, all boundary values and all initial amplitudes at once:
// one solve, then answers at any of them.
#include "heat.h"

#include <cstdio>

#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/enrichment.h"

int main() {
  using namespace samara::pgd;
  const Heat heat;
  const ParametricProblem problem = heat.problem();
  EnrichOptions options;
  options.projection = Projection::minimal_residual;  // the operator of time is not symmetric
  options.residual_tolerance = 1e-4;
  options.update_sweeps = 4;
  const EnrichResult result = enrich(problem.assemble(), options);
  std::printf("%s: %s\n", to_string(result.termination).c_str(), result.message.c_str());

  const SeparatedTensor u = problem.complete(result.solution);
  const SeparatedField field(problem.axes(), {{"u", "K"}}, u.factors, u.weights.transpose());
  for (const double k : {0.1, 0.3, 1.0}) {
    const std::vector<double> point = {0.5, 0.2, k, 1.0, 0.5};  // x, t, k, g, a
    std::printf("u(x = 0.5, t = 0.2; k = %.1f, g = 1, a = 0.5) = %.4f\n", k, field(point)[0]);
  }
  return result.termination == samara::Termination::converged ? 0 : 1;
}
