#include "problems.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks {

namespace {

using namespace pgd;

constexpr int kTimes = 40;

std::shared_ptr<models::ParametricModel> model(const std::string& name,
                                               const std::map<std::string, double>& fixed,
                                               const std::vector<Interval>& box) {
  std::vector<std::string> free;
  for (const Interval& interval : box) free.push_back(interval.name);
  return std::make_shared<models::ParametricModel>(models::find_model(name), fixed, free);
}

std::vector<int> first_states(int count) {
  std::vector<int> states(static_cast<std::size_t>(count));
  std::iota(states.begin(), states.end(), 0);
  return states;
}

/// Some states of a model of which the others are consequences: f does not depend on them.
class PartOfModel final : public EvolutionSystem {
 public:
  PartOfModel(std::shared_ptr<models::ParametricModel> model, int states)
      : model_(std::move(model)), system_(*model_), states_(states) {}

  int state_count() const override { return states_; }
  bool affine_in_parameters() const override { return system_.affine_in_parameters(); }
  void rhs(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
           Eigen::MatrixXd& f) const override {
    Eigen::MatrixXd all;
    system_.rhs(t, completed(x), q, all);
    f = all.topRows(states_);
  }
  void jacobian(const Eigen::VectorXd& t, const Eigen::MatrixXd& x, const Eigen::MatrixXd& q,
                Eigen::MatrixXd& jacobian) const override {
    Eigen::MatrixXd all;
    system_.jacobian(t, completed(x), q, all);
    jacobian.resize(Eigen::Index{states_} * states_, x.cols());
    const int n = system_.state_count();
    for (int k = 0; k < states_; ++k)
      jacobian.middleRows(Eigen::Index{states_} * k, states_) = all.middleRows(Eigen::Index{n} * k, states_);
  }

 private:
  Eigen::MatrixXd completed(const Eigen::MatrixXd& x) const {
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(system_.state_count(), x.cols());
    all.topRows(states_) = x;
    return all;
  }

  std::shared_ptr<models::ParametricModel> model_;
  codebooks::ModelSystem system_;
  int states_;
};

std::vector<double> centre(const std::vector<Interval>& box) {
  std::vector<double> q;
  for (const Interval& interval : box) q.push_back(0.5 * (interval.lower + interval.upper));
  return q;
}

/// u' of (6.24), state by state: (M v) x w over M, and (J w x w + M v x v) over J, M and J diagonal.
std::vector<Monomial> kirchhoff_terms(const Eigen::Vector3d& mass, const Eigen::Vector3d& inertia) {
  std::vector<Monomial> terms;
  const auto add = [&](int state, double coefficient, int a, int b) {
    std::vector<int> powers(6, 0);
    ++powers[static_cast<std::size_t>(a)];
    ++powers[static_cast<std::size_t>(b)];
    terms.push_back({state, coefficient, {}, powers});
  };
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    const int k = (i + 2) % 3;
    add(i, mass[j] / mass[i], j, 3 + k);
    add(i, -mass[k] / mass[i], k, 3 + j);
    add(3 + i, (inertia[j] - inertia[k]) / inertia[i], 3 + j, 3 + k);
    add(3 + i, (mass[j] - mass[k]) / inertia[i], j, k);
  }
  return terms;
}

}  // namespace

EvolutionProblem Problem::on(int slabs, int time_points, int nodes) const {
  EvolutionProblem problem{
      system.get(), Axis::radau({"t", "s", AxisRole::time}, 0.0, end, slabs, time_points), {}, {}, {}, {}};
  const models::ModelInfo& info = model->model().info();
  const models::Scales sizes = model->scales(centre(box));
  std::vector<double> start(info.states.size());
  model->initial(centre(box), start);
  for (const int s : states) {
    const auto state = static_cast<std::size_t>(s);
    problem.states.push_back({info.states[state].name, info.states[state].unit});
    problem.scales.push_back(models::state_scale(info.states[state], sizes));
    problem.initial.push_back({start[state], -1});
  }
  for (std::size_t k = 0; k < box.size(); ++k) {
    problem.parameters.push_back(Axis::chebyshev({box[k].name}, box[k].lower, box[k].upper, nodes));
    if (!model->free()[k].is_initial) continue;
    const auto state = static_cast<std::size_t>(
        std::find(states.begin(), states.end(), model->free()[k].index) - states.begin());
    problem.initial[state].axis = static_cast<int>(k);
    problem.scales[state] = std::max(std::abs(box[k].lower), std::abs(box[k].upper));
  }
  return problem;
}

Problem quadratic_drag(double end) {
  // u' = k C_D u^2 - g, as the model has it for a fall: u <= 0.
  Problem problem{nullptr, nullptr, {{"C_D", 0.5, 2.0}}, first_states(1), end};
  problem.model =
      model("quadratic_drag_fall", {{"mass", 0.1}, {"area", 0.5}, {"fluid_density", 1.23}}, problem.box);
  constexpr double kDrag = 1.23 * 0.5 / (2.0 * 0.1);
  problem.system =
      std::make_shared<PolynomialSystem>(1, 1, std::vector<Monomial>{{0, kDrag, {1}, {2}}, {0, -9.81}});
  return problem;
}

Problem triple_product(double end) {
  Problem problem{nullptr,
                  nullptr,
                  {{"u1(0)", 0.0, 1.0}, {"u2(0)", 0.0, 1.0}, {"u3(0)", 0.0, 1.0}},
                  first_states(3),
                  end};
  problem.model = model("coupled_triple", {}, problem.box);
  std::vector<Monomial> terms;
  for (int m = 0; m < 3; ++m) {
    std::vector<int> others = {1, 1, 1};
    others[static_cast<std::size_t>(m)] = 0;
    terms.push_back({m, m + 1.0});
    terms.push_back({m, -1.0, {}, others});
  }
  problem.system = std::make_shared<PolynomialSystem>(3, 3, terms);
  return problem;
}

