// A model of your own, from its right-hand side to a codebook and a fit.
#include <cmath>
#include <cstdio>
#include <vector>

#include "predator_prey.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/file/save.h"
#include "samara/identification/fit/fit.h"
#include "samara/models/checks/check_model.h"
#include "samara/models/integrators/integrate.h"

using namespace samara;

int main(int argc, char** argv) {
  const auto model = models::make_model<PredatorPrey>();
  const Check check = models::check_model(*model);
  for (const std::string& finding : check.findings) std::printf("%s\n", finding.c_str());

  // growth and hunt stay free, the others are fixed.
  const models::ParametricModel parametric(model, {{"gain", 0.05}, {"death", 0.5}},
                                           {"growth", "hunt"});
  codebooks::BuildRequest request;
  request.box = {{.name = "growth", .lower = 0.8, .upper = 1.2},
                 {.name = "hunt", .lower = 0.08, .upper = 0.12}};
  request.end = 10.0;
  const codebooks::BuildResult built = codebooks::build(parametric, request);
  std::printf("%s\n", built.message.c_str());
  codebooks::save(built.book, argc > 1 ? argv[1] : "predator_prey.h5");

  // Counts of ten seconds by a known truth, and the growth that a fit finds in them.
  const std::vector<double> truth = {1.05, 0.1};
  std::vector<double> times;
  for (int k = 0; k <= 40; ++k) times.push_back(0.25 * k);
  const models::Trajectory counted = models::integrate(parametric, truth, times);
  identification::Capture capture;
  capture.id = "island";
  capture.times =
      Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()));
  for (int state = 0; state < 2; ++state)
    capture.channels.push_back({.quantity = state == 0 ? "prey" : "predator",
                                .unit = "1",
                                .values = counted.states.col(state)});
  const auto family = codebooks::codebook_trajectories(built.book);
  const identification::FitResult fit = identification::fit(
      *family, std::vector{capture}, {.loss = {.scales = {{"prey", 1.0}, {"predator", 1.0}}}});
  for (const identification::Coefficient& c : fit.coefficients)
    std::printf("%s = %.4f\n", c.name.c_str(), c.value);
  const bool is_right = std::abs(fit.coefficients[0].value - truth[0]) < 1e-3;
  return check.passed() && built.met && is_right ? 0 : 1;
}
