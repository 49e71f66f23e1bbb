#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <utility>

#include "samara/base/errors.h"
#include "samara/pgd/evolution/evolution.h"
#include "samara/pgd/tensors/random.h"

/// Systems with known solutions, to evolve.
namespace evolution_systems {

using namespace samara::pgd;

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

inline Vector one(double value) {
  return Vector::Constant(1, value);
}
inline Matrix one_by_one(double value) {
  return Matrix::Constant(1, 1, value);
}

/// k (u' + 1) = 10, (6.18).
inline TestSystem constant_rate() {
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
inline TestSystem decay() {
  return {1, [](double, const Vector& x, const Vector& q) { return one(-q[0] * x[0]); },
          [](double, const Vector&, const Vector& q) { return one_by_one(-q[0]); }};
}

inline EvolutionProblem decay_problem(const TestSystem& system, const Axis& time) {
  return {&system, time, {Axis::chebyshev({"q", "1/s"}, 1.0, 2.0, 12)}, {{"u"}}, {1.0}, {{1.0, -1}}};
}

/// u' = u^2: u = 1 / (1 / u(0) - t) ends at t = 1 / u(0).
inline TestSystem explosion() {
  return {1, [](double, const Vector& x, const Vector&) { return one(x[0] * x[0]); },
          [](double, const Vector& x, const Vector&) { return one_by_one(2.0 * x[0]); }};
}

inline EvolutionProblem explosion_problem(const TestSystem& system, double lower, double upper) {
  return {&system,
          Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 10, 5),
          {Axis::chebyshev({"u(0)", "1", AxisRole::initial}, lower, upper, 20)},
          {{"u"}},
          {1.0},
          {{0.0, 0}}};
}

inline std::string report(const EvolutionResult& result) {
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

}  // namespace evolution_systems
