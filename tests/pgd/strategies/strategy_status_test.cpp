// How marches of strategies end, and what their iterations are worth.
#include <algorithm>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "../slab_systems.h"
#include "samara/base/errors.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/piecewise_linear_system.h"
#include "samara/pgd/nonlinear/strategy_trial.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;
using slab_systems::Matrix;
using slab_systems::Vector;

namespace {

/// x' = q x - x^2: the logistic equation, x = q x0 / (x0 + (q - x0) exp(-q t)).
PolynomialSystem logistic() {
  return {1, 1, {{0, 1.0, {1}, {1}}, {0, -1.0, {}, {2}}}};
}

EvolutionProblem logistic_problem(const EvolutionSystem& system, double end, int slabs) {
  return {&system,
          Axis::radau({"t", "s", AxisRole::time}, 0.0, end, slabs, 9),
          {Axis::chebyshev({"q"}, 1.0, 2.0, 12)},
          {{"x"}},
          {1.0},
          {{0.2, -1}}};
}

double logistic_error(const StrategyTrial& result, double end) {
  double largest = 0.0;
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const double t = end * random.uniform();
    const double q = 1.0 + random.uniform();
    const double exact = 0.2 * q / (0.2 + (q - 0.2) * std::exp(-q * t));
    largest = std::max(largest, std::abs(result.value_at(std::vector{t, q})[0] - exact));
  }
  return largest;
}

EvolutionProblem swing_problem(const EvolutionSystem& system) {
  return {&system,
          Axis::radau({"t"}, 0.0, 2.0, 2, 8),
          {Axis::chebyshev({"c"}, 0.1, 0.4, 9), Axis::chebyshev({"k"}, 0.8, 1.2, 9)},
          {{"theta"}, {"omega"}},
          {1.0, 1.0},
          {{1.5, -1}, {0.0, -1}}};
}

}  // namespace

TEST_CASE("corrections of incremental linearisation fall factorially, those of Newton quadratically") {
  const PolynomialSystem system = logistic();
  const EvolutionProblem problem = logistic_problem(system, 0.5, 1);
  const auto incremental = incremental_strategy();
  const StrategyTrial picard = try_strategy(problem, *incremental, {.tolerance = 1e-9});
  REQUIRE(picard.status == samara::Termination::converged);
  CHECK(logistic_error(picard, 0.5) <= 1e-7);
  // Iteration n adds a term of about (L t)^n / n!: ratios of corrections fall like 1/n.
  const std::vector<double>& steps = picard.history[0].corrections;
  REQUIRE(steps.size() >= 7);
  CHECK(steps[5] / steps[4] < 0.75 * steps[2] / steps[1]);

  const auto newton = cross_strategy();
  const StrategyTrial quadratic = try_strategy(problem, *newton, {.tolerance = 1e-9});
  REQUIRE(quadratic.status == samara::Termination::converged);
  CHECK(logistic_error(quadratic, 0.5) <= 1e-7);
  const std::vector<double>& newton_steps = quadratic.history[0].corrections;
  REQUIRE(newton_steps.size() >= 3);
  // |x''| / 2 = 1: the next correction is about the square of the last.
  CHECK(newton_steps[1] <= 2.0 * newton_steps[0] * newton_steps[0]);
  CHECK(newton_steps[2] <= 2.0 * newton_steps[1] * newton_steps[1] + 1e-9);
}

TEST_CASE("products are rounded in the scales of the rates, whatever those of the states") {
  // x' = -1e-9 q x y with y = 1e9: x = exp(-q t).
  const PolynomialSystem system(2, 1, {{0, -1e-9, {1}, {1, 1}}});
  const EvolutionProblem problem = {&system,
                                    Axis::radau({"t", "s", AxisRole::time}, 0.0, 0.5, 1, 9),
                                    {Axis::chebyshev({"q"}, 1.0, 2.0, 12)},
                                    {{"x"}, {"y"}},
                                    {1.0, 1e9},
                                    {{1.0, -1}, {1e9, -1}}};
  for (const auto& strategy : {incremental_strategy(), decoupling_strategy()}) {
    const StrategyTrial result = try_strategy(problem, *strategy, {.tolerance = 1e-6});
    CAPTURE(strategy->name(), result.message);
    REQUIRE(result.status == samara::Termination::converged);
    for (const double q : {1.1, 1.9})
      CHECK(std::abs(result.value_at(std::vector{0.4, q})[0] - std::exp(-0.4 * q)) <= 1e-5);
  }
}

