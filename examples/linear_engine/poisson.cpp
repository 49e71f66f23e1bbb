// Poisson's equation in ten dimensions, -Laplace u = 1 on the unit cube with u = 0 on its border, on 63 nodes
// a side: a grid of 63^10 nodes, of which the separated solution needs 20 products.
#include "poisson.h"

#include <cstdio>

#include "samara/pgd/linear/enrichment.h"

int main() {
  using namespace samara::pgd;
  EnrichOptions options;
  options.projection = Projection::galerkin;  // right for symmetric positive operators
  options.residual_tolerance = 1e-3;
  options.update_sweeps = 4;
  options.checkpoint = [](const EnrichState& state) {
    std::printf("%2d terms: residual %.2e\n", state.solution.rank(), state.residual);
  };
  const EnrichResult result = enrich(poisson(10, 63), options);
  const std::vector<int> centre(10, 31);
  std::printf("%s: %s\n", to_string(result.termination).c_str(), result.message.c_str());
  std::printf("u(centre) = %.5f\n", result.solution.entry(centre));
  return result.termination == samara::Termination::converged ? 0 : 1;
}
