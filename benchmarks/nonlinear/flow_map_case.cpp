#include "flow_map_case.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "built.h"
#include "cases.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/integrators/rk4.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

constexpr int kFalls = 100;
constexpr double kEnd = 0.5;
/// Ten steps a window: off by some 1e-5 m after 0.3 s.
constexpr double kStep = 4e-3;

/// A start and coefficients, as coordinates of the plan.
std::vector<double> random_point(const codebooks::Plan& plan, pgd::Random& random) {
  std::vector<double> q;
  for (const codebooks::BoxEntry& entry : plan.box)
    q.push_back(entry.lower + (0.25 + 0.5 * random.uniform()) * (entry.upper - entry.lower));
  return q;
}

}  // namespace

void flow_map_case(const codebooks::Plan& plan) {
  const char* name = "flow_map11";
  codebooks::BuildOptions options;
  const codebooks::BuildResult result = codebooks::build(plan, options);
  const codebooks::Codebook& book = result.book;
  print({kNonlinear, name, "certificate_max", book.certificate()->max_error});
  print({kNonlinear, name, "met", result.met ? 1.0 : 0.0, result.message});
  print({kNonlinear, name, "time", book.provenance().build_seconds, "s"});
  print({kNonlinear, name, "evaluation_fraction", book.build().evaluations / book.build().grid_size});
  print({kNonlinear, name, "reached", book.coordinates().front().upper, "s"});

  const models::ParametricModel model = plan.parametric_model();
  codebooks::FlowMap map(book);
  std::vector<double> times;
  for (int k = 1; k <= 50; ++k) times.push_back(kEnd * k / 50.0);
  pgd::Random random(7);
  const auto states = static_cast<Eigen::Index>(model.model().info().states.size());
  Eigen::VectorXd largest = Eigen::VectorXd::Constant(states, -HUGE_VAL), smallest = -largest;
  Eigen::VectorXd error = Eigen::VectorXd::Zero(states);
  int within = 0;
  double until = 0.0;
  std::vector<double> start(static_cast<std::size_t>(states));
  std::vector<double> q;
  for (int fall = 0; fall < kFalls; ++fall) {
    q = random_point(plan, random);
    model.initial(q, start);
    const std::vector<double> coefficients(q.begin(), q.begin() + 3);
    const codebooks::FlowMapResult composed = map.run(start, coefficients, times);
    within += composed.status == codebooks::FlowMapStatus::done ? 1 : 0;
    until += composed.reached / kFalls;
    const models::Trajectory exact = models::integrate(model, q, times, {.relative_tolerance = 1e-10});
    for (std::size_t k = 0; k < times.size() && times[k] <= composed.reached; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      Eigen::VectorXd here = composed.states.row(row), there = exact.states.row(row);
      // Attitudes are told apart by direction only, and by no sign.
      here.segment<4>(3).normalize();
      there.segment<4>(3).normalize();
      if (here.segment<4>(3).dot(there.segment<4>(3)) < 0.0) here.segment<4>(3) *= -1.0;
      largest = largest.cwiseMax(there);
      smallest = smallest.cwiseMin(there);
      error = error.cwiseMax((here - there).cwiseAbs());
    }
  }
  print({kNonlinear, name, "composed_error", error.cwiseQuotient(largest - smallest).maxCoeff()});
  print({kNonlinear, name, "composed_share", static_cast<double>(within) / kFalls});
  print({kNonlinear, name, "composed_until", until, "s"});

  model.initial(q, start);
  const std::vector<double> coefficients(q.begin(), q.begin() + 3);
  const std::vector<double> window = {plan.end};
  const Pair pair = time_both([&] { map.run(start, coefficients, window); },
                              [&] { models::integrate_rk4(model, q, window, {.step = kStep}); });
  print({kNonlinear, name, "query_time", pair.ours, "s", "Runge-Kutta steps of 4 ms", pair.ratio()});
}

}  // namespace samara::benchmarks
