#include "samara/pgd/evolution.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/random.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;

namespace {

using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// x' = f(t, x, q) point by point, with a count of the points asked for.
class TestSystem : public EvolutionSystem {
 public:
  using Rate = std::function<Vector(double t, const Vector& x, const Vector& q)>;
  using Derivative = std::function<Matrix(double t, const Vector& x, const Vector& q)>;
  TestSystem(int states, Rate rate, Derivative derivative)
      : states_(states), rate_(std::move(rate)), derivative_(std::move(derivative)) {}

  int state_count() const override { return states_; }
  void rhs(const Vector& t, const Matrix& x, const Matrix& q, Matrix& f) const override {
    if (rhs_counts_.size() == jacobian_counts_.size()) rhs_counts_.push_back(0);
    rhs_counts_.back() += t.size();
    f.resize(states_, t.size());
    for (Eigen::Index j = 0; j < t.size(); ++j) f.col(j) = rate_(t[j], x.col(j), q.col(j));
  }
  void jacobian(const Vector& t, const Matrix& x, const Matrix& q, Matrix& jacobian) const override {
    if (jacobian_counts_.size() < rhs_counts_.size()) jacobian_counts_.push_back(0);
    jacobian_counts_.back() += t.size();
    jacobian.resize(states_ * states_, t.size());
    for (Eigen::Index j = 0; j < t.size(); ++j) {
      const Matrix one = derivative_(t[j], x.col(j), q.col(j));
      jacobian.col(j) = Eigen::Map<const Vector>(one.data(), one.size());
    }
  }

  /// Points of f, and of J, per iteration: an iteration begins with f and goes on with J.
  const std::vector<long>& rhs_counts() const { return rhs_counts_; }
  const std::vector<long>& jacobian_counts() const { return jacobian_counts_; }

 private:
  int states_;
  Rate rate_;
  Derivative derivative_;
  mutable std::vector<long> rhs_counts_, jacobian_counts_;
};

Vector one(double value) {
  return Vector::Constant(1, value);
}
Matrix one_by_one(double value) {
  return Matrix::Constant(1, 1, value);
}

/// k (u' + 1) = 10, (6.18).
TestSystem constant_rate() {
  return {1, [](double, const Vector&, const Vector& q) { return one(10.0 / q[0] - 1.0); },
          [](double, const Vector&, const Vector&) { return one_by_one(0.0); }};
}

/// Fall against quadratic drag, (6.20), with u' = -k |u| u - g.
struct Fall {
  static constexpr double kGravity = 9.81;  // m/s^2
  /// rho C_D A / (2 m) in 1/m for rho = 1.23 kg/m^3, A = 0.5 m^2, m = 0.1 kg.
  static double drag(double c_d) { return 1.23 * c_d * 0.5 / (2.0 * 0.1); }
  static double exact(double t, double c_d) {
    const double terminal = std::sqrt(kGravity / drag(c_d));
    return -terminal * std::tanh(kGravity * t / terminal);
  }
  TestSystem system{1,
                    [](double, const Vector& x, const Vector& q) {
                      return one(-drag(q[0]) * std::abs(x[0]) * x[0] - kGravity);
                    },
                    [](double, const Vector& x, const Vector& q) {
                      return one_by_one(-2.0 * drag(q[0]) * std::abs(x[0]));
                    }};
  EvolutionProblem problem(int elements, int points, int nodes) const {
    return {&system,
            Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, elements, points),
            {Axis::chebyshev({"C_D"}, 0.5, 2.0, nodes)},
            {{"u", "m/s"}},
            {2.5},
            {{0.0, -1}}};
  }
  /// Largest error at random points that are no nodes, relative to the largest speed.
  static double error(const SeparatedField& field) {
    Random random(5);
    double largest = 0.0;
    for (int i = 0; i < 1000; ++i) {
      const std::vector<double> x = {random.uniform(), 0.5 + 1.5 * random.uniform()};
      largest = std::max(largest, std::abs(field(x)[0] - exact(x[0], x[1])));
    }
    return largest / std::abs(exact(1.0, 0.5));
  }
};

