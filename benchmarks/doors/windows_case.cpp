/// Windows of a fluttering plate, composed to forty characteristic times.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/models/integrators/integrate.h"
#include "samara/pgd/tensors/random.h"

namespace samara::benchmarks::doors {

namespace {

constexpr double kEnd = 40.0;

/// Coefficients within 10 % of those of a flutter, and all states that it passes, but for what symmetry gives: a half
/// turn of the plate and a reflection bring both velocities to zero or above, where the corner of the law at rest is a
/// corner of the box. Where it lies is free by symmetry, too.
constexpr const char* kPlan = R"toml(model = "falling_plate_nd"
[fixed]
inertia_ratio = 1.1
[box]
C_T = [0.99, 1.21]
C_R = [2.7, 3.3]
A = [1.26, 1.54]
"vx(0)" = [0.0, 3.5]
"vy(0)" = [0.0, 0.65]
"w(0)" = [-1.0, 1.0]
"theta(0)" = [-3.14159265358979324, 3.14159265358979324]
[time]
end = 0.1
[tolerance]
relative = 2e-6
)toml";

struct Composed {
  /// Ascending: largest error of a fall, of the range of that state over all falls.
  std::vector<double> shares;
  int within = 0;  ///< falls that stay in the box
};

/// Falls with random coefficients, composed and by the reference integrator.
Composed compose_falls(const codebooks::Plan& plan, codebooks::FlowMap& map, int falls, std::uint64_t seed) {
  std::vector<double> times;
  for (int k = 1; k <= 80; ++k) times.push_back(kEnd * k / 80.0);
  const models::ParametricModel model(plan.parametric_model().shared_model(),
                                      {{"inertia_ratio", 1.1}, {"theta(0)", 0.785}}, {"C_T", "C_R", "A"});
  pgd::Random random(seed);
  const auto states = static_cast<Eigen::Index>(map.states().size());
  Eigen::VectorXd lowest = Eigen::VectorXd::Constant(states, HUGE_VAL), highest = -lowest;
  std::vector<Eigen::VectorXd> errors;  // largest of each state, of one fall after the other
  std::vector<double> start(static_cast<std::size_t>(states));
  Composed result;
  for (int fall = 0; fall < falls; ++fall) {
    std::vector<double> q;
    for (std::size_t k = 0; k < 3; ++k)
      q.push_back(plan.box[k].lower + (plan.box[k].upper - plan.box[k].lower) * random.uniform());
    model.initial(q, start);
    const codebooks::FlowMapResult composed = map.run(start, q, times);
    const Eigen::MatrixXd exact = models::integrate(model, q, times).states;
    if (composed.status != codebooks::FlowMapStatus::done) continue;
    ++result.within;
    lowest = lowest.cwiseMin(exact.colwise().minCoeff().transpose());
    highest = highest.cwiseMax(exact.colwise().maxCoeff().transpose());
    errors.push_back((composed.states - exact).cwiseAbs().colwise().maxCoeff().transpose());
  }
  for (const Eigen::VectorXd& error : errors)
    result.shares.push_back(error.cwiseQuotient(highest - lowest).maxCoeff());
  std::ranges::sort(result.shares);
  return result;
}

}  // namespace

void windows_case(const Options& options) {
  constexpr const char* kName = "windows_plate";
  if (!options.wants(kName)) return;
  const codebooks::Plan plan = codebooks::parse_plan(kPlan, "windows_plate.toml");
  const codebooks::BuildResult built = codebooks::build(plan);
  print({kBench, kName, "certificate_max", built.book.certificate()->max_error});
  print({kBench, kName, "met", built.met ? 1.0 : 0.0});
  print({kBench, kName, "build_time", built.book.provenance().build_seconds, "s"});
  codebooks::FlowMap map(built.book);
  const int falls = options.quick ? 20 : 200;
  const auto worst = [](const Composed& of) { return of.shares.empty() ? NAN : of.shares.back(); };
  const Composed first = compose_falls(plan, map, falls, 29), second = compose_falls(plan, map, falls, 77003);
  print({kBench, kName, "error", worst(first)});
  print({kBench, kName, "error_median", first.shares.empty() ? NAN : first.shares[first.shares.size() / 2]});
  print(
      {kBench, kName, "below_1e-2",
       static_cast<double>(std::ranges::count_if(first.shares, [](double e) { return e < 1e-2; })) / falls});
  print({kBench, kName, "within_box", static_cast<double>(first.within) / falls});
  // Other falls, of a seed that nothing was chosen by.
  print({kBench, kName, "other_error", worst(second)});
  print({kBench, kName, "other_within_box", static_cast<double>(second.within) / falls});
}

}  // namespace samara::benchmarks::doors
