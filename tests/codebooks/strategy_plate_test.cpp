// The strategies on the reference plate, where each of them meets 1e-6 or has its order.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/codebooks/source/model_system.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/pgd/checks/check_system.h"
#include "samara/pgd/nonlinear/strategy_trial.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;
using samara::codebooks::ModelSystem;
using samara::models::ParametricModel;

namespace {

struct Box {
  std::vector<std::string> names;
  std::vector<double> lower, upper;
};

ParametricModel plate(const Box& box, const std::map<std::string, double>& fixed) {
  return {samara::models::find_model("falling_plate_nd"), fixed, box.names};
}

EvolutionProblem problem_of(const ParametricModel& model, const ModelSystem& system, const Box& box,
                            double end, int slabs, int nodes) {
  EvolutionProblem problem{&system, Axis::radau({"t", "1", AxisRole::time}, 0.0, end, slabs, 8), {}, {}, {},
                           {}};
  std::vector<double> centre, start(6);
  for (std::size_t k = 0; k < box.names.size(); ++k) {
    problem.parameters.push_back(Axis::chebyshev({box.names[k]}, box.lower[k], box.upper[k], nodes));
    centre.push_back(0.5 * (box.lower[k] + box.upper[k]));
  }
  model.initial(centre, start);
  for (std::size_t s = 0; s < 6; ++s) {
    problem.states.push_back({model.model().info().states[s].name, "1"});
    problem.scales.push_back(1.0);
    problem.initial.push_back({start[s], -1});
  }
  return problem;
}

/// Largest error at random points; the states are of the order of one.
double error_of(const StrategyTrial& result, const ParametricModel& model, const Box& box, double end) {
  samara::models::Integrator exact(model, {.relative_tolerance = 1e-12}, false);
  Random random(5);
  double largest = 0.0;
  for (int i = 0; i < 40; ++i) {
    std::vector<double> x = {end * (0.3 + 0.7 * random.uniform())};
    for (std::size_t k = 0; k < box.names.size(); ++k)
      x.push_back(box.lower[k] + (box.upper[k] - box.lower[k]) * random.uniform());
    const samara::models::Trajectory trajectory =
        exact(std::span(x).subspan(1), std::vector<double>{0.0, x[0]});
    REQUIRE(trajectory.is_usable());
    const Eigen::VectorXd error = result.value_at(x) - trajectory.states.row(1).transpose();
    largest = std::max(largest, error.cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

TEST_CASE("empirical interpolation and Newton with crosses meet 1e-6 on the reference plate to t = 2") {
  const Box box{{"C_T", "C_R", "A"}, {0.8, 2.0, 1.0}, {1.4, 4.0, 1.8}};
  const ParametricModel model = plate(box, {{"theta(0)", 0.4}, {"w(0)", 0.0}});
  const ModelSystem system(model);
  const auto newton = cross_strategy();
  const auto empirical = empirical_strategy();
  for (Strategy* strategy : {newton.get(), empirical.get()}) {
    const StrategyTrial result =
        try_strategy(problem_of(model, system, box, 2.0, 10, 11), *strategy, {.tolerance = 3e-7});
    CAPTURE(strategy->name(), result.message);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK(error_of(result, model, box, 2.0) <= 1e-6);
    CHECK(static_cast<double>(result.rhs_evaluations) < result.grid_evaluations);
  }
}

TEST_CASE("expanded about broadside fall, a plate is solved to the power of its tilt above the order") {
  const Box box{{"C_T", "C_R"}, {0.8, 2.0}, {1.4, 4.0}};
  // Broadside: vy^2 = pi / (A + B). Without mu2 |w| w, which has no second derivative at rest.
  const double fall = -std::sqrt(M_PI / 2.4);
  for (const int order : {1, 2}) {
    std::vector<double> errors;
    for (const double tilt : {0.02, 0.01}) {
      const ParametricModel model = plate(box, {{"theta(0)", tilt},
                                                {"w(0)", 0.0},
                                                {"vx(0)", 0.0},
                                                {"vy(0)", fall},
                                                {"A", 1.4},
                                                {"B", 1.0},
                                                {"mu2", 0.0}});
      const ModelSystem system(model);
      Eigen::VectorXd broadside = Eigen::VectorXd::Zero(6);
      broadside[1] = fall;
      const auto strategy = polynomial_strategy({.order = order, .state = broadside});
      const StrategyTrial result =
          try_strategy(problem_of(model, system, box, 1.0, 4, 8), *strategy, {.tolerance = 1e-9});
      CAPTURE(order, tilt, result.message);
      REQUIRE(result.status == samara::Termination::converged);
      errors.push_back(error_of(result, model, box, 1.0));
    }
    CAPTURE(order, errors[0], errors[1]);
    // The first neglected terms: of the order of the tilt to the power order + 1.
    CHECK(std::log2(errors[0] / errors[1]) == Approx(order + 1.0).margin(0.25));
    if (order == 2) CHECK(errors[1] <= 1e-6);
  }
}

TEST_CASE("a model is an evolution system that keeps its promises") {
  const Box box{{"C_T", "C_R", "theta(0)"}, {0.8, 2.0, 0.2}, {1.4, 4.0, 0.6}};
  const ParametricModel model = plate(box, {{"w(0)", 0.0}});
  const ModelSystem system(model);
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 2.0;
  std::vector<double> start(6);
  model.initial(std::vector{1.1, 3.0, 0.4}, start);
  for (std::size_t k = 0; k < 3; ++k)
    problem.parameters.push_back({{box.names[k]}, box.lower[k], box.upper[k]});
  for (std::size_t s = 0; s < 6; ++s) {
    problem.states.push_back({model.model().info().states[s].name, "1"});
    problem.initial.push_back({start[s], -1});
  }
  problem.scales.assign(6, 1.0);
  problem.scale_floors.assign(6, 0.0);
  CHECK(check_system(problem).findings == std::vector<std::string>{});
}