/// x'' = -w^2 x with w, x(0) and v(0) as axes.
struct Oscillator {
  TestSystem system{2, [](double, const Vector& x, const Vector& q) { return Vector(matrix(q[0]) * x); },
                    [](double, const Vector&, const Vector& q) { return matrix(q[0]); }};
  static Matrix matrix(double w) { return (Matrix(2, 2) << 0.0, 1.0, -w * w, 0.0).finished(); }
  EvolutionProblem problem() const {
    return {&system,
            Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 4, 7),
            {Axis::chebyshev({"w", "1/s"}, 1.0, 2.0, 12),
             Axis::chebyshev({"x(0)", "m", AxisRole::initial}, -1.0, 2.0, 2),
             Axis::chebyshev({"v(0)", "m/s", AxisRole::initial}, -1.0, 1.0, 3)},
            {{"x", "m"}, {"v", "m/s"}},
            {2.0, 3.0},
            {{0.0, 1}, {0.0, 2}}};
  }
};

/// A body sinking in water, drag |v| v and added mass: a kink where it turns from rising to sinking.
struct Sinking {
  static constexpr double kDensity = 998.2, kArea = 4.714e-4, kThickness = 2.55e-3, kMass = 7.62e-3;  // SI
  static constexpr double kDisplaced = kDensity * kArea * kThickness;
  /// 8/3 rho r^3 of a disc of radius r.
  static double inertia() { return kMass + 8.0 / 3.0 * kDensity * std::pow(kArea / std::numbers::pi, 1.5); }
  static double rate(double v, double c_d) {
    return ((kMass - kDisplaced) * 9.81 - 0.5 * kDensity * c_d * kArea * std::abs(v) * v) / inertia();
  }
  TestSystem system{2,
                    [](double, const Vector& x, const Vector& q) {
                      return Vector(Eigen::Vector2d(rate(x[0], q[0]), x[0]));
                    },
                    [](double, const Vector& x, const Vector& q) {
                      return (Matrix(2, 2) << -kDensity * q[0] * kArea * std::abs(x[0]) / inertia(), 0.0, 1.0,
                              0.0)
                          .finished();
                    }};
  EvolutionProblem problem(int elements, int nodes) const {
    return {&system,
            Axis::radau({"t", "s", AxisRole::time}, 0.0, 0.5, elements, 6),
            {Axis::chebyshev({"C_D"}, 0.8, 1.6, 10),
             Axis::chebyshev({"v(0)", "m/s", AxisRole::initial}, -0.3, 0.6, nodes)},
            {{"v", "m/s"}, {"x", "m"}},
            {0.5, 0.1},
            {{0.0, 1}, {0.0, -1}}};
  }
  /// Runge-Kutta of fourth order with 4000 steps: 1e-12, at the kink at worst h^2 = 1e-8 of the speed.
  static Eigen::Vector2d exact(double t, double c_d, double v0) {
    const int steps = 4000;
    const double h = t / steps;
    double v = v0;
    double x = 0.0;
    for (int i = 0; i < steps; ++i) {
      const double k1 = rate(v, c_d);
      const double v2 = v + 0.5 * h * k1;
      const double k2 = rate(v2, c_d);
      const double v3 = v + 0.5 * h * k2;
      const double k3 = rate(v3, c_d);
      const double v4 = v + h * k3;
      x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
      v += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + rate(v4, c_d));
    }
    return {v, x};
  }
};

/// u' = -q u, u(0) = 1.
TestSystem decay() {
  return {1, [](double, const Vector& x, const Vector& q) { return one(-q[0] * x[0]); },
          [](double, const Vector&, const Vector& q) { return one_by_one(-q[0]); }};
}

EvolutionProblem decay_problem(const TestSystem& system, const Axis& time) {
  return {&system, time, {Axis::chebyshev({"q", "1/s"}, 1.0, 2.0, 12)}, {{"u"}}, {1.0}, {{1.0, -1}}};
}

