#include <cmath>
#include <numeric>
#include <tuple>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/evolution/slab_cell.h"
#include "samara/pgd/evolution/slab_collocation.h"
#include "slab_systems.h"

using namespace samara::pgd;
using namespace slab_systems;
using Catch::Matchers::Contains;

TEST_CASE("slabs meet their tolerance on the coupled products (6.22), at random points off the grid") {
  const System system = triple_product();
  const AdaptiveProblem problem = triple_problem(system, 0.8);
  for (const double tolerance : {1e-3, 1e-6}) {
    const SlabResult result = solve_by_slabs(problem, {.tolerance = tolerance});
    CAPTURE(tolerance, result.message);
    CHECK(result.status == samara::Termination::converged);
    CHECK(result.reached == 0.8);
    const double error = largest_error(result, problem, system, 0.8, 2000, 3);
    CHECK(error <= tolerance);
    // The error that the guard points carry along is the true one, but for how few they are.
    CHECK(result.error <= tolerance);
    CHECK(result.error >= 0.1 * error);
  }
}

TEST_CASE("a box in which the solution ends reports when and where, and keeps what is valid") {
  const System system = triple_product();
  const AdaptiveProblem problem = triple_problem(system, 1.0);
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3, .max_cells = 64});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::ceases);
  CHECK_THAT(result.message, Contains("grows beyond all bounds"));
  // From (0, 1, 1) the solution blows up at t = 0.953.
  CHECK(result.reached == Approx(0.953).margin(0.005));
  REQUIRE(result.where.size() == 3);
  CHECK(result.where[0] == Approx(0.0).margin(0.02));
  CHECK(result.where[1] == Approx(1.0).margin(0.02));
  CHECK(result.where[2] == Approx(1.0).margin(0.02));
  REQUIRE(!result.pieces.empty());
  for (const TrainField& field : result.pieces) CHECK(field.axes()[0].upper() <= result.reached);
}