TEST_CASE("terms of the asymptotic series fall geometrically, faster on shorter slabs") {
  const PolynomialSystem system = logistic();
  std::vector<double> ratios;
  for (const int slabs : {1, 2}) {
    const auto strategy = asymptotic_strategy();
    const StrategyTrial result =
        try_strategy(logistic_problem(system, 0.8, slabs), *strategy, {.tolerance = 1e-8});
    CAPTURE(slabs, result.message);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK(logistic_error(result, 0.8) <= 1e-6);
    ratios.push_back(result.history[0].contraction);
  }
  CHECK(ratios[1] < ratios[0]);
}

TEST_CASE("piecewise linear values as a first iterate save Newton iterations, and the end is the same") {
  const slab_systems::System system = slab_systems::pendulum();
  const EvolutionProblem problem = swing_problem(system);
  const auto newton = cross_strategy();
  const auto first = piecewise_linear_strategy({.points = 60, .weight_tolerance = 1e-3});
  const StrategyTrial alone = try_strategy(problem, *newton, {.tolerance = 1e-6});
  const StrategyTrial helped = try_strategy(problem, *newton, {.tolerance = 1e-6, .first = first.get()});
  REQUIRE(alone.status == samara::Termination::converged);
  REQUIRE(helped.status == samara::Termination::converged);
  int alone_iterations = 0, helped_iterations = 0;
  for (const StrategyRecord& record : alone.history) alone_iterations += record.iterations;
  for (const StrategyRecord& record : helped.history) helped_iterations += record.iterations;
  CHECK(helped_iterations < alone_iterations);
  for (const double t : {0.5, 1.3, 2.0}) {
    const std::vector<double> x = {t, 0.22, 1.13};
    // Each within its tolerance, carried over two slabs.
    CHECK((alone.value_at(x) - helped.value_at(x)).cwiseAbs().maxCoeff() <= 1e-5);
  }
}

TEST_CASE("a march ends with the status of what stopped it, and names the place") {
  // f is not finite beyond x = 0.5, which a part of the box reaches.
  const slab_systems::System wall(
      1, [](const Vector& x, const Vector& q) { return Vector(q.array() * (0.5 - x.array()).sqrt()); },
      [](const Vector& x, const Vector& q) {
        return Matrix::Constant(1, 1, -0.5 * q[0] / std::sqrt(0.5 - x[0]));
      });
  const auto picard = cross_strategy({.newton = false});
  const StrategyTrial beyond = try_strategy(logistic_problem(wall, 4.0, 1), *picard, {.tolerance = 1e-6});
  CAPTURE(beyond.message);
  CHECK(beyond.status == samara::Termination::not_finite);
  CHECK_THAT(beyond.message, Contains("f is not finite") && Contains("q = "));
  REQUIRE(beyond.where.size() == 1);

  const slab_systems::System swing = slab_systems::pendulum();
  const auto newton = cross_strategy();
  const StrategyTrial few = try_strategy(swing_problem(swing), *newton, {.tolerance = 1e-8, .max_rank = 2});
  CAPTURE(few.message);
  CHECK(few.status == samara::Termination::rank_limit);
  CHECK_THAT(few.message, Contains("ranks up to 2"));

  const StrategyTrial bounded =
      try_strategy(swing_problem(swing), *newton, {.tolerance = 1e-6, .max_evaluations = 500});
  CHECK(bounded.status == samara::Termination::max_calls);
  CHECK_THAT(bounded.message, Contains("500 evaluations"));

  int reports = 0;
  StrategyTrialOptions stopping{.tolerance = 1e-6};
  stopping.progress = [&](const samara::Progress& report) {
    CHECK(report.stage.starts_with("slab "));
    return ++reports < 3;
  };
  CHECK(try_strategy(swing_problem(swing), *newton, stopping).status == samara::Termination::cancelled);
  CHECK(reports == 3);
}

