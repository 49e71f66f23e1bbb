#include "samara/pgd/evolution/adaptive_evolution.h"

#include <cmath>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

/// x' = -(1.5 + cos q) x, x(0) = 1: periodic in q.
class PeriodicDecay : public EvolutionSystem {
 public:
  int state_count() const override { return 1; }
  void rhs(const Eigen::VectorXd&, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override {
    f = -(1.5 + q.array().cos()) * x.array();
  }
  void jacobian(const Eigen::VectorXd&, const Eigen::MatrixXd&, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override {
    jacobian = -(1.5 + q.array().cos());
  }
};

double solution(double t, double q) {
  return std::exp(-(1.5 + std::cos(q)) * t);
}

const PeriodicDecay kSystem;

AdaptiveProblem problem(AdaptiveAxis axis) {
  AdaptiveProblem p;
  p.system = &kSystem;
  p.time = {"t", "s", AxisRole::time};
  p.parameters = {std::move(axis)};
  p.states = {{"x"}};
  p.scales = {1.0};
  p.scale_floors = {0.0};
  p.initial = {{1.0, -1}};
  return p;
}

/// Largest error over a grid of the box.
double error(const SeparatedField& field, double lower, double upper) {
  double largest = 0.0;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 40; ++j) {
      const double t = i / 40.0;
      const double q = lower + (upper - lower) * j / 40.0;
      largest = std::max(largest, std::abs(field(std::vector{t, q})[0] - solution(t, q)));
    }
  }
  return largest;
}

}  // namespace

TEST_CASE("every basis that the solver refines reaches the tolerance, the periodic one with fewest nodes") {
  constexpr double kPeriod = 2.0 * std::numbers::pi;
  const auto nodes = [&](Basis basis) {
    const AdaptiveResult result =
        solve_adaptively(problem({{"q", "rad"}, 0.0, kPeriod, {}, basis}), {.tolerance = 1e-6});
    INFO(to_string(basis));
    INFO(result.message);
    CHECK(result.status == AdaptiveStatus::converged);
    CHECK(result.evolution.field.axes()[1].basis() == basis);
    CHECK(error(result.evolution.field, 0.0, kPeriod) < 1e-6);
    return result.evolution.field.axes()[1].size();
  };
  const int periodic = nodes(Basis::fourier);
  CHECK(periodic % 2 == 1);
  CHECK(periodic < nodes(Basis::chebyshev));
  CHECK(periodic < nodes(Basis::legendre));
}

TEST_CASE("finite elements with fixed nodes are solved on, with the error of their mesh") {
  const auto solved = [](Basis basis, int nodes) {
    return solve_adaptively(problem({{"q"}, 0.0, 2.0, nodes, basis}), {.tolerance = 1e-6}).evolution.field;
  };
  CHECK(solved(Basis::p1, 17).axes()[1].size() == 17);
  CHECK(solved(Basis::p2, 17).axes()[1].size() == 17);
  CHECK(std::log2(error(solved(Basis::p1, 9), 0.0, 2.0) / error(solved(Basis::p1, 17), 0.0, 2.0)) ==
        Approx(2.0).margin(0.3));
  CHECK(error(solved(Basis::p2, 17), 0.0, 2.0) < 0.2 * error(solved(Basis::p1, 17), 0.0, 2.0));
}

TEST_CASE("a basis that cannot be refined, or a time axis without elements, is refused by name") {
  const auto with = [](Basis basis) { solve_adaptively(problem({{"q"}, 0.0, 2.0, {}, basis})); };
  CHECK_THROWS_WITH(with(Basis::p1), Contains("axis \"q\" is p1") && Contains("number of nodes"));
  CHECK_THROWS_WITH(with(Basis::radau), Contains("axis \"q\" is radau"));
  CHECK_THROWS_AS(with(Basis::discrete), samara::ArgumentError);
  EvolutionProblem periodic{&kSystem,
                            Axis::fourier({"t", "s", AxisRole::time}, 0.0, 1.0, 5),
                            {Axis::chebyshev({"q"}, 0.0, 1.0, 4)},
                            {{"x"}},
                            {1.0},
                            {{1.0, -1}}};
  CHECK_THROWS_WITH(solve_evolution(periodic), Contains("the time axis \"t\" is fourier"));
  periodic.time = Axis::radau({"t", "s", AxisRole::time, Transform::square_root}, 0.0, 1.0, 2, 3);
  CHECK_THROWS_WITH(solve_evolution(periodic), Contains("\"square_root\""));
}