/// u' = u^2: u = 1 / (1 / u(0) - t) ends at t = 1 / u(0).
TestSystem explosion() {
  return {1, [](double, const Vector& x, const Vector&) { return one(x[0] * x[0]); },
          [](double, const Vector& x, const Vector&) { return one_by_one(2.0 * x[0]); }};
}

EvolutionProblem explosion_problem(const TestSystem& system, double lower, double upper) {
  return {&system,
          Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 10, 5),
          {Axis::chebyshev({"u(0)", "1", AxisRole::initial}, lower, upper, 20)},
          {{"u"}},
          {1.0},
          {{0.0, 0}}};
}

std::string report(const EvolutionResult& result) {
  std::string text = to_string(result.status) + ": " + result.message + "; rank " +
                     std::to_string(result.field.rank()) + ", evaluations " +
                     std::to_string(result.rhs_evaluations) + " + " +
                     std::to_string(result.jacobian_evaluations) + " of " +
                     std::to_string(static_cast<long>(result.grid_size)) + ", " +
                     std::to_string(result.seconds) + " s; residuals";
  char number[32];
  for (const EvolutionRecord& record : result.history) {
    std::snprintf(number, sizeof number, " %.1e(%d)", record.residual, record.rank);
    text += number;
  }
  return text;
}

}  // namespace

TEST_CASE("the parametric line (6.18) is one product, to 1e-12") {
  const TestSystem system = constant_rate();
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    for (const double start : {0.0, 0.3}) {
      const EvolutionProblem problem{&system,
                                     Axis::radau({"t", "s", AxisRole::time}, 0.0, 10.0, 4, 3),
                                     {Axis::chebyshev({"k"}, 1.0, 10.0, 60)},
                                     {{"u"}},
                                     {90.0},
                                     {{start, -1}}};
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-13, .projection = projection});
      CAPTURE(report(result));
      CHECK(result.status == EvolutionStatus::converged);
      // The initial value is a term of its own.
      CHECK(result.field.rank() == (start == 0.0 ? 1 : 2));
      double error = 0.0;
      Random random(1);
      for (int i = 0; i < 1000; ++i) {
        const std::vector<double> x = {10.0 * random.uniform(), 1.0 + 9.0 * random.uniform()};
        // 60 Chebyshev nodes resolve 1 / k, whose pole lies 1.22 half lengths from the centre, to 1.9^-60.
        error = std::max(error, std::abs(result.field(x)[0] - start - (10.0 / x[1] - 1.0) * x[0]));
      }
      CHECK(error < 1e-12 * 90.0);  // 90 = largest |u|
    }
  }
}

TEST_CASE("quadratic drag (6.20) agrees with the exact solution to 1e-8") {
  const Fall fall;
  for (const Projection projection : {Projection::galerkin, Projection::minimal_residual}) {
    const EvolutionResult result = solve_evolution(
        fall.problem(10, 9, 20), {.tolerance = 1e-10, .projection = projection, .linear_tolerance = 0.03});
    CAPTURE(report(result), Fall::error(result.field));
    CHECK(result.status == EvolutionStatus::converged);
    CHECK(result.residual <= 1e-10);
    CHECK(Fall::error(result.field) <= 1e-8);
    CHECK(result.history.size() <= 12);
    CHECK(result.field.rank() <= 14);
  }
}

TEST_CASE("a linear oscillator with its initial values as axes is exact to 1e-8") {
  const Oscillator oscillator;
  const EvolutionResult result = solve_evolution(oscillator.problem(), {.tolerance = 1e-10});
  double error = 0.0;
  Random random(2);
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> x = {random.uniform(), 1.0 + random.uniform(), -1.0 + 3.0 * random.uniform(),
                                   -1.0 + 2.0 * random.uniform()};
    const double c = std::cos(x[1] * x[0]);
    const double s = std::sin(x[1] * x[0]);
    const Vector u = result.field(x);
    error = std::max(
        {error, std::abs(u[0] - x[2] * c - x[3] / x[1] * s), std::abs(u[1] + x[1] * x[2] * s - x[3] * c)});
  }
  CAPTURE(report(result), error);
  CHECK(result.status == EvolutionStatus::converged);
  CHECK(error <= 1e-8);
}