TEST_CASE("a rate that is no number at the start is named, and not taken for growth") {
  const System system(
      1, [](const Vector& x, const Vector& q) { return Vector(q * std::log(x[0] - 2.0)); },
      [](const Vector& x, const Vector& q) { return Matrix(q / (x[0] - 2.0)); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 1.0;
  problem.parameters = {{{"k", "1"}, 1.0, 2.0}};
  problem.states = {{"x", "1"}};
  problem.initial = {{1.0, -1}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::not_finite);
  CHECK_THAT(result.message, Contains("the right-hand side is not finite (the rate of \"x\" is "));
  CHECK(result.pieces.empty());
}

TEST_CASE("an offset that is large against the range is no growth") {
  // x' = c (s + 1 - x): from s towards s + 1, by less than 0.002 until t = 1.
  constexpr double kStart = 1e5;
  const System system(
      1, [](const Vector& x, const Vector& q) { return Vector(q * (kStart + 1.0 - x[0])); },
      [](const Vector&, const Vector& q) { return Matrix(-q); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 1.0;
  problem.parameters = {{{"c", "1"}, 1e-3, 2e-3}};
  problem.states = {{"x", "1"}};
  problem.initial = {{kStart, -1}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-4});
  CAPTURE(result.message);
  REQUIRE(result.status == samara::Termination::converged);
  const double value = result.pieces.back()(std::vector{1.0, 1.5e-3})[0];
  CHECK(value - kStart == Approx(-std::expm1(-1.5e-3)).epsilon(1e-4));
}

TEST_CASE("where neighbours part, cells go on, and without them the march ends with the axis") {
  const System system = double_well();
  const AdaptiveProblem problem = well_problem(system, 6.0);
  const SlabOptions one{.tolerance = 1e-4, .max_nodes = 24};
  const SlabResult stuck = solve_by_slabs(problem, one);
  CAPTURE(stuck.message);
  CHECK(stuck.status == samara::Termination::not_resolved);
  CHECK_THAT(stuck.message, Contains("24 nodes on the axis x(0)"));
  CHECK(stuck.reached < 6.0);
  REQUIRE(!stuck.pieces.empty());
  CHECK(largest_error(stuck, problem, system, stuck.reached, 500, 1) <= 1e-4);

  SlabOptions many = one;
  many.max_cells = 32;
  const SlabResult result = solve_by_slabs(problem, many);
  CAPTURE(result.message, result.cells);
  CHECK(result.status == samara::Termination::converged);
  CHECK(result.cells > 1);
  CHECK(result.cells <= 32);
  CHECK(largest_error(result, problem, system, 6.0, 2000, 2) <= 1e-4);
}

TEST_CASE("a stiff box, on which Picard's iteration does not contract, is solved by Newton's") {
  // x' = -k (x - 1) with k up to 200: a slab holds many time constants.
  const System system(
      1, [](const Vector& x, const Vector& q) { return Vector(-q[0] * (x.array() - 1.0)); },
      [](const Vector&, const Vector& q) { return Matrix::Constant(1, 1, -q[0]); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 1.0;
  problem.parameters = {{{"k", "1/s", AxisRole::parameter, Transform::logarithm}, 50.0, 200.0}};
  problem.states = {{"x", "1"}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  problem.initial = {{0.0, -1}};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-4});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(largest_error(result, problem, system, 1.0, 300, 4) <= 1e-4);
  // At the end, slabs are longer than Picard's iteration could bear.
  CHECK(200.0 * (result.history.back().end - result.history.back().begin) > 10.0);
}

TEST_CASE("a kink that sweeps through the box gets elements of its own length, and few slabs") {
  // x' turns from -1 to 1 within a thousandth of the whole time.
  const System system = turning_at_q(1e-3, 0.0);
  const AdaptiveProblem problem = turning_problem(system, 0.45, 0.55);
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(largest_error(result, problem, system, 1.0, 1000, 7) <= 1e-3);
  // Elements of the kink's width all over its range, as many as that takes; outside of it, slabs are long.
  double longest_outside = 0.0;
  int elements_inside = 0;
  for (const SlabRecord& slab : result.history) {
    if (slab.end < 0.44 || slab.begin > 0.56)
      longest_outside = std::max(longest_outside, slab.end - slab.begin);
    if (slab.begin > 0.45 && slab.end < 0.55) elements_inside += slab.elements;
  }
  CHECK(longest_outside >= 0.1);
  CHECK(elements_inside >= 10);
  CHECK(result.history.size() <= 40);
}

TEST_CASE("short elements at a kink share slabs, as each slab rounds the state anew and errors grow") {
  const System system = turning_at_q(1e-3, 6.0);
  const AdaptiveProblem problem = turning_problem(system, 0.4, 0.6);
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.reached == 1.0);
  CHECK(largest_error(result, problem, system, 1.0, 200, 7, 1e-4) <= 1e-3);
  int elements = 0, slabs = 0;
  for (const SlabRecord& slab : result.history) {
    if (slab.begin <= 0.4 || slab.end >= 0.6) continue;
    elements += slab.elements;
    ++slabs;
  }
  CHECK(elements >= 15);
  CHECK(2 * elements >= 3 * slabs);
}

TEST_CASE("slabs cost far fewer evaluations than their grids where there are many parameters") {
  // Six oscillators' phases: x' = -q_k coupled in a chain.
  const System system(
      2,
      [](const Vector& x, const Vector& q) {
        return Vector(Eigen::Vector2d(x[1], -(1.0 + 0.2 * q.sum()) * std::sin(x[0])));
      },
      [](const Vector& x, const Vector& q) {
        return (Matrix(2, 2) << 0.0, 1.0, -(1.0 + 0.2 * q.sum()) * std::cos(x[0]), 0.0).finished();
      });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 3.0;
  for (const char* name : {"q1", "q2", "q3", "q4", "q5", "q6"})
    problem.parameters.push_back({{name, "1"}, 0.0, 1.0});
  problem.states = {{"x", "1"}, {"v", "1"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{1.0, -1}, {0.0, -1}};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(largest_error(result, problem, system, 3.0, 500, 5) <= 1e-3);
  CHECK(static_cast<double>(result.evaluations) < 0.05 * result.grid_evaluations);
}

TEST_CASE("a jump of f, which no polynomial follows, is not mistaken for the end of the solution") {
  // A clock, and x' = q until it shows 0.4321, then -q.
  const System system(
      2,
      [](const Vector& x, const Vector& q) {
        return Vector(Eigen::Vector2d(1.0, x[0] < 0.4321 ? q[0] : -q[0]));
      },
      [](const Vector&, const Vector&) { return Matrix(Matrix::Zero(2, 2)); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 1.0;
  problem.parameters = {{{"q", "1"}, 1.0, 2.0}};
  problem.states = {{"clock", "s"}, {"x", "s"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{0.0, -1}, {0.0, -1}};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-6});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::not_resolved);
  CHECK_THAT(result.message, Contains("no polynomial follows"));
  CHECK(result.reached == Approx(0.4321).margin(1e-3));
  // The point it names is that of the largest jump.
  REQUIRE(result.where.size() == 1);
  CHECK(result.where[0] == Approx(2.0));
}

TEST_CASE("a march at smaller tolerances that ends early leaves the one before it, which reached the end") {
  const System system = turning_at_q(5e-4, 6.0);
  const AdaptiveProblem problem = turning_problem(system, 0.4, 0.6);
  // What the first march takes; the tolerance is one that it misses.
  SlabOptions options{.tolerance = 1e-3, .max_marches = 1};
  const SlabResult one = solve_by_slabs(problem, options);
  REQUIRE(one.status == samara::Termination::missed);
  options.max_marches = 4;
  SECTION("the budget is spent within the second march") {
    options.max_evaluations = one.evaluations + 1000;
  }
  SECTION("the budget is spent when the first ends") {
    options.max_evaluations = one.evaluations;
  }
  std::vector<std::vector<double>> states;
  options.checkpoint = [&](const std::vector<double>& state) { states.push_back(state); };
  const SlabResult cut = solve_by_slabs(problem, options);
  CAPTURE(cut.message);
  CHECK(cut.status == samara::Termination::missed);
  CHECK_THAT(cut.message, Contains("evaluations used"));
  CHECK(cut.marches == 2);
  CHECK(cut.reached == 1.0);
  CHECK(cut.error == one.error);
  CHECK(cut.pieces.size() == one.pieces.size());
  CHECK(largest_error(cut, problem, system, 1.0, 200, 3, 1e-4) <= 2.0 * one.error);
  // A resumed build knows it too.
  const SlabResult resumed = solve_by_slabs(problem, options, states.back());
  CHECK(resumed.status == samara::Termination::missed);
  CHECK(resumed.error == one.error);
  CHECK(resumed.message == cut.message);
}

TEST_CASE("a march whose guard points go where the equations have no value is missed, without bound") {
  // A train of two nodes stays far below what lies between them, and never leaves where there are rates.
  const System system(
      1,
      [](const Vector& x, const Vector& q) {
        return Vector::Constant(1, x[0] > 0.7 ? std::nan("") : 0.05 + 4.0 * q[0] * (1.0 - q[0]));
      },
      [](const Vector&, const Vector&) { return Matrix::Zero(1, 1); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.parameters = {{{"q", "1"}, 0.0, 1.0, 2}};
  problem.states = {{"x", "1"}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  problem.initial = {{0.0, -1}};
  const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-3});
  CAPTURE(result.message);
  CHECK(result.status == samara::Termination::missed);
  CHECK(result.reached == 1.0);
  CHECK(std::isinf(result.error));
  CHECK_FALSE(result.pieces.empty());
}

TEST_CASE("each half of a cell of many axes has a guard point, however few are asked for") {
  const System system(
      1, [](const Vector& x, const Vector&) { return x; },
      [](const Vector&, const Vector&) { return Matrix::Identity(1, 1); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.states = {{"x", "1"}};
  problem.initial = {{1.0, -1}};
  for (const char* name : {"a", "b", "c", "d", "e", "f"})
    problem.parameters.push_back({{name, "1"}, 0.0, 1.0});
  Random random(1);
  const SlabCell cell = whole_box(problem, Vector::Ones(1), std::vector<int>(6, 2), 1, random);
  for (const SlabCell& half : halves(cell, problem, Vector::Ones(1), 0, 1, random))
    CHECK(half.guards.cols() >= 1);
}

TEST_CASE("states that start at a coordinate under a transform start where they say") {
  // Polynomials in -1/x or log x do not hold x.
  const System system(
      1, [](const Vector& x, const Vector&) { return Vector(-x); },
      [](const Vector&, const Vector&) { return Matrix::Constant(1, 1, -1.0); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 1.0;
  problem.states = {{"x", "1"}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  problem.initial = {{0.0, 0}};
  const auto start_error = [](const SlabResult& result, double lower, double upper) {
    double largest = 0.0;
    for (int i = 0; i <= 50; ++i) {
      const double x = lower + (upper - lower) * i / 50.0;
      largest = std::max(largest, std::abs(value_at(result, std::vector{0.0, x})[0] - x));
    }
    return largest / (upper - lower);
  };
  for (const auto& [transform, lower, upper] :
       {std::tuple(Transform::reciprocal, 0.1, 10.0), {Transform::logarithm, 0.01, 100.0}}) {
    problem.parameters = {{{"x(0)", "1", AxisRole::initial, transform}, lower, upper}};
    const SlabResult result = solve_by_slabs(problem, {.tolerance = 1e-4});
    CAPTURE(to_string(transform), result.message, result.error);
    REQUIRE(result.status == samara::Termination::converged);
    CHECK(start_error(result, lower, upper) <= 1e-4);
    CHECK(largest_error(result, problem, system, 1.0, 500, 6) <= 1e-4);
    // Too few nodes are not taken for enough, and cells make up for them.
    const SlabOptions few{.tolerance = 1e-4, .max_nodes = 9};
    CHECK(solve_by_slabs(problem, few).status == samara::Termination::not_resolved);
    SlabOptions many = few;
    many.max_cells = 64;
    const SlabResult cells = solve_by_slabs(problem, many);
    CAPTURE(cells.message, cells.cells);
    REQUIRE(cells.status == samara::Termination::converged);
    CHECK(start_error(cells, lower, upper) <= 1e-4);
  }
}

TEST_CASE("a state that stays where it is needs one iteration and no derivatives") {
  bool is_derived = false;
  const System still(
      1, [](const Vector& x, const Vector&) { return Vector(-3.0 * x); },
      [&](const Vector&, const Vector&) {
        is_derived = true;
        return Matrix::Constant(1, 1, -3.0);
      });
  const SlabPoints points = SlabCollocation(still, Vector::Ones(1), 8)
                                .solve({0.0, 1.0}, Matrix::Zero(1, 1), Matrix::Ones(1, 1), 1e-8);
  CHECK(points.first_failed() == -1);
  CHECK(points.values.isZero(0.0));
  CHECK(points.evaluations == 8);
  CHECK_FALSE(is_derived);
}

TEST_CASE("a march that may not go on says so: by evaluations, by its caller") {
  const System system = triple_product();
  const AdaptiveProblem problem = triple_problem(system, 0.8);
  const SlabResult few = solve_by_slabs(problem, {.max_evaluations = 20000});
  CHECK(few.status == samara::Termination::max_calls);
  CHECK_THAT(few.message, Contains("20000 allowed, at t = ") && Contains("took") && Contains("ranks up to"));
  // Where it stands: the middle of the box, its only cell.
  CHECK(few.where == std::vector<double>(3, 0.5));
  int reports = 0;
  const SlabResult cancelled =
      solve_by_slabs(problem, {.progress = [&](const samara::Progress&) { return ++reports < 3; }});
  CHECK(cancelled.status == samara::Termination::cancelled);
  CHECK(reports == 3);
}

TEST_CASE("the same march twice gives the same bits") {
  const System system = triple_product();
  const AdaptiveProblem problem = triple_problem(system, 0.5);
  const SlabResult a = solve_by_slabs(problem, {.tolerance = 1e-5});
  const SlabResult b = solve_by_slabs(problem, {.tolerance = 1e-5});
  REQUIRE(a.pieces.size() == b.pieces.size());
  for (std::size_t k = 0; k < a.pieces.size(); ++k) {
    for (std::size_t c = 0; c < a.pieces[k].train().cores.size(); ++c)
      CHECK(a.pieces[k].train().cores[c].data == b.pieces[k].train().cores[c].data);
  }
}

TEST_CASE("a march goes on from any of its states to the same bits, in cells too") {
  const System system = double_well();
  const AdaptiveProblem problem = well_problem(system, 3.0);
  const SlabOptions options{.tolerance = 1e-3, .max_nodes = 12, .max_cells = 8};
  const SlabResult whole = solve_by_slabs(problem, options);
  CHECK(whole.cells > 1);
  const std::vector<std::vector<double>> states =
      stored_states([&](const SlabOptions& storing) { solve_by_slabs(problem, storing); }, options, 5);
  REQUIRE(states.size() >= 5);
  for (const std::size_t from : {std::size_t{0}, states.size() / 2, states.size() - 1}) {
    const SlabResult result = solve_by_slabs(problem, options, states[from]);
    CHECK(result.evaluations == whole.evaluations);
    CHECK(result.error == whole.error);
    REQUIRE(result.pieces.size() == whole.pieces.size());
    for (std::size_t k = 0; k < result.pieces.size(); ++k) {
      for (std::size_t a = 0; a < result.pieces[k].axes().size(); ++a)
        CHECK(result.pieces[k].axes()[a].nodes() == whole.pieces[k].axes()[a].nodes());
      for (std::size_t c = 0; c < result.pieces[k].train().cores.size(); ++c)
        CHECK(result.pieces[k].train().cores[c].data == whole.pieces[k].train().cores[c].data);
    }
  }
  // States that are cut short, or of other options, are refused.
  std::vector<double> state = states.back();
  state.resize(state.size() / 2);
  CHECK_THROWS_WITH(solve_by_slabs(problem, options, state), Contains("the stored state of a solver"));
  state = states.back();
  state.push_back(0.0);
  CHECK_THROWS_WITH(solve_by_slabs(problem, options, state), Contains("longer than its march"));
  state = states.back();  // at its end how many states, and the largest of each
  state.pop_back();
  state[state.size() - 2] = 1.0;
  CHECK_THROWS_WITH(solve_by_slabs(problem, options, state), Contains("does not fit its problem"));
  const auto refused = [&](const AdaptiveProblem& other, const SlabOptions& others) {
    CHECK_THROWS_WITH(solve_by_slabs(other, others, states.back()), Contains("other options"));
  };
  SlabOptions others = options;
  others.tolerance = 1e-4;
  refused(problem, others);
  others = options;
  others.seed = 2;
  refused(problem, others);
  others = options;
  others.max_rank = 50;
  refused(problem, others);
  AdaptiveProblem other = problem;
  other.parameters[0].upper = 0.4;
  refused(other, options);
  other = problem;
  other.initial[1].value = 0.1;
  refused(other, options);
  other = problem;
  other.scale_floors[0] = 0.1;
  refused(other, options);
}

TEST_CASE("options and problems that make no sense are refused") {
  const System system = triple_product();
  AdaptiveProblem problem = triple_problem(system, 0.8);
  CHECK_THROWS_AS(solve_by_slabs(problem, {.tolerance = 0.0}), samara::ArgumentError);
  CHECK_THROWS_AS(solve_by_slabs(problem, {.first_nodes = 9, .max_nodes = 8}), samara::ArgumentError);
  CHECK_THROWS_AS(solve_by_slabs(problem, {.guards = 0}), samara::ArgumentError);
  problem.scale_floors.clear();
  CHECK_THROWS_WITH(solve_by_slabs(problem), Contains("0 scale floors"));
  CHECK_THROWS_WITH(solve_by_slabs(triple_problem(system, 0.8), {.max_evaluations = -1}),
                    Contains("max_evaluations is -1"));
  CHECK_THROWS_WITH(solve_by_slabs(triple_problem(system, 0.8), {.joint_slab = std::nan("")}),
                    Contains("joint_slab is nan"));
  problem = triple_problem(system, 0.8);
  problem.initial[1].axis = 3;
  CHECK_THROWS_WITH(solve_by_slabs(problem), Contains("axis 3 of 3"));
  problem = triple_problem(system, 0.8);
  problem.scales[2] = 0.0;
  CHECK_THROWS_WITH(solve_by_slabs(problem), Contains("the scale of u3 is 0"));
  problem = triple_problem(system, 0.8);
  problem.time.transform = Transform::logarithm;
  CHECK_THROWS_WITH(solve_by_slabs(problem), Contains("without a transform"));
  problem = triple_problem(system, -1.0);
  CHECK_THROWS_WITH(solve_by_slabs(problem), Contains("positive time"));
}
