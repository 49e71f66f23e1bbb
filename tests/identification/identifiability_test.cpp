#include "samara/identification/statistics/identifiability.h"

#include <cmath>
#include <limits>

#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {

/// Information that holds each row's combination of the coefficients to within its error.
Eigen::MatrixXd information_of(const Eigen::MatrixXd& combinations, double error = 0.01) {
  return combinations.transpose() * combinations / (error * error);
}

std::vector<InformedCoefficient> three() {
  return {{"C_D0", 0.1, 1.0}, {"C_D90", 1.2, 1.0}, {"C_w", 0.5, 1.0}};
}

}  // namespace

TEST_CASE("what is determined needs no words") {
  const Identifiability all = identifiability(three(), information_of(Eigen::MatrixXd::Identity(3, 3)));
  CHECK(all.phrases.empty());
  CHECK(all.undetermined_count == 0);
  REQUIRE(all.directions.size() == 3);
  CHECK(all.directions[0].kind == DirectionKind::determined);
  CHECK(all.directions[0].standard_error == Approx(0.01));
}

TEST_CASE("a coefficient without influence is known not at all") {
  Eigen::MatrixXd known = Eigen::MatrixXd::Identity(3, 3);
  known(2, 2) = 0.0;
  const Identifiability result = identifiability(three(), information_of(known));
  REQUIRE(result.phrases.size() == 1);
  CHECK(result.phrases[0] == "C_w not at all");
  CHECK(std::isinf(result.directions[0].standard_error));
  CHECK(result.directions[0].vector[2] == Approx(1.0));
}

TEST_CASE("sums, differences and other combinations of two are named") {
  Eigen::MatrixXd known(2, 3);
  known << 1.0, 1.0, 0.0, 0.0, 0.0, 1.0;
  CHECK(identifiability(three(), information_of(known)).phrases.at(0) == "C_D0 and C_D90 only as a sum");
  known(0, 1) = -1.0;
  CHECK(identifiability(three(), information_of(known)).phrases.at(0) ==
        "C_D0 and C_D90 only as a difference");
  known(0, 1) = 0.4;
  CHECK(identifiability(three(), information_of(known)).phrases.at(0) ==
        "C_D0 and C_D90 only as C_D0 + 0.4 C_D90");
}

TEST_CASE("the words do not depend on the scales of the coefficients") {
  std::vector<InformedCoefficient> coefficients = three();
  coefficients[0].scale = 0.3;
  coefficients[1].scale = 2.0;
  Eigen::MatrixXd known(2, 3);
  known << 1.0, 1.0, 0.0, 0.0, 0.0, 1.0;
  CHECK(identifiability(coefficients, information_of(known, 1e-4)).phrases.at(0) ==
        "C_D0 and C_D90 only as a sum");
}

TEST_CASE("logarithms give ratios and products, and so do relative changes of plain ones") {
  std::vector<InformedCoefficient> two = {{"C_T", 1.2, 1.0, true}, {"C_R", 3.0, 1.0, true}};
  Eigen::MatrixXd known(1, 2);
  known << 1.0, -1.0;
  CHECK(identifiability(two, information_of(known)).phrases.at(0) == "C_T only relative to C_R (ratio)");
  known << 1.0, 1.0;
  CHECK(identifiability(two, information_of(known)).phrases.at(0) == "C_T and C_R only as a product");
  known << 1.0, 0.5;
  CHECK(identifiability(two, information_of(known)).phrases.at(0) == "C_T and C_R only as C_T * C_R^0.5");
  // d(C_T/C_R) = dC_T/C_R - C_T dC_R/C_R^2.
  two[0].log_scaled = two[1].log_scaled = false;
  known << 1.0 / 3.0, -1.2 / 9.0;
  CHECK(identifiability(two, information_of(known)).phrases.at(0) == "C_T only relative to C_R (ratio)");
}

