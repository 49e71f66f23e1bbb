// The test kits for systems and strategies: ours pass, and every broken promise is found.
#include <atomic>
#include <cmath>
#include <stdexcept>
#include <string>

#include <catch2/catch.hpp>

#include "../slab_systems.h"
#include "samara/base/errors.h"
#include "samara/pgd/checks/check_strategy.h"
#include "samara/pgd/checks/check_system.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/march.h"
#include "samara/pgd/nonlinear/separated_rates.h"
#include "samara/pgd/tensors/train_points.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;
using samara::Check;
using slab_systems::Matrix;
using slab_systems::Vector;

namespace {

/// x'' = -k sin x - c x'.
AdaptiveProblem pendulum_to_check(const EvolutionSystem& system) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = 2.0;
  problem.parameters = {{{"c"}, 0.1, 0.4}, {{"k"}, 0.8, 1.2}};
  problem.states = {{"theta"}, {"omega"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{1.0, -1}, {0.0, -1}};
  return problem;
}

/// x' = q x, with a promise broken.
struct BrokenSystem : EvolutionSystem {
  int state_count() const override { return 1; }
  void rhs(const Vector&, const Matrix& x, const Matrix& q, Matrix& f) const override {
    f = x.cwiseProduct(q.topRows(1));
  }
  void jacobian(const Vector&, const Matrix&, const Matrix& q, Matrix& jacobian) const override {
    jacobian = q.topRows(1);
  }
};

AdaptiveProblem growth(const EvolutionSystem& system) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.parameters = {{{"q"}, 0.5, 1.5}};
  problem.states = {{"x"}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  problem.initial = {{1.0, -1}};
  return problem;
}

void check_finds(const EvolutionSystem& system, const std::string& what) {
  const Check found = check_system(growth(system));
  CAPTURE(what);
  REQUIRE_FALSE(found.passed());
  CHECK_THAT(found.findings.front(), Contains(what));
}

void check_finds(Strategy& strategy, const std::string& what) {
  const slab_systems::System system = slab_systems::pendulum();
  const Check found = check_strategy(strategy, pendulum_to_check(system));
  std::string all;
  for (const std::string& sentence : found.findings) all += sentence + "\n";
  CHECK_THAT(all, Contains(what));
}

/// Integrates the rates of the iterate, after something that the test does.
struct OwnStrategy : Strategy {
  std::string name() const override { return "my own"; }
  samara::Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                        std::optional<double>) override {
    CrossPivots pivots;
    const TensorTrain at_points = slab.at_points(iterate);
    const EntryFunction source = [&](const IndexBatch& entries, Matrix& values) {
      values = factor() * slab.rates(values_at(at_points, entries), slab.parameters_at(entries));
    };
    samara::Outcome<TensorTrain> b =
        slab.separate(source, slab.rows(), kSourceShare * slab.tolerance(), pivots, "f");
    if (!b) return b.ending();
    return LinearSlab{{}, std::move(*b)};
  }
  virtual double factor() { return 1.0; }
};

}  // namespace

TEST_CASE("systems that keep their promises pass their test kit") {
  const slab_systems::System swing = slab_systems::pendulum();
  CHECK(check_system(pendulum_to_check(swing)).findings == std::vector<std::string>{});
  const PolynomialSystem logistic(1, 1, {{0, 1.0, {1}, {1}}, {0, -1.0, {}, {2}}});
  CHECK(check_system(growth(logistic)).findings == std::vector<std::string>{});
  const PolynomialSystem of_powers(
      1, 1, {{0, 0.5, {2}, {3}}, {0, -1.0, {0}, {3}}, {0, 2.0, {1}, {0}}, {0, 1.0, {3}, {1}}});
  CHECK(check_system(growth(of_powers)).findings == std::vector<std::string>{});
  CHECK(check_system(growth(BrokenSystem())).passed());
}

