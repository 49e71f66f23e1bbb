// A user's program: makes a model of a law of its own, builds and saves its codebook, asks it, compares with the exact
// solution, and fits what it computed itself.
#include <cmath>
#include <cstdio>
#include <vector>

#include <samara/codebooks/build/build.h>
#include <samara/codebooks/composition/codebook_trajectories.h>
#include <samara/codebooks/file/save.h>
#include <samara/codebooks/query/query.h>
#include <samara/identification/fit/fit.h>
#include <samara/models/checks/check_model.h>

#include "growth.h"

using namespace samara;

int main(int argc, char** argv) {
  const auto model = models::make_model<Growth>();
  const Check check = models::check_model(*model);
  for (const std::string& finding : check.findings) std::printf("%s\n", finding.c_str());
  codebooks::BuildRequest request;
  request.box = {{.name = "rate", .lower = 0.2, .upper = 0.8}};
  request.end = 2.0;
  request.relative = 1e-9;
  const auto result = codebooks::build(models::ParametricModel(model, {}, {"rate"}), request);
  std::printf("%s\n", result.message.c_str());
  if (argc > 1) codebooks::save(result.book, argv[1]);

  codebooks::Query query(result.book);
  Eigen::VectorXd x(1);
  const double point[] = {2.0, 0.5};  // t, rate
  query.values(point, x);
  std::printf("x = %.15g, exact %.15g\n", x[0], std::exp(1.0));

  identification::Capture capture;
  capture.id = "computed";
  capture.times = Eigen::VectorXd::LinSpaced(21, 0.0, 2.0);
  capture.channels = {
      {.quantity = "x", .unit = "1", .values = (0.63 * capture.times.array()).exp().matrix()}};
  const auto family = codebooks::codebook_trajectories(result.book);
  const auto fit = identification::fit(*family, std::vector{capture}, {.loss = {.scales = {{"x", 0.01}}}});
  std::printf("rate = %.9g, computed with 0.63\n", fit.coefficients[0].value);
  return check.passed() && result.met && std::abs(x[0] - std::exp(1.0)) < 1e-8 &&
                 std::abs(fit.coefficients[0].value - 0.63) < 1e-7
             ? 0
             : 1;
}
