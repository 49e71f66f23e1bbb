#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "samara/pgd/evolution/adaptive_problem.h"
#include "samara/pgd/evolution/slab_evolution.h"
#include "samara/pgd/tensors/random.h"

/// Nonlinear systems and their reference solutions, for marches in slabs.
namespace slab_systems {

using namespace samara::pgd;
using Vector = Eigen::VectorXd;
using Matrix = Eigen::MatrixXd;

/// x' = f(x, q) without memory, so that it may be asked from many threads.
class System final : public EvolutionSystem {
 public:
  using Rate = std::function<Vector(const Vector& x, const Vector& q)>;
  using Derivative = std::function<Matrix(const Vector& x, const Vector& q)>;
  System(int states, Rate rate, Derivative derivative)
      : states_(states), rate_(std::move(rate)), derivative_(std::move(derivative)) {}

  int state_count() const override { return states_; }
  void rhs(const Vector& t, const Matrix& x, const Matrix& q, Matrix& f) const override {
    f.resize(states_, t.size());
    for (Eigen::Index j = 0; j < t.size(); ++j) f.col(j) = rate_(x.col(j), q.col(j));
  }
  void jacobian(const Vector& t, const Matrix& x, const Matrix& q, Matrix& jacobian) const override {
    jacobian.resize(Eigen::Index{states_} * states_, t.size());
    for (Eigen::Index j = 0; j < t.size(); ++j) jacobian.col(j) = derivative_(x.col(j), q.col(j)).reshaped();
  }

