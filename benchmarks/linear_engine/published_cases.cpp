// The three cases of PGDrome (Fischer et al.), with their constants; what its sources leave open is named at
// the case.
#include <algorithm>
#include <cmath>

#include "cases.h"
#include "cvode_reference.h"
#include "samara/pgd/axes/axis_forms.h"
#include "samara/pgd/cross/separate_function.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/linear/parametric_problem.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

constexpr AxisRole kSpace = AxisRole::space;

/// Largest |u - exact| over all nodes, relative to the largest |exact|.
template <class Exact>
double largest_error(const SeparatedTensor& u, const std::vector<Axis>& axes, Exact exact) {
  double largest = 0.0;
  double size = 0.0;
  std::vector<int> index(axes.size(), 0);
  std::vector<double> x(axes.size());
  for (bool more = true; more;) {
    for (std::size_t k = 0; k < axes.size(); ++k) x[k] = axes[k].nodes()[index[k]];
    const double value = exact(x);
    largest = std::max(largest, std::abs(u.entry(index) - value));
    size = std::max(size, std::abs(value));
    more = false;
    for (std::size_t k = 0; k < axes.size() && !more; ++k) {
      more = ++index[k] < axes[k].size();
      if (!more) index[k] = 0;
    }
  }
  return largest / size;
}

void report(const char* name, double error, int terms) {
  print({kLinearEngine, name, "error", error, "1"});
  print({kLinearEngine, name, "terms", static_cast<double>(terms), "1"});
}

/// -0.5 Laplace T = q on x < 1.5 in [0,3]^2, T = (1 - x/3) u0 at x = 0 and 3, natural elsewhere. Exact:
/// the lift (1 - x/3) u0 and q times a function of x alone.
void laplace() {
  const Axis x = Axis::p1({"x", "1", kSpace}, 0.0, 3.0, 31);
  const Axis y = Axis::p1({"y", "1", kSpace}, 0.0, 3.0, 31);
  const Axis q = Axis::chebyshev({"q"}, 0.0, 50.0, 5);
  const Axis u0 = Axis::chebyshev({"u0"}, 10.0, 50.0, 5);
  ParametricProblem problem({x, y, q, u0});
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}}, 0.5);
  problem.add_term({{"y", ModeOperator::sparse(y.stiffness())}}, 0.5);
  const Eigen::VectorXd heated = load_vector(x, [](double s) { return s < 1.5 ? 1.0 : 0.0; });
  problem.add_source({{"x", heated}, {"q", q.nodes()}});
  problem.know("x", {0, x.size() - 1});
  problem.add_to_lift({{"x", nodal_values(x, [](double s) { return 1.0 - s / 3.0; })}, {"u0", u0.nodes()}});
  const EnrichResult result =
      enrich(problem.assemble(), {.projection = Projection::galerkin, .residual_tolerance = 1e-10});
  const auto exact = [](const std::vector<double>& at) {
    const double s = at[0];
    // T'' = -2 q on s < 1.5, 0 beyond; T = 0 at both ends, T and T' continuous at 1.5.
    const double shape = s < 1.5 ? 2.25 * s - s * s : 0.75 * (3.0 - s);
    return (1.0 - s / 3.0) * at[3] + at[2] * shape;
  };
  report("pgdrome_laplace", largest_error(problem.complete(result.solution), problem.axes(), exact),
         result.solution.rank());
}

/// -(E u')' = p on [0,1], u(0) = 0, the other end free. Exact: p / E (x - x^2 / 2).
void elastic() {
  const Axis x = Axis::p1({"x", "1", kSpace}, 0.0, 1.0, 41);
  const Axis modulus = Axis::chebyshev({"E"}, 0.2, 2.0, 30);
  const Axis load = Axis::chebyshev({"p"}, -1.0, 3.0, 5);
  ParametricProblem problem({x, modulus, load});
  problem.add_term(
      {{"x", ModeOperator::sparse(x.stiffness())}, {"E", ModeOperator::diagonal(modulus.nodes())}});
  problem.add_source({{"p", load.nodes()}});
  problem.know("x", {0});
  const EnrichResult result =
      enrich(problem.assemble(), {.projection = Projection::galerkin, .residual_tolerance = 1e-10});
  const auto exact = [](const std::vector<double>& at) {
    return at[2] / at[1] * (at[0] - 0.5 * at[0] * at[0]);
  };
  report("pgdrome_elastic", largest_error(problem.complete(result.solution), problem.axes(), exact),
         result.solution.rank());
}

/// u_t - 0.5 u_xx = q f(x, t) on [0,1], t in [0,1], u = 0 at t = 0, insulated; Goldak's source of radius 0.2
/// moves from x = 0.5 with speed 0.4 (the speed and the ends are ours), q in [0.5, 1]. Against CVODE on the
/// same elements at all nodes of q.
void heat() {
  const Axis x = Axis::p1({"x", "1", kSpace}, 0.0, 1.0, 61);
  // The source is switched on at t = 0: short elements there.
  const Eigen::VectorXd borders = Eigen::VectorXd::LinSpaced(13, 0.0, 1.0).array().cube();
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, borders, 5);
  const Axis q = Axis::chebyshev({"q"}, 0.5, 1.0, 3);
  const auto source = [](double place, double time) {
    const double from = (place - 0.5 - 0.4 * time) / 0.2;
    return std::exp(-3.0 * from * from);
  };
  ParametricProblem problem({x, t, q});
  problem.add_term({{"t", ModeOperator::sparse(t.derivative())}});
  problem.add_term({{"x", ModeOperator::sparse(x.stiffness())}}, 0.5);
  const SeparatedFunction separated =
      separate([&](std::span<const double> at) { return source(at[0], at[1]); }, {x, t}, {.tolerance = 1e-8});
  for (Eigen::Index r = 0; r < separated.tensor.rank(); ++r) {
    const Eigen::VectorXd load = x.mass() * separated.tensor.factors[0].col(r);
    problem.add_source({{"x", load}, {"t", separated.tensor.factors[1].col(r)}, {"q", q.nodes()}},
                       separated.tensor.weights[r]);
  }
  problem.know("t", {0});
  problem.measure("x", x.stiffness() + x.mass());
  const EnrichResult result = enrich(problem.assemble(), {.residual_tolerance = 1e-6, .update_sweeps = 4});
  const SeparatedTensor u = problem.complete(result.solution);
  const Eigen::MatrixXd mass = x.mass();
  const Eigen::MatrixXd stiffness = 0.5 * Eigen::MatrixXd(x.stiffness());
  const auto load = [&](double time) -> Eigen::VectorXd {
    return x.mass() * nodal_values(x, [&](double place) { return source(place, time); });
  };
  const Eigen::MatrixXd reference =
      integrate_linear(mass, stiffness, load, Eigen::VectorXd::Zero(x.size()), t.nodes());
  double largest = 0.0;
  for (int k = 0; k < q.size(); ++k) {
    for (int i = 0; i < x.size(); ++i) {
      for (int j = 0; j < t.size(); ++j) {
        const std::vector<int> index = {i, j, k};
        largest = std::max(largest, std::abs(u.entry(index) - q.nodes()[k] * reference(i, j)));
      }
    }
  }
  report("pgdrome_heat", largest / reference.maxCoeff(), result.solution.rank());
}

}  // namespace

void run_published(const Options& options) {
  if (options.wants("pgdrome_heat")) heat();
  if (options.wants("pgdrome_laplace")) laplace();
  if (options.wants("pgdrome_elastic")) elastic();
}

}  // namespace samara::benchmarks
