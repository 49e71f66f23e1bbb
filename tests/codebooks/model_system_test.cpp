#include "samara/codebooks/source/model_system.h"

#include <map>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/models/laws/registry.h"

using samara::codebooks::ModelSystem;
using samara::models::ParametricModel;

namespace {

ParametricModel plate(const std::vector<std::string>& free) {
  return {samara::models::find_model("falling_plate_nd"), {}, free};
}

}  // namespace

TEST_CASE("a model is affine in its coefficients and in initial values, not in other parameters") {
  const ParametricModel coefficients = plate({"C_T", "C_R", "A", "theta(0)"});
  CHECK(ModelSystem(coefficients).affine_in_parameters());
  const ParametricModel inertia = plate({"C_T", "inertia_ratio"});
  CHECK_FALSE(ModelSystem(inertia).affine_in_parameters());
}

TEST_CASE("where a model says it is affine, f at the middle of two points is the mean of both") {
  const ParametricModel model = plate({"C_T", "C_R", "A", "B", "mu1", "mu2"});
  const ModelSystem system(model);
  REQUIRE(system.affine_in_parameters());
  Eigen::MatrixXd x(6, 3), q(6, 3), f;
  x.col(0) << 0.4, -0.7, 0.9, 0.3, 0.0, 0.0;
  x.col(1) = x.col(2) = x.col(0);
  q.col(0) << 0.8, 2.0, 1.0, 0.8, 0.1, 0.0;
  q.col(1) << 1.4, 4.0, 1.8, 1.2, 0.3, 0.2;
  q.col(2) = 0.5 * (q.col(0) + q.col(1));
  system.rhs(Eigen::VectorXd::Zero(3), x, q, f);
  // Rates of the order of one, sums of some ten terms.
  CHECK((0.5 * (f.col(0) + f.col(1)) - f.col(2)).cwiseAbs().maxCoeff() < 1e-14);
}