  /// Classical Runge-Kutta with steps of at most `step`.
  Vector exact(Vector x, const Vector& q, double end, double step = 1e-3) const {
    const int steps = std::max(1, static_cast<int>(std::ceil(end / step)));
    const double h = end / steps;
    for (int i = 0; i < steps; ++i) {
      const Vector k1 = rate_(x, q);
      const Vector k2 = rate_(x + 0.5 * h * k1, q);
      const Vector k3 = rate_(x + 0.5 * h * k2, q);
      const Vector k4 = rate_(x + h * k3, q);
      x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return x;
  }

 private:
  int states_;
  Rate rate_;
  Derivative derivative_;
};

/// (6.22) with its initial values as coordinates.
inline System triple_product() {
  return {3,
          [](const Vector& x, const Vector&) {
            return Vector(Eigen::Vector3d(1.0 - x[1] * x[2], 2.0 - x[0] * x[2], 3.0 - x[0] * x[1]));
          },
          [](const Vector& x, const Vector&) {
            return (Matrix(3, 3) << 0.0, -x[2], -x[1], -x[2], 0.0, -x[0], -x[1], -x[0], 0.0).finished();
          }};
}

inline AdaptiveProblem triple_problem(const System& system, double end) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = end;
  for (int k = 0; k < 3; ++k) {
    const char* const names[] = {"u1", "u2", "u3"};
    const char* const starts[] = {"u1(0)", "u2(0)", "u3(0)"};
    problem.parameters.push_back({{starts[k], "1", AxisRole::initial}, 0.0, 1.0});
    problem.states.push_back({names[k], "1"});
    problem.initial.push_back({0.0, k});
  }
  problem.scales = {1.0, 1.0, 1.0};
  problem.scale_floors = {0.0, 0.0, 0.0};
  return problem;
}

/// A ball in a double well, x'' = x - x^3 - c x': from the top it falls to one side or the other.
inline System double_well() {
  return {2,
          [](const Vector& x, const Vector& q) {
            return Vector(Eigen::Vector2d(x[1], x[0] - x[0] * x[0] * x[0] - q[0] * x[1]));
          },
          [](const Vector& x, const Vector& q) {
            return (Matrix(2, 2) << 0.0, 1.0, 1.0 - 3.0 * x[0] * x[0], -q[0]).finished();
          }};
}

inline AdaptiveProblem well_problem(const System& system, double end) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = end;
  problem.parameters = {{{"c", "1"}, 0.1, 0.3}, {{"x(0)", "1", AxisRole::initial}, -0.5, 0.6}};
  problem.states = {{"x", "1"}, {"v", "1"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{0.0, 1}, {0.0, -1}};
  return problem;
}

/// A clock, and x' = growth x + tanh((clock - q) / width), which turns from -1 to 1 when the clock shows q.
inline System turning_at_q(double width, double growth) {
  return {2,
          [=](const Vector& x, const Vector& q) {
            return Vector(Eigen::Vector2d(1.0, growth * x[1] + std::tanh((x[0] - q[0]) / width)));
          },
          [=](const Vector& x, const Vector& q) {
            const double tanh = std::tanh((x[0] - q[0]) / width);
            return Matrix{{0.0, 0.0}, {(1.0 - tanh * tanh) / width, growth}};
          }};
}

inline AdaptiveProblem turning_problem(const System& system, double earliest, double latest) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 1.0;
  problem.parameters = {{{"q", "s", AxisRole::parameter}, earliest, latest}};
  problem.states = {{"clock", "s"}, {"x", "s"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{0.0, -1}, {0.0, -1}};
  return problem;
}

/// The state the pieces give at a point (time, then parameters); NaN outside all of them.
inline Vector value_at(const SlabResult& result, std::span<const double> x) {
  for (const TrainField& field : result.pieces) {
    bool inside = true;
    for (std::size_t k = 0; k < x.size() && inside; ++k) inside = field.axes()[k].contains(x[k]);
    if (inside) return field(x);
  }
  return Vector::Constant(result.pieces.front().output_count(), std::nan(""));
}

/// Largest error over the ranges of the states at random points of the box and times up to `end`.
inline double largest_error(const SlabResult& result, const AdaptiveProblem& problem, const System& system,
                            double end, int points, std::uint64_t seed, double step = 1e-3) {
  Random random(seed);
  double largest = 0.0;
  for (int i = 0; i < points; ++i) {
    std::vector<double> x = {end * random.uniform()};
    for (const AdaptiveAxis& axis : problem.parameters)
      x.push_back(axis.lower + random.uniform() * (axis.upper - axis.lower));
    Vector start(problem.initial.size());
    for (std::size_t s = 0; s < problem.initial.size(); ++s) {
      const InitialValue& initial = problem.initial[s];
      start[static_cast<Eigen::Index>(s)] =
          initial.axis < 0 ? initial.value : x[static_cast<std::size_t>(initial.axis) + 1];
    }
    const Vector q = Eigen::Map<const Vector>(x.data() + 1, static_cast<Eigen::Index>(x.size()) - 1);
    const Vector exact = system.exact(start, q, x[0], step);
    const Vector error = (value_at(result, x) - exact).cwiseAbs();
    for (Eigen::Index s = 0; s < error.size(); ++s) {
      const double relative = error[s] / result.ranges[static_cast<std::size_t>(s)];
      largest = std::isnan(relative) ? HUGE_VAL : std::max(largest, relative);
    }
  }
  return largest;
}

/// A damped pendulum over damping and length: as smooth as a plate that swings, and not polynomial.
inline System pendulum() {
  return {2,
          [](const Eigen::VectorXd& x, const Eigen::VectorXd& q) {
            return Eigen::VectorXd(Eigen::Vector2d(x[1], -q[1] * std::sin(x[0]) - q[0] * x[1]));
          },
          [](const Eigen::VectorXd& x, const Eigen::VectorXd& q) {
            return (Eigen::MatrixXd(2, 2) << 0.0, 1.0, -q[1] * std::cos(x[0]), -q[0]).finished();
          }};
}

/// The states that a march stores. Storing takes a twentieth of the time at most: where the machine is held up while
/// the march stores one, it stores few others, and is marched again.
/// @param march takes options, which store
template <class March>
std::vector<std::vector<double>> stored_states(const March& march, SlabOptions options, std::size_t least) {
  std::vector<std::vector<double>> states;
  options.checkpoint = [&](const std::vector<double>& state) { states.push_back(state); };
  for (int attempt = 0; attempt < 50 && states.size() < least; ++attempt) {
    states.clear();
    march(options);
  }
  return states;
}

}  // namespace slab_systems