namespace {

/// Solves x' = q, but in one corner of the box falls behind at first, as an iteration does whose Jacobian is
/// wrong there: by 1e-2, 5e-3 and no more.
class WrongInACorner final : public Strategy {
 public:
  std::string name() const override { return "wrong in a corner"; }
  samara::Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain&,
                                        std::optional<double>) override {
    const double wrong = iteration_ == 0 ? 1e-2 : iteration_ == 1 ? 5e-3 : 0.0;
    ++iteration_;
    const EntryFunction source = [&](const IndexBatch& entries, Matrix& values) {
      values = slab.parameters_at(entries).topRows(1).replicate(slab.rows(), 1);
      for (Eigen::Index j = 0; j < entries.cols(); ++j) {
        if (entries.col(j).isZero()) values.col(j).array() += wrong;
      }
    };
    CrossPivots pivots;
    pivots.right = {IndexBatch(), IndexBatch::Zero(1, 1)};
    return LinearSlab{{}, *slab.separate(source, slab.rows(), 1e-6, pivots, "f")};
  }

 private:
  int iteration_ = 0;
};

}  // namespace

TEST_CASE("small corrections all over the box do not hide a corner in which the equations do not hold") {
  const slab_systems::System system(
      1, [](const Vector&, const Vector& q) { return Vector(q.head(1)); },
      [](const Vector&, const Vector&) { return Matrix(Matrix::Zero(1, 1)); });
  const EvolutionProblem problem{&system,
                                 Axis::radau({"t"}, 0.0, 1.0, 1, 4),
                                 {Axis::chebyshev({"q"}, 0.5, 1.0, 6), Axis::chebyshev({"r"}, 0.0, 1.0, 6)},
                                 {{"x"}},
                                 {1.0},
                                 {{0.0, -1}}};
  WrongInACorner strategy;
  const StrategyTrial result = try_strategy(problem, strategy, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(std::abs(result.value_at(std::vector{1.0, 0.5, 0.0})[0] - 0.5) <= 1e-3);
}

namespace {

/// Solves x' = q with a source that is 0.9 q twice, said to be rough, and q from then on.
class RoughAtFirst final : public Strategy {
 public:
  std::string name() const override { return "rough at first"; }
  samara::Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain&,
                                        std::optional<double>) override {
    const bool rough = iteration_++ < 2;
    const EntryFunction source = [&](const IndexBatch& entries, Matrix& values) {
      values = (rough ? 0.9 : 1.0) * slab.parameters_at(entries).topRows(1).replicate(slab.rows(), 1);
    };
    CrossPivots pivots;
    return LinearSlab{{}, *slab.separate(source, slab.rows(), 1e-6, pivots, "f"), rough};
  }

 private:
  int iteration_ = 0;
};

}  // namespace

TEST_CASE("an iteration with a rough source is never the last, however small its correction") {
  const slab_systems::System system(
      1, [](const Vector&, const Vector& q) { return Vector(q.head(1)); },
      [](const Vector&, const Vector&) { return Matrix(Matrix::Zero(1, 1)); });
  const EvolutionProblem problem{
      &system,    Axis::radau({"t"}, 0.0, 1.0, 1, 4), {Axis::chebyshev({"q"}, 0.5, 1.0, 6)}, {{"x"}}, {1.0},
      {{0.0, -1}}};
  RoughAtFirst strategy;
  // The second iterate is the first: its correction is round-off.
  const StrategyTrial result = try_strategy(problem, strategy, {.tolerance = 1e-4});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(std::abs(result.value_at(std::vector{1.0, 0.7})[0] - 0.7) <= 1e-4);
}

