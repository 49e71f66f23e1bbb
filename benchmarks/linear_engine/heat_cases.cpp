// Parametric heat conduction against CVODE, and a heated plate on an imported mesh against direct solves.
#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/SparseCholesky>

#include "cases.h"
#include "cvode_reference.h"
#include "examples/linear_engine/disc.h"
#include "examples/linear_engine/heat.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/linear/enrichment.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

/// All nodes of the first axes at one point of the others: the field's factors there times the weights.
double at(const SeparatedTensor& u, const std::vector<int>& nodes, const Eigen::VectorXd& others) {
  Eigen::ArrayXd terms = u.weights.array() * others.array();
  for (std::size_t k = 0; k < nodes.size(); ++k) terms *= u.factors[k].row(nodes[k]).transpose().array();
  return terms.sum();
}

/// Products of the factors of the axes from `first` on, at the point x.
Eigen::VectorXd factors_at(const SeparatedField& field, int first, const std::vector<double>& x) {
  Eigen::VectorXd product = Eigen::VectorXd::Ones(field.rank());
  Eigen::VectorXd values(field.rank());
  for (std::size_t j = 0; j < x.size(); ++j) {
    const int axis = first + static_cast<int>(j);
    InterpolationStencil stencil = field.axes()[static_cast<std::size_t>(axis)].make_stencil();
    field.factor_values(axis, x[j], stencil, values);
    product.array() *= values.array();
  }
  return product;
}

double inside(const Axis& axis, Random& random) {
  return axis.lower() + random.uniform() * (axis.upper() - axis.lower());
}

/// The field of a solution, and its values as a tensor with the field's own factors.
struct Answer {
  SeparatedField field;
  SeparatedTensor tensor;
  Answer(const ParametricProblem& problem, const SeparatedTensor& u)
      : field(problem.axes(), {{"u"}}, u.factors, u.weights.transpose()),
        tensor{field.weights().row(0).transpose(), field.factors()} {}
};

double largest_heat_error(const Heat& heat, const Answer& answer, int points) {
  const int n = heat.x.size() - 2;
  const Eigen::MatrixXd mass = Eigen::MatrixXd(heat.x.mass()).block(1, 1, n, n);
  const Eigen::MatrixXd stiffness = heat.x.stiffness();
  const Eigen::VectorXd x = heat.x.nodes().segment(1, n);
  Random random(2026);
  double largest = 0.0;
  double low = 0.0;
  double high = 0.0;
  for (int p = 0; p < points; ++p) {
    const double k = inside(heat.k, random);
    const double g = inside(heat.g, random);
    const double a = inside(heat.a, random);
    const Eigen::VectorXd load = -k * g * stiffness.col(0).segment(1, n);
    const Eigen::VectorXd start = g * (1.0 - x.array()).square() + a * (std::numbers::pi * x.array()).sin();
    const Eigen::MatrixXd reference = integrate_linear(
        mass, k * stiffness.block(1, 1, n, n), [&](double) { return load; }, start, heat.t.nodes());
    const Eigen::VectorXd others = factors_at(answer.field, 2, {k, g, a});
    for (int j = 0; j < heat.t.size(); ++j) {
      for (int i = 0; i < n; ++i)
        largest = std::max(largest, std::abs(at(answer.tensor, {i + 1, j}, others) - reference(i, j)));
    }
    low = std::min(low, reference.minCoeff());
    high = std::max(high, reference.maxCoeff());
  }
  return largest / (high - low);
}

double largest_mesh_error(const HeatedDisc& disc, const Answer& answer, int points) {
  Random random(2026);
  double largest = 0.0;
  double range = 0.0;
  for (int p = 0; p < points; ++p) {
    const double k = inside(disc.k, random);
    const double s = inside(disc.s, random);
    SparseMatrix matrix = disc.mesh.stiffness_plate + k * disc.mesh.stiffness_disc;
    Eigen::VectorXd load = s * (disc.mesh.mass * disc.source());
    for (const int node : disc.mesh.border) {
      matrix.coeffRef(node, node) += 1e12;  // holds u at zero there
      load[node] = 0.0;
    }
    const Eigen::VectorXd reference = Eigen::SimplicialLDLT<SparseMatrix>(matrix).solve(load);
    const Eigen::VectorXd others = factors_at(answer.field, 1, {k, s});
    for (int i = 0; i < disc.place.size(); ++i)
      largest = std::max(largest, std::abs(at(answer.tensor, {i}, others) - reference[i]));
    range = std::max(range, reference.maxCoeff());
  }
  return largest / range;
}

}  // namespace

void run_heat(const Options& options) {
  if (!options.wants("heat5")) return;
  const Heat heat;
  const ParametricProblem problem = heat.problem();
  EnrichOptions with;
  with.projection = Projection::minimal_residual;
  with.residual_tolerance = 3e-5;
  with.update_sweeps = 4;
  const EnrichResult result = enrich(problem.assemble(), with);
  const Answer answer(problem, problem.complete(result.solution));
  print({kLinearEngine, "heat5", "error_max", largest_heat_error(heat, answer, 100), "1"});
  print({kLinearEngine, "heat5", "rank", static_cast<double>(result.solution.rank()), "1"});
  print({kLinearEngine, "heat5", "time", result.seconds, "s"});
}

void run_mesh(const Options& options) {
  if (!options.wants("mesh")) return;
  const HeatedDisc disc(100);
  const ParametricProblem problem = disc.problem();
  EnrichOptions with;
  with.projection = Projection::galerkin;
  with.residual_tolerance = 1e-7;
  const EnrichResult result = enrich(problem.assemble(), with);
  const Answer answer(problem, problem.complete(result.solution));
  print({kLinearEngine, "mesh", "nodes", static_cast<double>(disc.place.size()), "1"});
  print({kLinearEngine, "mesh", "error_max", largest_mesh_error(disc, answer, 20), "1"});
  print({kLinearEngine, "mesh", "rank", static_cast<double>(result.solution.rank()), "1"});
  print({kLinearEngine, "mesh", "time", result.seconds, "s"});
}

}  // namespace samara::benchmarks
