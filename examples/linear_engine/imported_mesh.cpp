// A two-dimensional mesh as one axis: the matrices come from another program, here from mesh.h. One solve
// gives the temperature of a heated plate for all conductivities of a disc in it, over two decades.
#include <cstdio>

#include "disc.h"
#include "samara/pgd/linear/enrichment.h"

int main() {
  using namespace samara::pgd;
  const HeatedDisc disc(100);  // 10201 nodes
  const ParametricProblem problem = disc.problem();
  EnrichOptions options;
  options.projection = Projection::galerkin;
  options.residual_tolerance = 1e-7;
  const EnrichResult result = enrich(problem.assemble(), options);
  const SeparatedTensor u = problem.complete(result.solution);
  std::printf("%d nodes, %s: %s\n", disc.place.size(), to_string(result.termination).c_str(),
              result.message.c_str());
  const int centre = disc.mesh.node(50, 50);
  for (const int i : {0, 8, 15}) {
    const std::vector<int> index = {centre, i, 0};
    std::printf("u(centre; k = %6.3f, s = 1) = %.6f\n", disc.k.nodes()[i], u.entry(index));
  }
  return result.termination == samara::Termination::converged ? 0 : 1;
}
