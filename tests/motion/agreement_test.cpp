#include "samara/motion/patterns/agreement.h"

#include <catch2/catch.hpp>

#include "tests/error_text.h"

using namespace samara::motion;

TEST_CASE("agreement of two labellings has the values of a count by hand") {
  // Rows truth, columns answer: [2 1 0] [0 2 0] [1 0 2].
  const std::vector<int> truth = {0, 0, 0, 1, 1, 2, 2, 2}, answer = {0, 0, 1, 1, 1, 0, 2, 2};
  const Agreement both = agreement(truth, answer, 3);
  CHECK(both.confusion == (Eigen::Matrix3i() << 2, 1, 0, 0, 2, 0, 1, 0, 2).finished());
  CHECK(both.share == Approx(6.0 / 8.0));
  CHECK(both.balanced == Approx((2.0 / 3.0 + 1.0 + 2.0 / 3.0) / 3.0));
  // Chance: (3 3 + 2 3 + 3 2)/64.
  CHECK(both.kappa == Approx((0.75 - 21.0 / 64.0) / (1.0 - 21.0 / 64.0)));
  // Pairs together in both: 1 + 1 + 1; in the truth 3 + 1 + 3, in the answer 3 + 3 + 1; of 28.
  CHECK(both.adjusted_rand == Approx((3.0 - 49.0 / 28.0) / (7.0 - 49.0 / 28.0)));
}

TEST_CASE("a constant answer has a large share and no agreement beyond chance") {
  std::vector<int> truth(100, 0), constant(100, 0);
  for (int k = 0; k < 11; ++k) truth[static_cast<std::size_t>(k)] = 1;
  const Agreement both = agreement(truth, constant, 2);
  CHECK(both.share == Approx(0.89));
  CHECK(both.balanced == Approx(0.5));
  CHECK(both.kappa == Approx(0.0));
  CHECK(both.adjusted_rand == Approx(0.0));
}

TEST_CASE("the adjusted Rand index asks for partitions, not for names") {
  const std::vector<int> first = {0, 0, 1, 1, 2, 2}, renamed = {2, 2, 0, 0, 1, 1};
  CHECK(adjusted_rand(first, renamed) == Approx(1.0));
  CHECK(agreement(first, renamed, 3).share == 0.0);
  CHECK(agreement(first, first, 3).kappa == Approx(1.0));
}

TEST_CASE("labels that do not fit together are refused") {
  CHECK(error_text<samara::ArgumentError>([] {
          agreement({0, 1}, {0}, 2);
        }).find("there are 1 labels beside 2") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] {
          agreement({0, 2}, {0, 1}, 2);
        }).find("a label is 2, expected less than 2") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] { agreement({-1}, {0}, 2); }).find("a label is -1") !=
        std::string::npos);
}