TEST_CASE("the solution converges with the order of the time elements") {
  // u' = -q u. s Radau points: order s + 1 between the nodes, 2 s - 1 at the ends of the elements.
  const TestSystem system = decay();
  for (const int s : {1, 2, 3}) {
    const auto errors = [&](int elements) {
      const EvolutionProblem problem = decay_problem(system, Axis::radau({"t", "s"}, 0.0, 1.0, elements, s));
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-12});
      REQUIRE(result.status == EvolutionStatus::converged);
      Random random(6);
      double between = 0.0;
      for (int i = 0; i < 1000; ++i) {
        const std::vector<double> x = {random.uniform(), 1.0 + random.uniform()};
        between = std::max(between, std::abs(result.field(x)[0] - std::exp(-x[1] * x[0])));
      }
      return std::pair(between, std::abs(result.field(std::vector<double>{1.0, 2.0})[0] - std::exp(-2.0)));
    };
    const auto coarse = errors(6);
    const auto fine = errors(12);
    CAPTURE(s, coarse.first, fine.first, coarse.second, fine.second);
    // One point per element is the implicit Euler method: its error of first order at the ends is everywhere.
    CHECK(std::log2(coarse.first / fine.first) > (s == 1 ? 1 : s + 1) - 0.2);
    CHECK(std::log2(coarse.second / fine.second) > 2 * s - 1 - 0.2);
  }
}

TEST_CASE("every kind of axis serves for time and for parameters") {
  const TestSystem system = decay();
  const auto error = [&](const Axis& time, const Axis& parameter) {
    EvolutionProblem problem = decay_problem(system, time);
    problem.parameters = {parameter};
    const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-10});
    REQUIRE(result.status == EvolutionStatus::converged);
    Random random(7);
    double largest = 0.0;
    for (int i = 0; i < 500; ++i) {
      const std::vector<double> x = {random.uniform(), 1.0 + random.uniform()};
      largest = std::max(largest, std::abs(result.field(x)[0] - std::exp(-x[1] * x[0])));
    }
    return largest;
  };
  const Axis smooth = Axis::chebyshev({"q"}, 1.0, 2.0, 12);
  CHECK(error(Axis::chebyshev({"t", "s"}, 0.0, 1.0, 14), smooth) < 1e-9);
  CHECK(error(Axis::radau({"t", "s"}, 0.0, 1.0, 5, 7), Axis::radau({"q"}, 1.0, 2.0, 2, 7)) < 1e-9);
  // Linear elements: in time the implicit Euler method, h / 2 max |u''| e..; in q h^2 / 8 max |d2u/dq2|.
  CHECK(error(Axis::p1({"t", "s"}, 0.0, 1.0, 101), smooth) < 0.5 * 0.01 * 4.0);
  CHECK(error(Axis::radau({"t", "s"}, 0.0, 1.0, 5, 7), Axis::p1({"q"}, 1.0, 2.0, 21)) <
        0.05 * 0.05 / 8.0 * 0.54);
}

TEST_CASE("time enters in its own unit and from where the axis starts") {
  // u' = q cos t from u(1) = 0: u = q (sin t - sin 1), one product.
  const TestSystem system(
      1, [](double t, const Vector&, const Vector& q) { return one(q[0] * std::cos(t)); },
      [](double, const Vector&, const Vector&) { return one_by_one(0.0); });
  const EvolutionProblem problem{&system,
                                 Axis::radau({"t", "s", AxisRole::time}, 1.0, 4.0, 6, 7),
                                 {Axis::chebyshev({"q"}, -1.0, 2.0, 4)},
                                 {{"u"}},
                                 {0.1},
                                 {{0.0, -1}}};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-9});
  REQUIRE(result.status == EvolutionStatus::converged);
  CHECK(result.field.rank() == 1);
  for (const double t : {1.0, 1.3, 2.5, 4.0}) {
    CHECK(result.field(std::vector<double>{t, 1.7})[0] ==
          Approx(1.7 * (std::sin(t) - std::sin(1.0))).margin(1e-9));
  }
}

