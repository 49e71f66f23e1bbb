// From a linear problem to a file: the heat of heat.h, certified against CVODE, saved, opened and asked as any
// codebook is. Place, initial and boundary values are coordinates.
//
//   build/release/examples/linear_engine/example_heat_codebook wall.h5
//   samara query wall.h5 --set x=0.5 --set k=0.3 --set g=1 --set a=0.5 --at 0.2 --gradient
//   samara export wall.h5 --to paraview --set k=0.3 --set g=1 --set a=0.5 -o wall.pvd
#include <cstdio>

#include "heat.h"
#include "samara/codebooks/fields/field_codebook.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"

int main(int argc, char** argv) {
  using namespace samara::pgd;
  using namespace samara::codebooks;
  if (argc != 2) return 2;
  const Heat heat;
  const ParametricProblem problem = heat.problem();
  EnrichOptions options;
  options.projection = Projection::minimal_residual;
  options.residual_tolerance = 1e-4;
  options.update_sweeps = 4;
  const EnrichResult result = enrich(problem.assemble(), options);

  FieldRequest request{.output = {"u", "K"}};
  request.problem.name = "wall";
  request.problem.title = "heat in a wall";
  request.problem.equations =
      "du/dt = k d2u/dx2,  u(t,0) = g,  u(t,1) = 0,  u(0,x) = g (1 - x)^2 + a sin(pi x)";
  request.certify.points = 200;  // each an integration by CVODE on the nodes of space
  request.certify.tolerance = 1e-3;
  save(make_codebook(problem, result, request), argv[1]);

  const Codebook book = load(argv[1]);
  std::printf("largest error %.1e at %d points x %d times x %d places\n",
              book.certificate()->max_error, book.certificate()->points, book.certificate()->times,
              book.certificate()->places);
  Query query(book);
  Eigen::VectorXd value(1);
  Eigen::MatrixXd gradient(1, 5);
  query.values(std::vector{0.2, 0.5, 0.3, 1.0, 0.5}, value, gradient);  // t, x, k, g, a
  std::printf("u(t = 0.2, x = 0.5; k = 0.3, g = 1, a = 0.5) = %.3f, du/dg = %.3f\n", value[0],
              gradient(0, 3));
  return book.certificate()->met ? 0 : 1;
}
