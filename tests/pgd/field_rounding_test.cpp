#include "samara/pgd/fields/field_rounding.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/sampling/sampling.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::pgd;

namespace {

/// Two outputs of sizes 1 and 1000, sampled far more exactly than they are wanted.
const SamplingResult& sampled() {
  static const SamplingResult result =
      sample({{{"a"}, -1.0, 1.0}, {{"b"}, 0.5, 2.0}, {{"c"}, 0.0, 1.0}}, {{"u"}, {"v"}},
             [](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
               for (Eigen::Index j = 0; j < points.cols(); ++j) {
                 const double a = points(0, j), b = points(1, j), c = points(2, j);
                 values(0, j) = 1.0 / (3.0 + a * b * c);
                 values(1, j) = 1000.0 * std::sin(a + 2.0 * b * c);
               }
             },
             {.tolerance = 1e-7});
  return result;
}

}  // namespace

TEST_CASE("a rounded train differs by no more than the tolerance of each output's scale, and is smaller") {
  INFO(sampled().message);
  REQUIRE(sampled().tolerance_met());
  const TrainField& field = *sampled().field;
  const Eigen::VectorXd& scale = sampled().range;
  long before = field.entries();
  for (const double tolerance : {1e-6, 1e-4, 1e-2}) {
    const RoundedField cut = rounded(field, scale, tolerance, 3);
    CHECK(cut.error <= tolerance);
    CHECK(cut.field.entries() < before);
    before = cut.field.entries();
    Random random(8);
    double worst = 0.0;
    for (int i = 0; i < 5000; ++i) {
      const std::vector<double> x = {2.0 * random.uniform() - 1.0, 0.5 + 1.5 * random.uniform(),
                                     random.uniform()};
      worst = std::max(worst, (cut.field(x) - field(x)).cwiseQuotient(scale).cwiseAbs().maxCoeff());
    }
    // Other points than those of the rounding may see a little more.
    CHECK(worst <= 1.5 * tolerance);
  }
}

TEST_CASE("rounding to nothing changes nothing beyond rounding errors") {
  const TrainField& field = *sampled().field;
  const RoundedField same = rounded(field, sampled().range, 0.0, 3);
  CHECK(same.error == 0.0);
  CHECK(same.field.entries() == field.entries());
}

TEST_CASE("rounding asks for a positive scale per output and a tolerance") {
  const TrainField& field = *sampled().field;
  CHECK_THROWS_AS(rounded(field, Eigen::Vector3d::Ones(), 0.1, 1), samara::ArgumentError);
  CHECK_THROWS_AS(rounded(field, Eigen::Vector2d(1.0, 0.0), 0.1, 1), samara::ArgumentError);
  CHECK_THROWS_AS(rounded(field, Eigen::Vector2d::Ones(), -0.1, 1), samara::ArgumentError);
}