Problem plate3(double end) {
  // vx, vy, w, theta; x and y follow from them.
  Problem problem{
      nullptr, nullptr, {{"C_T", 0.8, 1.4}, {"C_R", 2.0, 4.0}, {"A", 1.0, 1.8}}, first_states(4), end};
  problem.model = model("falling_plate_nd", {{"theta(0)", 0.4}, {"w(0)", 0.0}}, problem.box);
  problem.system = std::make_shared<PartOfModel>(problem.model, 4);
  return problem;
}

Eigen::VectorXd broadside_fall() {
  // vy^2 = pi/(A + B) balances weight and drag.
  return Eigen::Vector4d(0.0, -std::sqrt(std::numbers::pi / 2.4), 0.0, 0.0);
}

Problem broadside_plate(double tilt, double end) {
  Problem problem{nullptr, nullptr, {{"C_T", 0.8, 1.4}, {"C_R", 2.0, 4.0}}, first_states(4), end};
  problem.model =
      model("falling_plate_nd",
            {{"A", 1.4}, {"B", 1.0}, {"theta(0)", tilt}, {"w(0)", 0.0}, {"vy(0)", broadside_fall()[1]}},
            problem.box);
  problem.system = std::make_shared<PartOfModel>(problem.model, 4);
  return problem;
}

Problem kirchhoff(double end) {
  Problem problem;
  problem.end = end;
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) problem.box.push_back({name, 0.0, 0.1});
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) problem.box.push_back({name, 0.0, 1.0});
  problem.model = model("immersed_body",
                        {{"a", 0.04},
                         {"b", 0.02},
                         {"c", 0.01},
                         {"density", 1100.0},
                         {"fluid_density", 1000.0},
                         {"g", 0.0},
                         {"C_D0", 0.0},
                         {"C_D90", 0.0},
                         {"C_T", 0.0},
                         {"C_R", 0.0},
                         {"C_w", 0.0}},
                        problem.box);
  const models::ModelInfo& info = problem.model->model().info();
  const std::vector<double> p = problem.model->parameters(centre(problem.box));
  const auto value = [&](const std::string& name) {
    for (std::size_t j = 0; j < info.parameters.size(); ++j) {
      if (info.parameters[j].name == name) return p[j];
    }
    throw std::runtime_error(fmt::format("immersed_body has no parameter {}", name));
  };
  Eigen::Vector3d mass, inertia;
  for (int i = 0; i < 3; ++i) {
    const char axis = "xyz"[i];
    mass[i] = value("mass") + value(fmt::format("M_{}", axis));
    inertia[i] = value(fmt::format("I_{}", axis)) + value(fmt::format("J_{}", axis));
  }
  for (const char* name : {"ux", "uy", "uz", "wx", "wy", "wz"}) {
    const auto state = std::ranges::find(info.states, name, &models::StateInfo::name);
    problem.states.push_back(static_cast<int>(state - info.states.begin()));
  }
  problem.system = std::make_shared<PolynomialSystem>(6, 6, kirchhoff_terms(mass, inertia));
  return problem;
}

codebooks::Plan plate_plan(int coordinates, double end, double tolerance) {
  std::string text = "model = 'falling_plate_nd'\n[fixed]\n'w(0)' = 0.0\n";
  if (coordinates < 7) text += "'theta(0)' = 0.4\n";
  text += "[box]\nC_T = [0.8, 1.4]\nC_R = [2.0, 4.0]\nA = [1.0, 1.8]\n";
  if (coordinates >= 5) text += "B = [0.8, 1.2]\nmu1 = [0.1, 0.3]\n";
  if (coordinates == 7) text += "inertia_ratio = [1.0, 1.2]\n'theta(0)' = [0.3, 0.5]\n";
  text += fmt::format("[time]\nend = {}\n[tolerance]\nrelative = {}\n", end, tolerance);
  text += "[builder]\nkind = 'pgd'\nstrategy = 'slabs'\n";
  return codebooks::parse_plan(text, fmt::format("plate{}", coordinates));
}

Errors errors_of(const Problem& problem, const std::function<Eigen::VectorXd(std::span<const double>)>& value,
                 double end, int points) {
  const auto states = static_cast<Eigen::Index>(problem.states.size());
  models::Integrator integrator(*problem.model, {.relative_tolerance = 1e-11}, false);
  std::vector<double> times;
  for (int i = 1; i <= kTimes; ++i) times.push_back(end * i / kTimes);
  Random random(20261121);
  Eigen::ArrayXd lowest = Eigen::ArrayXd::Constant(states, HUGE_VAL), highest = -lowest;
  Eigen::ArrayXd largest = Eigen::ArrayXd::Zero(states), squares = largest, sizes = largest;
  for (int j = 0; j < points; ++j) {
    std::vector<double> x = {0.0};
    for (const Interval& interval : problem.box)
      x.push_back(interval.lower + (interval.upper - interval.lower) * random.uniform());
    const models::Trajectory exact = integrator(std::span(x).subspan(1), times);
    if (!exact.is_usable()) throw std::runtime_error(exact.message);
    for (int i = 0; i < kTimes; ++i) {
      x[0] = times[static_cast<std::size_t>(i)];
      const Eigen::ArrayXd at = exact.states.row(i)(problem.states).transpose();
      const Eigen::ArrayXd error = (value(x).array() - at).abs();
      lowest = lowest.min(at);
      highest = highest.max(at);
      largest = largest.max(error);
      squares += error.square();
      sizes += at.square();
    }
  }
  return {largest / (highest - lowest), (squares / sizes).sqrt(), largest};
}

}  // namespace samara::benchmarks
