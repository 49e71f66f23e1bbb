// One march, whatever solves its slabs.
#include "samara/pgd/nonlinear/march.h"

#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../slab_systems.h"
#include "samara/base/errors.h"
#include "samara/pgd/evolution/polynomial_system.h"
#include "samara/pgd/nonlinear/strategy_trial.h"
#include "samara/pgd/tensors/train_algebra.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;
using samara::Termination;

namespace {

/// A large swing over its damping and its stiffness.
AdaptiveProblem swing(const EvolutionSystem& system, double end) {
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "1", AxisRole::time};
  problem.end = end;
  problem.parameters = {{{"c"}, 0.1, 0.4}, {{"k"}, 0.8, 1.2}};
  problem.states = {{"theta"}, {"omega"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{1.5, -1}, {0.0, -1}};
  return problem;
}

/// Largest error at random points, in scales of one.
double swing_error(const SlabResult& result, const slab_systems::System& system) {
  Random random(4);
  double largest = 0.0;
  for (int i = 0; i < 60; ++i) {
    const std::vector<double> x = {result.reached * random.uniform(), 0.1 + 0.3 * random.uniform(),
                                   0.8 + 0.4 * random.uniform()};
    const Eigen::VectorXd exact =
        system.exact(Eigen::Vector2d(1.5, 0.0), Eigen::Vector2d(x[1], x[2]), x[0], 2e-3);
    for (const TrainField& piece : result.pieces) {
      if (!piece.axes()[0].contains(x[0])) continue;
      largest = std::max(largest, (piece(x) - exact).cwiseAbs().maxCoeff());
      break;
    }
  }
  return largest;
}

/// (6.22) with its coupled terms known one by one.
PolynomialSystem products_term_by_term() {
  std::vector<Monomial> terms;
  for (int m = 0; m < 3; ++m) {
    std::vector<int> others = {1, 1, 1};
    others[static_cast<std::size_t>(m)] = 0;
    terms.push_back({m, m + 1.0});
    terms.push_back({m, -1.0, {}, others});
  }
  return {3, 3, terms};
}

void check_same_pieces(const SlabResult& a, const SlabResult& b) {
  REQUIRE(a.pieces.size() == b.pieces.size());
  for (std::size_t p = 0; p < a.pieces.size(); ++p) {
    const std::vector<TrainCore>& ours = a.pieces[p].train().cores;
    const std::vector<TrainCore>& theirs = b.pieces[p].train().cores;
    REQUIRE(ours.size() == theirs.size());
    for (std::size_t k = 0; k < ours.size(); ++k) CHECK(ours[k].data == theirs[k].data);
  }
}

}  // namespace

TEST_CASE("every strategy of a name marches a large swing to the tolerance it is asked for") {
  const slab_systems::System system = slab_systems::pendulum();
  for (const std::string& name : strategy_names()) {
    // Piecewise-linear approximation is good for a per cent or so.
    const double tolerance = name == "piecewise_linear" ? 2e-2 : 1e-4;
    const SlabResult result = march(swing(system, 2.0), name, {.tolerance = tolerance});
    CAPTURE(name, result.message);
    CHECK(result.status == Termination::converged);
    CHECK(result.reached == 2.0);
    CHECK(swing_error(result, system) <= 2.0 * tolerance);  // over scales of one; ranges are about two
    CHECK(result.evaluations > 0);
  }
}

TEST_CASE(
    "one unknown after the other, the products (6.22) are solved, by products of fields and by crosses") {
  const slab_systems::System by_cross = slab_systems::triple_product();
  const PolynomialSystem by_products = products_term_by_term();
  AdaptiveProblem problem = slab_systems::triple_problem(by_cross, 0.8);
  for (const EvolutionSystem* system :
       {static_cast<const EvolutionSystem*>(&by_cross), static_cast<const EvolutionSystem*>(&by_products)}) {
    problem.system = system;
    const SlabResult result = march(problem, "decoupling", {.tolerance = 1e-4});
    CAPTURE(result.message);
    CHECK(result.status == Termination::converged);
    CHECK(slab_systems::largest_error(result, problem, by_cross, 0.8, 500, 3) <= 1e-4);
  }
}