TEST_CASE("slopes in a parameter are taken by steps of its own size, wherever the points are") {
  const slab_systems::System root(
      1, [](const Vector&, const Vector& q) { return Vector(q.cwiseSqrt()); },
      [](const Vector&, const Vector&) { return Matrix(Matrix::Zero(1, 1)); });
  // One point; the parameter has a range among training states, or is the same for all.
  for (const double other : {3e-6, 1e-6}) {
    const TrainingStates training{Vector::Zero(2), Matrix::Zero(1, 2), Eigen::RowVector2d(1e-6, other)};
    const PiecewiseLinearSystem linear(root, training, 1);
    CHECK(linear.source(1)(0, 0) == Approx(500.0).epsilon(1e-5));
  }
}

TEST_CASE("training trajectories that end too early are a status of the march, not a caller's mistake") {
  // x' = x^2 from 1 on ends at t = 1, long before the last of many points could be picked.
  const PolynomialSystem system(1, 1, {{0, 1.0, {1}, {2}}});
  const EvolutionProblem problem{
      &system,    Axis::radau({"t"}, 0.0, 40.0, 2, 4), {Axis::chebyshev({"q"}, 1.0, 2.0, 5)}, {{"x"}}, {1.0},
      {{1.0, -1}}};
  const auto strategy = piecewise_linear_strategy({.points = 1000, .samples = 1});
  const StrategyTrial result = try_strategy(problem, *strategy, {.tolerance = 1e-3});
  CHECK(result.status == samara::Termination::not_finite);
  CHECK_THAT(result.message, Contains("training trajectories end"));
  CHECK(result.pieces.empty());
}

TEST_CASE("a polynomial system of other parameters than the problem's axes is refused") {
  const PolynomialSystem system(1, 2, {{0, 1.0, {1, 0}, {1}}});
  const auto strategy = incremental_strategy();
  CHECK_THROWS_WITH(try_strategy(logistic_problem(system, 1.0, 2), *strategy),
                    Contains("has 2 parameters, the problem 1 axes"));
}

TEST_CASE(
    "the Jacobian of a polynomial system is that of its differences, and its split that of its powers") {
  const PolynomialSystem system(3, 2,
                                {{0, 2.0, {1, 0}, {2, 0, 1}},
                                 {0, -1.0, {}, {0, 3, 0}},
                                 {1, 0.5, {0, 1}, {1, 1, 1}},
                                 {2, 4.0, {0, 0}, {0, 0, 0}}});
  CHECK(system.affine_in_parameters());
  CHECK_FALSE(PolynomialSystem(1, 2, {{0, 1.0, {1, 1}, {0}}}).affine_in_parameters());
  CHECK(system.polynomial() == &system);
  const Vector t = Vector::Zero(1);
  const Matrix x = (Matrix(3, 1) << 0.7, -1.2, 0.4).finished();
  const Matrix q = (Matrix(2, 1) << 1.5, -0.8).finished();
  Matrix jacobian, above, below;
  system.jacobian(t, x, q, jacobian);
  constexpr double kStep = 1e-5;
  for (int k = 0; k < 3; ++k) {
    Matrix shifted = x;
    shifted(k, 0) += kStep;
    system.rhs(t, shifted, q, above);
    shifted(k, 0) -= 2.0 * kStep;
    system.rhs(t, shifted, q, below);
    // Differences of cubics err by step^2 and by rounding over the step.
    CHECK(((above - below) / (2.0 * kStep) - jacobian.middleRows(3 * k, 3)).cwiseAbs().maxCoeff() < 1e-9);
  }
  CHECK_THROWS_WITH(PolynomialSystem(1, 1, {{1, 1.0}}), Contains("one of 1 states"));
  CHECK_THROWS_WITH(PolynomialSystem(1, 1, {{0, 1.0, {1, 2}}}), Contains("parameter powers"));
}