TEST_CASE("two unknown directions of three coefficients leave one combination") {
  // The two eigenvectors of eigenvalue zero are arbitrary: the words must not be.
  Eigen::MatrixXd known(1, 3);
  known << 1.0, 2.0, -0.5;
  const Identifiability result = identifiability(three(), information_of(known));
  CHECK(result.undetermined_count == 2);
  REQUIRE(result.phrases.size() == 1);
  CHECK(result.phrases[0] == "C_D0, C_D90 and C_w only as C_D0 + 2 C_D90 - 0.5 C_w");
}

TEST_CASE("four coefficients in two combinations are said to be so") {
  std::vector<InformedCoefficient> four = three();
  four.push_back({"A", 1.0, 1.0});
  Eigen::MatrixXd known(2, 4);
  known << 1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 3.0, 5.0;
  const Identifiability result = identifiability(four, information_of(known));
  REQUIRE(result.phrases.size() == 1);
  CHECK(result.phrases[0] == "C_D0, C_D90, C_w and A in 2 combinations only");
}

TEST_CASE("separate pairs get separate words") {
  std::vector<InformedCoefficient> four = three();
  four.push_back({"A", 1.0, 1.0});
  Eigen::MatrixXd known(2, 4);
  known << 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, -1.0;
  const Identifiability result = identifiability(four, information_of(known));
  REQUIRE(result.phrases.size() == 2);
  CHECK(result.phrases[0] == "C_D0 and C_D90 only as a sum");
  CHECK(result.phrases[1] == "C_w and A only as a difference");
}

TEST_CASE("the thresholds are those of the documentation") {
  const std::vector<InformedCoefficient> one = {{"k", 1.0, 2.0}};
  const auto with_error = [&](double error) {
    // In scales of 2: information of the coefficient itself is 1/(2 error)^2.
    return identifiability(one, Eigen::MatrixXd::Constant(1, 1, 1.0 / std::pow(2.0 * error, 2)));
  };
  CHECK(with_error(0.24).directions[0].kind == DirectionKind::determined);
  CHECK(with_error(0.26).directions[0].kind == DirectionKind::weak);
  CHECK(with_error(0.26).phrases.at(0) == "k only roughly");
  CHECK(with_error(0.57).directions[0].kind == DirectionKind::weak);
  CHECK(with_error(0.58).directions[0].kind == DirectionKind::undetermined);
  CHECK(with_error(0.58).directions[0].standard_error == Approx(0.58));
  // The dispersion widens errors by its root.
  CHECK(identifiability(one, Eigen::MatrixXd::Constant(1, 1, 1.0), 4.0).directions[0].standard_error ==
        Approx(1.0));
}

TEST_CASE("a weak direction of two coefficients says how far they may go together") {
  const std::vector<InformedCoefficient> two = {{"a", 1.0, 1.0}, {"b", 1.0, 1.0}};
  const double r = std::sqrt(0.5);
  Eigen::MatrixXd known(2, 2);
  known << r / 0.01, r / 0.01, r / 0.4, -r / 0.4;
  const Identifiability result = identifiability(two, known.transpose() * known);
  REQUIRE(result.phrases.size() == 1);
  CHECK_THAT(result.phrases[0],
             Contains("a and b only roughly along one line") && Contains("by +0.28") && Contains("by -0.28"));
}

TEST_CASE("no coefficients, no words; and nonsense is refused") {
  CHECK(identifiability({}, Eigen::MatrixXd(0, 0)).directions.empty());
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  CHECK_THROWS_AS(identifiability({{"a"}}, Eigen::MatrixXd::Identity(2, 2)), samara::ArgumentError);
  CHECK_THROWS_AS(identifiability({{"a"}}, one, 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(identifiability({{"a", 1.0, 0.0}}, one), samara::ArgumentError);
  CHECK_THROWS_AS(identifiability({{"a", -1.0, 1.0, true}}, one), samara::ArgumentError);
  CHECK_THROWS_AS(identifiability({{"a"}}, one * std::numeric_limits<double>::quiet_NaN()),
                  samara::ArgumentError);
}