TEST_CASE("what an unknown does to itself, and a coupling one way, are solved exactly by decoupling") {
  // u' = -k u, v' = u - v.
  const PolynomialSystem system(2, 1,
                                {{0, -1.0, {1}, {1, 0}}, {1, 1.0, {0}, {1, 0}}, {1, -1.0, {0}, {0, 1}}});
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 3.0;
  problem.parameters = {{{"k", "1/s"}, 2.0, 4.0}};
  problem.states = {{"u"}, {"v"}};
  problem.scales = {1.0, 1.0};
  problem.scale_floors = {0.0, 0.0};
  problem.initial = {{1.0, -1}, {0.0, -1}};
  const SlabResult result = march(problem, "decoupling", {.tolerance = 1e-6});
  CAPTURE(result.message);
  REQUIRE(result.status == Termination::converged);
  for (const TrainField& piece : result.pieces) {
    const double t = piece.axes()[0].upper();
    for (const double k : {2.1, 3.7}) {
      const Eigen::VectorXd u = piece(std::vector{t, k});
      CHECK(u[0] == Approx(std::exp(-k * t)).margin(1e-6));
      CHECK(u[1] == Approx((std::exp(-t) - std::exp(-k * t)) / (k - 1.0)).margin(1e-6));
    }
  }
}

TEST_CASE("nodes that are prescribed and do not suffice are kept to the end, and the miss is said") {
  const slab_systems::System system = slab_systems::pendulum();
  AdaptiveProblem problem = swing(system, 2.0);
  problem.parameters[0].nodes = 2;
  for (const char* name : {"slabs", "empirical"}) {
    const SlabResult result = march(problem, name, {.tolerance = 1e-5});
    CAPTURE(name, result.message);
    CHECK(result.status == Termination::missed);
    CHECK(result.reached == 2.0);
    CHECK_THAT(result.message, Contains("left as they are: the nodes that are prescribed do not suffice"));
    for (const TrainField& piece : result.pieces) CHECK(piece.axes()[1].size() == 2);
    const double error = swing_error(result, system);
    CHECK(error > 1e-5);
    CHECK(error < 0.1);
    CHECK(result.error >= 0.3 * error / 4.0);
  }
}

TEST_CASE("axes of every kind serve in slabs, the periodic one too") {
  // x' = (2 + cos q) - x from 0: x = (2 + cos q) (1 - e^-t).
  const slab_systems::System system(
      1,
      [](const Eigen::VectorXd& x, const Eigen::VectorXd& q) {
        return Eigen::VectorXd((2.0 + std::cos(q[0]) - x.array()).matrix());
      },
      [](const Eigen::VectorXd&, const Eigen::VectorXd&) { return Eigen::MatrixXd::Constant(1, 1, -1.0); });
  AdaptiveProblem problem;
  problem.system = &system;
  problem.time = {"t", "s", AxisRole::time};
  problem.end = 2.0;
  problem.states = {{"x"}};
  problem.scales = {1.0};
  problem.scale_floors = {0.0};
  problem.initial = {{0.0, -1}};
  constexpr double kPeriod = 2.0 * std::numbers::pi;
  const auto error = [&](const AdaptiveAxis& axis, Termination expected) {
    problem.parameters = {axis};
    const SlabResult result = march(problem, "slabs", {.tolerance = 1e-5});
    CAPTURE(result.message);
    CHECK(result.status == expected);
    Random random(7);
    double largest = 0.0;
    for (int i = 0; i < 300; ++i) {
      const std::vector<double> x = {2.0 * random.uniform(), kPeriod * random.uniform()};
      for (const TrainField& piece : result.pieces) {
        if (!piece.axes()[0].contains(x[0])) continue;
        const double exact = (2.0 + std::cos(x[1])) * (1.0 - std::exp(-x[0]));
        largest = std::max(largest, std::abs(piece(x)[0] - exact));
        break;
      }
    }
    return largest;
  };
  const Axis::Label label{"q", "rad"};
  CHECK(error({label, 0.0, kPeriod, 5, Basis::fourier}, Termination::converged) <= 1e-5 * 2.6);
  CHECK(error({label, 0.0, kPeriod, {}, Basis::fourier}, Termination::converged) <= 1e-5 * 2.6);
  CHECK(error({label, 0.0, kPeriod, {}, Basis::legendre}, Termination::converged) <= 1e-5 * 2.6);
  // Linear elements err by h^2 / 8 of the second derivative, quadratic ones by h^3 / (72 sqrt 3) of the third.
  const double h = kPeriod / 20.0;
  const double grown = 1.0 - std::exp(-2.0);
  CHECK(error({label, 0.0, kPeriod, 21, Basis::p1}, Termination::missed) ==
        Approx(h * h / 8.0 * grown).epsilon(0.3));
  CHECK(error({label, 0.0, kPeriod, 21, Basis::p2}, Termination::missed) <
        2.0 * std::pow(2.0 * h, 3) / (72.0 * std::sqrt(3.0)) * grown);
}