TEST_CASE("initial values are met exactly") {
  const Oscillator oscillator;
  const EvolutionResult result = solve_evolution(oscillator.problem(), {.tolerance = 1e-6});
  for (const double x0 : {-1.0, 0.3, 2.0}) {
    const Vector u = result.field(std::vector<double>{0.0, 1.4, x0, -0.7});
    CHECK(u[0] == Approx(x0).epsilon(1e-14));
    CHECK(u[1] == Approx(-0.7).epsilon(1e-14));
  }
}

TEST_CASE("a body that turns from rising to sinking agrees with Runge-Kutta to 1e-4") {
  const Sinking sinking;
  const EvolutionResult result = solve_evolution(sinking.problem(8, 30), {.tolerance = 1e-5});
  double error = 0.0;
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    const std::vector<double> x = {0.5 * random.uniform(), 0.8 + 0.8 * random.uniform(),
                                   -0.3 + 0.9 * random.uniform()};
    const Eigen::Vector2d exact = Sinking::exact(x[0], x[1], x[2]);
    const Vector u = result.field(x);
    // In parts of the ranges, 0.9 m/s and 0.25 m.
    error = std::max({error, std::abs(u[0] - exact[0]) / 0.9, std::abs(u[1] - exact[1]) / 0.25});
  }
  CAPTURE(report(result), error);
  CHECK(result.status == EvolutionStatus::converged);
  CHECK(error < 1e-4);
}

TEST_CASE("a solution that ends inside the box is never reported as converged") {
  const TestSystem system = explosion();
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const EvolutionResult result =
        solve_evolution(explosion_problem(system, 0.5, 1.5), {.tolerance = 1e-6, .seed = seed});
    CAPTURE(report(result));
    CHECK(result.status == EvolutionStatus::diverged);
    CHECK(result.residual > 1e-6);
    CHECK_THAT(result.message, Contains("may not exist on the whole box"));
  }
  // Nor on axes so coarse that the equations of the collocation might have solutions of their own, nor where
  // only a corner of the box is concerned.
  for (const double upper : {1.02, 1.1, 3.0}) {
    for (const auto& [elements, points] : {std::pair{1, 2}, {1, 3}, {2, 3}, {4, 4}}) {
      EvolutionProblem problem = explosion_problem(system, 0.5, upper);
      problem.time = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, elements, points);
      const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-6});
      CAPTURE(upper, elements, points, report(result));
      CHECK(result.status != EvolutionStatus::converged);
      CHECK(result.residual > 1e-6);
    }
  }
}

TEST_CASE("close to where solutions end they are still found") {
  const TestSystem system = explosion();
  const EvolutionResult result = solve_evolution(explosion_problem(system, 0.5, 0.8), {.tolerance = 1e-7});
  CAPTURE(report(result));
  CHECK(result.status == EvolutionStatus::converged);
  // The pole lies at t = 1.25: 10 elements of 5 points resolve it to 1e-5.
  for (const double t : {0.3, 0.77, 1.0}) {
    CHECK(result.field(std::vector<double>{t, 0.79})[0] == Approx(1.0 / (1.0 / 0.79 - t)).epsilon(1e-5));
  }
}

TEST_CASE("where the right-hand side or its derivative is not finite is said in coordinates") {
  const auto root = [](double, const Vector&, const Vector& q) { return one(std::sqrt(q[0])); };
  const auto finite = [](double, const Vector&, const Vector&) { return one(1.0); };
  const auto no_state = [](double, const Vector&, const Vector&) { return one_by_one(0.0); };
  const auto bad_derivative = [](double, const Vector&, const Vector& q) {
    return one_by_one(std::log(q[0]));
  };
  for (const bool rate_is_bad : {true, false}) {
    const TestSystem system =
        rate_is_bad ? TestSystem(1, root, no_state) : TestSystem(1, finite, bad_derivative);
    const EvolutionProblem problem{&system,
                                   Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3),
                                   {Axis::chebyshev({"area", "m^2"}, -1.0, 1.0, 9)},
                                   {{"u"}},
                                   {1.0},
                                   {{0.0, -1}}};
    const EvolutionResult result = solve_evolution(problem);
    CHECK(result.status == EvolutionStatus::not_finite);
    CHECK_THAT(result.message,
               Contains(rate_is_bad ? "right-hand side is not finite" : "Jacobian is not finite"));
    CHECK_THAT(result.message, Contains("t = ") && Contains(" s, area = -") && Contains("m^2"));
  }
}

