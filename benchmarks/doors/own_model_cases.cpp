/// Models of one's own: equations as text beside the same law compiled.
#include <random>
#include <vector>

#include "../../examples/own_model/predator_prey.h"
#include "cases.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/integrators/integrate.h"

namespace samara::benchmarks::doors {

namespace {

std::shared_ptr<const models::Model> text_model() {
  return codebooks::open_model("predator_prey.toml",
                               std::filesystem::path(SAMARA_EXAMPLES_DIR) / "own_model");
}

/// Four parameters within 10 %, three swings.
codebooks::BuildRequest request() {
  codebooks::BuildRequest request;
  request.box = {{.name = "growth", .lower = 0.9, .upper = 1.1},
                 {.name = "hunt", .lower = 0.09, .upper = 0.11},
                 {.name = "gain", .lower = 0.045, .upper = 0.055},
                 {.name = "death", .lower = 0.45, .upper = 0.55}};
  request.end = 15.0;
  return request;
}

codebooks::BuildResult built(const std::shared_ptr<const models::Model>& model) {
  return codebooks::build(models::ParametricModel(model, {}, {"growth", "hunt", "gain", "death"}), request());
}

/// A codebook by text and one by the compiled law, and how far apart they are over the ranges of their outputs.
void lotka_volterra(const Options& options) {
  if (!options.wants("lotka_volterra")) return;
  codebooks::BuildResult text = built(text_model());
  const double seconds = time_of([&] { text = built(text_model()); }, options.quick ? 1 : 3, 0.0);
  const codebooks::BuildResult compiled = built(models::make_model<PredatorPrey>());
  print({kBench, "lotka_volterra", "certificate_max", text.book.certificate()->max_error});
  print({kBench, "lotka_volterra", "met", text.met && compiled.met ? 1.0 : 0.0});
  print({kBench, "lotka_volterra", "calls", text.book.build().evaluations});
  print({kBench, "lotka_volterra", "time", seconds, "s"});
  codebooks::Query from_text(text.book), from_law(compiled.book);
  std::mt19937 random(41);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Eigen::VectorXd a(2), b(2), lowest = Eigen::VectorXd::Constant(2, 1e300), highest = -lowest,
                              apart = Eigen::VectorXd::Zero(2);
  for (int k = 0; k < 10'000; ++k) {
    std::vector<double> point = {15.0 * share(random)};
    for (const codebooks::BoxEntry& entry : request().box)
      point.push_back(entry.lower + (entry.upper - entry.lower) * share(random));
    from_text.values(point, a);
    from_law.values(point, b);
    lowest = lowest.cwiseMin(a);
    highest = highest.cwiseMax(a);
    apart = apart.cwiseMax((a - b).cwiseAbs());
  }
  print({kBench, "lotka_volterra", "difference", apart.cwiseQuotient(highest - lowest).maxCoeff()});
}

/// The right-hand side and its Jacobian at many points, as a build asks for them.
void equations_rhs(const Options& options) {
  if (!options.wants("equations_rhs")) return;
  constexpr Eigen::Index kPoints = 4096;
  const auto text = text_model();
  const auto compiled = models::make_model<PredatorPrey>();
  const Eigen::VectorXd t = Eigen::VectorXd::Zero(kPoints);
  const Eigen::MatrixXd x = Eigen::MatrixXd::Random(2, kPoints).array() + 2.0;
  const Eigen::MatrixXd p = Eigen::MatrixXd::Random(4, kPoints).array() + 2.0;
  Eigen::MatrixXd f(2, kPoints), jacobians(4, kPoints);
  const auto rates =
      time_both([&] { text->rhs_at_points(t, x, p, f); }, [&] { compiled->rhs_at_points(t, x, p, f); });
  print({kBench, "equations_rhs", "time", rates.ours / kPoints, "s", "compiled", rates.ratio()});
  const auto slopes = time_both([&] { text->jacobians_at_points(t, x, p, jacobians); },
                                [&] { compiled->jacobians_at_points(t, x, p, jacobians); });
  print({kBench, "equations_rhs", "jacobian_time", slopes.ours / kPoints, "s", "compiled", slopes.ratio()});
}

}  // namespace

void own_model_cases(const Options& options) {
  lotka_volterra(options);
  equations_rhs(options);
}

}  // namespace samara::benchmarks::doors