TEST_CASE("an approximation that comes no closer keeps its field, and says so") {
  const slab_systems::System system = slab_systems::pendulum();
  const auto strategy = piecewise_linear_strategy({.points = 20});
  const SlabResult result = march(swing(system, 2.0), *strategy, {.tolerance = 1e-4});
  CAPTURE(result.message);
  CHECK(result.status == Termination::missed);
  CHECK(result.reached == 2.0);
  CHECK_THAT(result.message, Contains("piecewise-linear approximation comes no closer"));
  const double error = swing_error(result, system);
  CHECK(error > 1e-4);
  CHECK(error < 0.2);
}

TEST_CASE("a march by a strategy goes on from any of its states to the same bits") {
  const slab_systems::System system = slab_systems::pendulum();
  const AdaptiveProblem problem = swing(system, 2.0);
  for (const char* name : {"empirical", "cross", "decoupling", "enrichment"}) {
    const SlabOptions options{.tolerance = 1e-3};
    const SlabResult whole = march(problem, name, options);
    CAPTURE(name, whole.message);
    const std::vector<std::vector<double>> states = slab_systems::stored_states(
        [&](const SlabOptions& storing) { march(problem, name, storing); }, options, 3);
    REQUIRE(states.size() >= 3);
    const SlabResult resumed = march(problem, name, options, states[states.size() / 2]);
    CHECK(resumed.status == whole.status);
    CHECK(resumed.error == whole.error);
    CHECK(resumed.evaluations == whole.evaluations);
    check_same_pieces(resumed, whole);
  }
}

TEST_CASE("a march past the end of the solution says when, by any strategy") {
  const slab_systems::System system = slab_systems::triple_product();
  const AdaptiveProblem problem = slab_systems::triple_problem(system, 1.0);
  const SlabResult result = march(problem, "incremental", {.tolerance = 1e-2, .max_nodes = 24});
  CAPTURE(result.message);
  CHECK(result.status == Termination::ceases);
  // From (0, 1, 1) it blows up at t = 0.953, where an error of a per cent is worth a few.
  CHECK(result.reached == Approx(0.953).margin(0.03));
}

TEST_CASE("a march by a strategy may be ended from within its slabs") {
  const slab_systems::System system = slab_systems::pendulum();
  int reports = 0;
  SlabOptions stopping{.tolerance = 1e-4};
  stopping.progress = [&](const samara::Progress& report) {
    CHECK((report.stage.starts_with("slab ") || report.stage == "survey of the box"));
    return ++reports < 30;
  };
  const SlabResult cancelled = march(swing(system, 2.0), "cross", stopping);
  CHECK(cancelled.status == Termination::cancelled);
  CHECK(reports == 30);
  const SlabResult bounded = march(swing(system, 2.0), "cross", {.tolerance = 1e-6, .max_evaluations = 2000});
  CHECK(bounded.status == Termination::max_calls);
}

TEST_CASE("a strategy of an unknown name is refused with those that there are") {
  const slab_systems::System system = slab_systems::pendulum();
  CHECK_THROWS_WITH(march(swing(system, 1.0), "picard"),
                    Contains("\"picard\"") && Contains("enrichment") && Contains("slabs"));
}