TEST_CASE("a polynomial system is the sum of its monomials, and its Jacobian of their derivatives") {
  const PolynomialSystem system(2, 2,
                                {{0, 0.5, {2, 1}, {3, 1}}, {0, -3.0, {}, {0, 2}}, {1, 2.0, {0, 1}, {}}});
  const Matrix x{{1.3, -0.4}, {0.7, 2.0}}, q{{0.6, 1.1}, {-1.5, 0.2}};
  Matrix f, jacobian;
  system.rhs(Vector::Zero(2), x, q, f);
  system.jacobian(Vector::Zero(2), x, q, jacobian);
  for (int j = 0; j < 2; ++j) {
    const double a = x(0, j), b = x(1, j), k = 0.5 * q(0, j) * q(0, j) * q(1, j);
    CHECK_THAT(f(0, j), WithinRel(k * a * a * a * b - 3.0 * b * b, 1e-14));
    CHECK_THAT(f(1, j), WithinRel(2.0 * q(1, j), 1e-14));
    CHECK_THAT(jacobian(0, j), WithinRel(3.0 * k * a * a * b, 1e-14));
    CHECK_THAT(jacobian(2, j), WithinRel(k * a * a * a - 6.0 * b, 1e-14));
    CHECK(jacobian(1, j) == 0.0);
    CHECK(jacobian(3, j) == 0.0);
  }
}

TEST_CASE("the test kit of systems finds every broken promise") {
  struct WrongShape : BrokenSystem {
    void rhs(const Vector&, const Matrix& x, const Matrix&, Matrix& f) const override { f = x.transpose(); }
  };
  check_finds(WrongShape(), "rhs() gives 50 x 1 numbers for 1 states and 50 points");
  struct NotFinite : BrokenSystem {
    void rhs(const Vector&, const Matrix& x, const Matrix&, Matrix& f) const override {
      f = (x.array() - 1.0).sqrt();
    }
  };
  check_finds(NotFinite(), "a rate is not finite at t = ");
  struct WrongJacobianShape : BrokenSystem {
    void jacobian(const Vector&, const Matrix&, const Matrix& q, Matrix& jacobian) const override {
      jacobian = q.transpose();
    }
  };
  check_finds(WrongJacobianShape(), "jacobian() gives 50 x 1 numbers");
  struct JacobianNotFinite : BrokenSystem {
    void jacobian(const Vector&, const Matrix& x, const Matrix&, Matrix& jacobian) const override {
      jacobian = (x.array() - 1.0).sqrt();
    }
  };
  check_finds(JacobianNotFinite(), "a derivative is not finite at t = ");
  struct JacobianOfTheFirst : BrokenSystem {
    void jacobian(const Vector& t, const Matrix&, const Matrix& q, Matrix& jacobian) const override {
      jacobian = t.size() > 1 ? Matrix(q.topRows(1)) : Matrix(2.0 * q.topRows(1));
    }
  };
  check_finds(JacobianOfTheFirst(), "jacobian() of one point and of many differ");
  struct NotFiniteBesides : BrokenSystem {
    void rhs(const Vector&, const Matrix& x, const Matrix& q, Matrix& f) const override {
      f = x.cwiseProduct(q.topRows(1));
      // Only at points that are not those of the check itself: a step away from them.
      if (first_.size() == 0) first_ = x;
      if (x.size() == first_.size() && x != first_) f.setConstant(std::nan(""));
    }
    mutable Matrix first_;
  };
  check_finds(NotFiniteBesides(), "by differences nan");
  struct KeepsResults : BrokenSystem {
    void rhs(const Vector& t, const Matrix& x, const Matrix& q, Matrix& f) const override {
      const Matrix before = f.rows() == 1 && f.cols() == t.size() ? f : Matrix::Zero(1, t.size());
      f = before + x.cwiseProduct(q.topRows(1));
    }
  };
  check_finds(KeepsResults(), "rhs() of one point and of many differ");
  struct WrongJacobian : BrokenSystem {
    void jacobian(const Vector&, const Matrix&, const Matrix& q, Matrix& jacobian) const override {
      jacobian = 1.001 * q.topRows(1);
    }
  };
  check_finds(WrongJacobian(), "d x' / d x is");
  struct Counts : BrokenSystem {
    mutable std::atomic<int> calls = 0;
    void rhs(const Vector&, const Matrix& x, const Matrix& q, Matrix& f) const override {
      f = x.cwiseProduct(q.topRows(1)) * (++calls > 100 ? 2.0 : 1.0);
    }
  };
  check_finds(Counts(), "asked from many threads at once");
  struct NotAffine : BrokenSystem {
    void rhs(const Vector&, const Matrix& x, const Matrix& q, Matrix& f) const override {
      f = x.cwiseProduct(q.topRows(1).cwiseAbs2());
    }
    void jacobian(const Vector&, const Matrix&, const Matrix& q, Matrix& jacobian) const override {
      jacobian = q.topRows(1).cwiseAbs2();
    }
    bool affine_in_parameters() const override { return true; }
  };
  check_finds(NotAffine(), "says that it is affine in the parameters, and is not");
  struct OtherPolynomial : BrokenSystem {
    PolynomialSystem other{1, 1, {{0, 1.0, {1}, {2}}}};
    const PolynomialSystem* polynomial() const override { return &other; }
  };
  check_finds(OtherPolynomial(), "polynomial() is not the system's f");
}