TEST_CASE("a solution that leaves the domain of its right-hand side is not reported as converged") {
  // u' = -1 - sqrt(u) from u(0) in [0.2, 1] reaches zero before t = 1.
  const TestSystem system(
      1, [](double, const Vector& x, const Vector&) { return one(-1.0 - std::sqrt(x[0])); },
      [](double, const Vector& x, const Vector&) { return one_by_one(-0.5 / std::sqrt(x[0])); });
  EvolutionProblem problem = explosion_problem(system, 0.2, 1.0);
  const EvolutionResult result = solve_evolution(problem);
  CAPTURE(report(result));
  CHECK(result.status != EvolutionStatus::converged);
  CHECK_THAT(result.message, Contains("not finite at t = ") && Contains("u(0) = 0."));
}

TEST_CASE("a rank that does not suffice is reported") {
  const Fall fall;
  const EvolutionResult result = solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-8, .max_rank = 2});
  CAPTURE(report(result));
  CHECK(result.status != EvolutionStatus::converged);
  CHECK(Fall::error(result.field) > 1e-6);
}

TEST_CASE("a right-hand side that is approximated too coarsely is reported, however small the residual") {
  // u' = sin(9 t q) needs more than four products; the equations of its best four are solved exactly.
  const TestSystem system(
      1, [](double t, const Vector&, const Vector& q) { return one(std::sin(9.0 * t * q[0])); },
      [](double, const Vector&, const Vector&) { return one_by_one(0.0); });
  EvolutionProblem problem = decay_problem(system, Axis::radau({"t", "s"}, 0.0, 1.0, 4, 6));
  problem.parameters = {Axis::chebyshev({"q"}, 0.0, 1.0, 16)};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-8, .max_rank = 4});
  CAPTURE(report(result));
  CHECK(result.residual <= 1e-8);
  CHECK(result.nonlinearity_error > 1e-8);
  CHECK(result.status == EvolutionStatus::stalled);
  CHECK_THAT(result.message, Contains("f is approximated only to"));
  const EvolutionResult enough = solve_evolution(problem, {.tolerance = 1e-8});
  CHECK(enough.status == EvolutionStatus::converged);
  CHECK(enough.nonlinearity_error <= 1e-8);
}

TEST_CASE("a former solution saves iterations, also from coarser axes") {
  const Fall fall;
  const EvolutionOptions options{.tolerance = 1e-9};
  const EvolutionProblem fine = fall.problem(20, 7, 20);
  const EvolutionResult cold = solve_evolution(fine, options);
  REQUIRE(cold.status == EvolutionStatus::converged);
  const auto from = [&](const EvolutionProblem& coarse) {
    const EvolutionResult first = solve_evolution(coarse, {.tolerance = 1e-5});
    REQUIRE(first.status == EvolutionStatus::converged);
    EvolutionResult second = solve_evolution(fine, options, &first.field);
    CAPTURE(report(first), report(second));
    CHECK(second.status == EvolutionStatus::converged);
    CHECK(second.history.size() < cold.history.size());
    CHECK(second.history.front().residual < 0.1 * cold.history.front().residual);
    CHECK(second.rhs_evaluations < cold.rhs_evaluations);
    CHECK(Fall::error(second.field) <= 1e-8);
  };
  from(fine);
  from(fall.problem(8, 4, 9));
  // The solution itself, of a looser tolerance than asked for, needs no step.
  const EvolutionResult again = solve_evolution(fine, {.tolerance = 1e-8}, &cold.field);
  CHECK(again.status == EvolutionStatus::converged);
  CHECK(again.history.size() == 1);
}