namespace {

/// Knows nothing of any slab but that f is not finite there, which is not so.
struct GivesUp final : Strategy {
  std::string name() const override { return "one that gives up"; }
  samara::Outcome<LinearSlab> linearise(const StrategySlab&, const TensorTrain&,
                                        std::optional<double>) override {
    return samara::Ending{Termination::not_finite, "my own reason", {0.2, 1.0}};
  }
};

/// Stays at the start, whatever f is.
struct StaysAtStart final : Strategy {
  std::string name() const override { return "one that stays"; }
  samara::Outcome<LinearSlab> linearise(const StrategySlab& slab, const TensorTrain&,
                                        std::optional<double>) override {
    return LinearSlab{{}, scaled(slab.start_at_points(), 0.0)};
  }
};

}  // namespace

TEST_CASE("where a strategy gives up on equations that can be solved, the march says the strategy's reason") {
  const slab_systems::System system = slab_systems::pendulum();
  GivesUp strategy;
  const SlabResult result = march(swing(system, 2.0), strategy, {.tolerance = 1e-4});
  CHECK(result.status == Termination::not_finite);
  CHECK(result.message == "my own reason");
}

TEST_CASE("rates that are not finite leave no finite defect") {
  const slab_systems::System nowhere(
      1,
      [](const slab_systems::Vector&, const slab_systems::Vector&) {
        return slab_systems::Vector(slab_systems::Vector::Constant(1, std::nan("")));
      },
      [](const slab_systems::Vector&, const slab_systems::Vector&) {
        return slab_systems::Matrix(slab_systems::Matrix::Zero(1, 1));
      });
  const EvolutionProblem problem{
      &nowhere,   Axis::radau({"t"}, 0.0, 1.0, 1, 4), {Axis::chebyshev({"q"}, 1.0, 2.0, 5)}, {{"x"}}, {1.0},
      {{1.0, -1}}};
  StaysAtStart strategy;
  CHECK(std::isinf(try_strategy(problem, strategy, {.tolerance = 1e-3}).largest_defect()));
}

TEST_CASE("a march by a strategy refuses options outside their meaning before the strategy is asked") {
  const slab_systems::System system = slab_systems::pendulum();
  CHECK_THROWS_AS(march(swing(system, 2.0), "piecewise_linear", {.tolerance = std::nan("")}),
                  samara::ArgumentError);
  CHECK_THROWS_AS(march(swing(system, -1.0), "empirical"), samara::ArgumentError);
  const PolynomialSystem two_states(2, 2, {{1, 1.0, {}, {1, 0}}});
  struct Wrong final : EvolutionSystem {
    explicit Wrong(const PolynomialSystem& other) : other_(other) {}
    int state_count() const override { return 1; }
    void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd&, const Eigen::MatrixXd&,
             Eigen::MatrixXd& f) const override {
      f.setZero(1, t.size());
    }
    void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd&, const Eigen::MatrixXd&,
                  Eigen::MatrixXd& jacobian) const override {
      jacobian.setZero(1, t.size());
    }
    const PolynomialSystem* polynomial() const override { return &other_; }
    const PolynomialSystem& other_;
  } wrong(two_states);
  AdaptiveProblem problem = swing(wrong, 1.0);
  problem.states.pop_back();
  problem.scales.pop_back();
  problem.scale_floors.pop_back();
  problem.initial.pop_back();
  CHECK_THROWS_WITH(march(problem, "slabs"),
                    Contains("the polynomial system has 2 states, the system itself 1"));
}

namespace {

/// Finds nothing to go by after 40 evaluations of f and 2 of its Jacobian.
class EndsInPreparation final : public Strategy {
 public:
  std::string name() const override { return "ends in its preparation"; }
  std::optional<samara::Ending> prepare(const EvolutionProblem&, double) override {
    return samara::Ending{Termination::not_finite, "nothing to go by"};
  }
  samara::Outcome<LinearSlab> linearise(const StrategySlab&, const TensorTrain&,
                                        std::optional<double>) override {
    return samara::Ending{Termination::failed, "asked after its end"};
  }
  StrategyCounts prepared() const override { return {.rhs = 40, .jacobian = 2}; }
};

}  // namespace

TEST_CASE("a march that ends in the preparation of its strategy says what that took") {
  const slab_systems::System system = slab_systems::pendulum();
  EndsInPreparation strategy;
  const SlabResult result = march(swing(system, 1.0), strategy, {.tolerance = 1e-4});
  CHECK(result.status == Termination::not_finite);
  CHECK(result.message == "nothing to go by");
  CHECK(result.pieces.empty());
  CHECK(result.evaluations == 42);
}
