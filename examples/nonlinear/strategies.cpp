// Two nonlinear problems, each for a whole box of parameters at once: a fall against quadratic drag
// (6.20) by three strategies on slabs that are given, and three unknowns coupled by their products
// (6.22), one field each, by the march that chooses slabs and nodes.
#include <cmath>
#include <cstdio>
#include <vector>

#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/march.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

using namespace samara::pgd;

namespace {

// u' = k C_D u^2 - g, u(0) = 0: exact, u = -u_T tanh(g t / u_T) with u_T = sqrt(g / (k C_D)).
void fall() {
  const PolynomialSystem drag(1, 1, {{0, 3.075, {1}, {2}}, {0, -9.81}});
  const EvolutionProblem problem{
      &drag,
      Axis::radau({"t", "s", AxisRole::time}, 0.0, 0.4, 4, 9),  // four slabs
      {Axis::chebyshev({"C_D"}, 0.5, 2.0, 14)},
      {{"u", "m/s"}},
      {2.5},
      {{0.0, -1}}};
  const double terminal = std::sqrt(9.81 / (3.075 * 1.2));
  const double exact = -terminal * std::tanh(9.81 * 0.31 / terminal);
  const auto picard = incremental_strategy();
  const auto series = asymptotic_strategy();
  const auto newton = cross_strategy();
  for (Strategy* strategy : {picard.get(), series.get(), newton.get()}) {
    const StrategyTrial result = try_strategy(problem, *strategy, {.tolerance = 1e-7});
    std::printf("%s: %s\n  error at t = 0.31 s, C_D = 1.2: %.0e\n", strategy->name().c_str(),
                result.message.c_str(),
                std::abs(result.value_at(std::vector{0.31, 1.2})[0] - exact));
  }
}

// u1' = 1 - u2 u3, u2' = 2 - u1 u3, u3' = 3 - u1 u2, for all initial values in [0, 1]^3.
void products() {
  const PolynomialSystem system(3, 3,
                                {{0, 1.0},
                                 {0, -1.0, {}, {0, 1, 1}},
                                 {1, 2.0},
                                 {1, -1.0, {}, {1, 0, 1}},
                                 {2, 3.0},
                                 {2, -1.0, {}, {1, 1, 0}}});
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 0.8;
  problem.parameters = {{{"u1(0)"}, 0.0, 1.0}, {{"u2(0)"}, 0.0, 1.0}, {{"u3(0)"}, 0.0, 1.0}};
  problem.states = {{"u1"}, {"u2"}, {"u3"}};
  problem.scales = {1.0, 1.0, 1.0};
  problem.scale_floors = {0.0, 0.0, 0.0};
  problem.initial = {{0.0, 0}, {0.0, 1}, {0.0, 2}};
  const SlabResult result = march(problem, "decoupling", {.tolerance = 1e-4});
  std::printf("decoupling: %s, %s\n", to_string(result.status).c_str(), result.message.c_str());
}

}  // namespace

int main() {
  fall();
  products();
  return 0;
}