TEST_CASE("a guess over other axes or outputs is refused") {
  const Fall fall;
  const EvolutionProblem problem = fall.problem(4, 4, 8);
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-3});
  EvolutionProblem other = problem;
  other.parameters = {Axis::chebyshev({"mass", "kg"}, 0.5, 2.0, 8)};
  CHECK_THROWS_WITH(solve_evolution(other, {}, &result.field), Contains("(t, C_D)") && Contains("(t, mass)"));
  other.parameters = {problem.parameters[0], Axis::chebyshev({"mass", "kg"}, 0.5, 2.0, 8)};
  CHECK_THROWS_AS(solve_evolution(other, {}, &result.field), samara::ArgumentError);
  const SeparatedField two(result.field.axes(), {{"u"}, {"v"}}, result.field.factors(),
                           result.field.weights().replicate(2, 1));
  CHECK_THROWS_AS(solve_evolution(problem, {}, &two), samara::ArgumentError);
}

TEST_CASE("the allowed iterations end the solve with what was reached") {
  const Fall fall;
  const EvolutionResult result =
      solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-9, .max_iterations = 3});
  CHECK(result.status == EvolutionStatus::max_iterations);
  CHECK_THAT(result.message, Contains("after all 3 iterations"));
  CHECK(result.history.size() == 4);  // the last one only measures
  CHECK(result.residual == result.history.back().residual);
  CHECK(std::isfinite(result.field(std::vector<double>{0.5, 1.0})[0]));
}

TEST_CASE("progress is reported and may cancel") {
  const Fall fall;
  std::vector<double> fractions;
  EvolutionOptions options{.tolerance = 1e-6};
  options.progress = [&](const samara::Progress& progress) {
    CHECK(progress.stage == "Newton");
    fractions.push_back(progress.fraction);
    return fractions.size() < 4;
  };
  const EvolutionResult result = solve_evolution(fall.problem(6, 5, 12), options);
  CHECK(result.status == EvolutionStatus::cancelled);
  CHECK_THAT(result.message, Contains("cancelled at residual"));
  CHECK(fractions.size() == 4);
  for (const double fraction : fractions) CHECK((fraction >= 0.0 && fraction <= 1.0));
}

TEST_CASE("f is evaluated only where it is asked for, and every evaluation is counted") {
  const TestSystem system = explosion();
  const EvolutionResult result = solve_evolution(explosion_problem(system, 0.1, 0.6), {.tolerance = 1e-8});
  REQUIRE(result.status == EvolutionStatus::converged);
  CHECK(result.grid_size == 10 * 5 * 20);
  const std::vector<long>& rhs = system.rhs_counts();
  const std::vector<long>& jacobian = system.jacobian_counts();
  // The last iteration only measures the residual.
  REQUIRE(rhs.size() == result.history.size());
  REQUIRE(jacobian.size() == rhs.size() - 1);
  long all_rhs = 0;
  long all_jacobian = 0;
  for (std::size_t i = 0; i < rhs.size(); ++i) {
    const long j = i < jacobian.size() ? jacobian[i] : 0;
    CHECK(result.history[i].evaluations == rhs[i] + j);
    CHECK(result.history[i].step == 1.0);
    CHECK(static_cast<double>(rhs[i]) <= result.grid_size);
    CHECK(static_cast<double>(j) <= result.grid_size);
    all_rhs += rhs[i];
    all_jacobian += j;
  }
  CHECK(result.rhs_evaluations == all_rhs);
  CHECK(result.jacobian_evaluations == all_jacobian);
}