TEST_CASE("every strategy of a name passes the test kit of strategies") {
  const slab_systems::System system = slab_systems::pendulum();
  for (const std::string& name : strategy_names()) {
    if (name == "slabs") continue;
    CAPTURE(name);
    CHECK(check_strategy(*strategy_named(name), pendulum_to_check(system)).findings ==
          std::vector<std::string>{});
  }
  OwnStrategy own;
  CHECK(check_strategy(own, pendulum_to_check(system)).findings == std::vector<std::string>{});
}

TEST_CASE("the test kit of strategies finds every broken promise") {
  struct OtherEquations : OwnStrategy {
    double factor() override { return 1.01; }
  };
  OtherEquations other;
  check_finds(other, "it says that it is exact, and leaves a defect of");
  struct Throws : OwnStrategy {
    double factor() override { throw std::runtime_error("no idea"); }
  };
  Throws throws;
  check_finds(throws, "it throws \"no idea\", where an Ending was expected");
  struct ThrowsOurs : OwnStrategy {
    double factor() override { throw samara::ArgumentError("sizes differ"); }
  };
  ThrowsOurs ours;
  check_finds(ours, "it throws \"sizes differ\", where an Ending was expected");
  struct Coarse : OwnStrategy {
    double factor() override { return 1.0 + 2e-4; }
  };
  Coarse coarse;
  check_finds(coarse, "asked for 1e-06 one of");
  struct Remembers : OwnStrategy {
    int calls = 0;
    double factor() override { return 1.0 + 1e-12 * ++calls; }
  };
  Remembers remembers;
  check_finds(remembers, "a second march gives other numbers");
  struct Endless : OwnStrategy {
    int max_iterations() const override { return 1; }
  };
  Endless endless;
  check_finds(endless, "it does not get through 2 slabs");
  struct DoesNotLook : OwnStrategy {
    samara::Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain& iterate,
                                          std::optional<double> correction) override {
      samara::Outcome<LinearSlab> linear = OwnStrategy::linearise(slab, iterate, correction);
      if (linear) return linear;
      return LinearSlab{{}, slab.at_points(slab.constant())};
    }
  };
  DoesNotLook careless;
  check_finds(careless, "it converges where rates are not finite");
}

TEST_CASE("test kits refuse options and problems outside their meaning") {
  const slab_systems::System system = slab_systems::pendulum();
  OwnStrategy own;
  CHECK_THROWS_WITH(check_system(pendulum_to_check(system), {.points = 0}),
                    Contains("CheckSystemOptions::points is 0"));
  CHECK_THROWS_WITH(check_strategy(own, pendulum_to_check(system), {.slabs = 30}),
                    Contains("CheckStrategyOptions::slab is 0.05"));
  CHECK_THROWS_AS(check_strategy(own, AdaptiveProblem()), samara::ArgumentError);
}
