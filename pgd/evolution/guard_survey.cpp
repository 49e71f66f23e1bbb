#include "samara/pgd/evolution/guard_survey.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "samara/pgd/evolution/march_context.h"
#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/evolution/time_stepper.h"

namespace samara::pgd {

namespace {

/// One random point for so many guards of a cell.
constexpr int kOneOf = 4;
/// Of the evaluations allowed, what a survey may take.
constexpr double kShareOfBudget = 0.5;
/// How far neighbours start apart at most, in scales.
constexpr double kApart = 1e-3;

Eigen::MatrixXd random_directions(Eigen::Index rows, Eigen::Index columns, Random& random) {
  Eigen::MatrixXd directions(rows, columns);
  for (double& entry : directions.reshaped()) entry = random.normal();
  return directions.colwise().normalized();
}

/// @param apart per border of slabs, the first at t = 0: states x points
double growth_of(const std::vector<Eigen::MatrixXd>& apart, const Eigen::VectorXd& ranges) {
  const auto lengths = [&](const Eigen::MatrixXd& difference) -> Eigen::RowVectorXd {
    return (ranges.cwiseInverse().asDiagonal() * difference).colwise().norm();
  };
  const Eigen::RowVectorXd last = lengths(apart.back());
  double sum = 0.0;
  for (std::size_t k = 1; k < apart.size(); ++k) {
    const Eigen::RowVectorXd here = lengths(apart[k]);
    double largest = 0.0;
    for (Eigen::Index j = 0; j < here.size(); ++j) {
      const double factor = last[j] / here[j];
      if (std::isfinite(factor)) largest = std::max(largest, factor);
    }
    sum += largest * largest;
  }
  return std::max(std::sqrt(sum), 1.0);
}

}  // namespace

GuardSurvey survey_guards(const AdaptiveProblem& problem, const SlabOptions& options,
                          const SlabSolver& solver, const Eigen::VectorXd& scales, double tolerance) {
  MarchContext context(problem, options, solver, scales, {tolerance, tolerance});
  TimeStepper stepper(context);
  Random random(options.seed);
  std::vector<int> nodes;
  for (const AdaptiveAxis& axis : problem.parameters)
    nodes.push_back(axis.nodes.value_or(options.first_nodes));
  SlabCell cell = whole_box(problem, scales, nodes, std::max(1, options.guards / kOneOf), random);
  cell.length = context.longest();
  const Eigen::Index states = context.states();
  Eigen::VectorXd smallest = cell.carried.rowwise().minCoeff(), largest = cell.carried.rowwise().maxCoeff();
  Eigen::MatrixXd neighbours = cell.carried + std::min(kApart, options.tolerance) *
                                                  random_directions(states, cell.carried.cols(), random);
  std::vector<Eigen::MatrixXd> apart = {neighbours - cell.carried};
  GuardSurvey survey;
  const auto goes_on = [&] {
    survey.cancelled = context.is_cancelled(Progress{"survey of the box", cell.time / problem.end});
    return !survey.cancelled;
  };
  while (
      cell.time < problem.end && goes_on() &&
      (options.max_evaluations == 0 || static_cast<double>(context.evaluations()) <
                                           kShareOfBudget * static_cast<double>(options.max_evaluations))) {
    if (stepper.probe(cell, cell.carried)) break;
    const ProbedSlab& slab = *cell.slab;
    const auto values = slab.values.reshaped(states, slab.values.size() / states);
    smallest = smallest.cwiseMin(values.rowwise().minCoeff());
    largest = largest.cwiseMax(values.rowwise().maxCoeff());
    neighbours = context.solve(slab.borders, neighbours, cell.guards).values.bottomRows(states);
    cell.carried = slab.values.bottomRows(states);
    apart.push_back(neighbours - cell.carried);
    cell.time = slab.end();
    cell.length = slab.next_length;
    cell.slab.reset();
  }
  survey.ranges = largest - smallest;
  survey.growth = growth_of(apart, survey.ranges.cwiseMax(1e-12));
  survey.evaluations = context.evaluations();
  return survey;
}

}  // namespace samara::pgd