TEST_CASE("with more parameters the share of the grid that is evaluated falls") {
  // A body against drag with four parameters: 60 000 entries and more.
  const TestSystem system(
      1,
      [](double, const Vector& x, const Vector& q) {
        return one(-q[0] * q[1] * std::sqrt(x[0] * x[0] + 0.01) * x[0] / q[2] - q[3]);
      },
      [](double, const Vector& x, const Vector& q) {
        const double root = std::sqrt(x[0] * x[0] + 0.01);
        return one_by_one(-q[0] * q[1] / q[2] * (root + x[0] * x[0] / root));
      });
  const EvolutionProblem problem{
      &system,
      Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 3, 5),
      {Axis::chebyshev({"C_D"}, 0.5, 1.0, 8), Axis::chebyshev({"A", "m^2"}, 0.5, 1.0, 8),
       Axis::chebyshev({"m", "kg"}, 1.0, 1.5, 8), Axis::chebyshev({"g", "m/s^2"}, 0.8, 1.0, 8)},
      {{"u", "m/s"}},
      {1.0},
      {{0.0, -1}}};
  const EvolutionResult result = solve_evolution(problem, {.tolerance = 1e-5});
  CAPTURE(report(result));
  CHECK(result.status == EvolutionStatus::converged);
  for (const EvolutionRecord& record : result.history) {
    CHECK(static_cast<double>(record.evaluations) < 0.1 * result.grid_size);
  }
}

TEST_CASE("the same seed gives the same field to the last bit") {
  const Fall fall;
  const auto solve = [&](std::uint64_t seed) {
    return solve_evolution(fall.problem(6, 5, 16), {.tolerance = 1e-7, .seed = seed});
  };
  const EvolutionResult a = solve(3);
  const EvolutionResult b = solve(3);
  REQUIRE(a.field.rank() == b.field.rank());
  CHECK(a.field.weights() == b.field.weights());
  for (std::size_t k = 0; k < 2; ++k) CHECK(a.field.factors()[k] == b.field.factors()[k]);
  CHECK(a.message == b.message);
  const EvolutionResult c = solve(4);
  CHECK(c.status == EvolutionStatus::converged);
  CHECK((c.field.rank() != a.field.rank() || c.field.weights() != a.field.weights()));
}

TEST_CASE("evolution problems and options that make no sense are refused") {
  const Fall fall;
  const EvolutionProblem good = fall.problem(2, 3, 4);
  const auto refused = [&](const std::function<void(EvolutionProblem&)>& change, const std::string& words) {
    EvolutionProblem problem = good;
    change(problem);
    CHECK_THROWS_AS(problem.validate(), samara::ArgumentError);
    CHECK_THROWS_WITH(solve_evolution(problem), Contains(words));
  };
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CHECK_NOTHROW(good.validate());
  refused([](EvolutionProblem& p) { p.system = nullptr; }, "no system");
  refused([](EvolutionProblem& p) { p.states.push_back({"v"}); }, "1 states; 2 labels");
  refused([](EvolutionProblem& p) { p.scales.clear(); }, "0 scales");
  refused([](EvolutionProblem& p) { p.initial.clear(); }, "0 initial values");
  refused([](EvolutionProblem& p) { p.scales[0] = 0.0; }, "scale of u is 0");
  refused([](EvolutionProblem& p) { p.scales[0] = -1.0; }, "scale of u is -1");
  refused([&](EvolutionProblem& p) { p.scales[0] = kNan; }, "scale of u is nan");
  refused([](EvolutionProblem& p) { p.initial[0].axis = 1; }, "axis 1 of 1");
  refused([&](EvolutionProblem& p) { p.initial[0].value = kNan; }, "initial value of u is nan");

  const auto refused_options = [&](const EvolutionOptions& options, const std::string& words) {
    CHECK_THROWS_AS(solve_evolution(good, options), samara::ArgumentError);
    CHECK_THROWS_WITH(solve_evolution(good, options), Contains(words));
  };
  refused_options({.tolerance = 0.0}, "tolerance 0");
  refused_options({.tolerance = kNan}, "tolerance nan");
  refused_options({.max_iterations = 0}, "max_iterations 0");
  refused_options({.max_rank = 0}, "max_rank 0");
  refused_options({.linear_tolerance = 0.0}, "linear_tolerance 0");
}
