#include "samara/identification/statistics/determined_inverse.h"

#include <Eigen/LU>
#include <catch2/catch.hpp>

using namespace samara::identification;

TEST_CASE("of a regular matrix it is the inverse, however the unknowns are scaled") {
  Eigen::MatrixXd J(4, 3);
  J << 1, 2, 0, 0, 1, 1, 3, 0, 1, 1, 1, 1;
  const Eigen::Vector3d scale(1e-6, 1.0, 1e6);
  const Eigen::MatrixXd A = scale.asDiagonal() * (J.transpose() * J) * scale.asDiagonal();
  const DeterminedInverse result = invert_determined(A, Eigen::Vector3d::Zero());
  CHECK(result.all_determined());
  const Eigen::MatrixXd one = scale.asDiagonal() * result.inverse * A * scale.cwiseInverse().asDiagonal();
  CHECK((one - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-12);
}

TEST_CASE("unknowns that only count together are named together") {
  // Columns 0 and 2 are proportional.
  Eigen::MatrixXd J(4, 3);
  J << 1, 2, 3, 0, 1, 0, 3, 0, 9, 1, 1, 3;
  const DeterminedInverse result = invert_determined(J.transpose() * J, Eigen::Vector3d::Zero());
  REQUIRE(result.undetermined_sets.size() == 1);
  CHECK(result.undetermined_sets[0] == std::vector<int>{0, 2});
  CHECK(result.determined == std::vector<char>{0, 1, 0});
  // The determined one has the variance it has when one of the others is held.
  const Eigen::MatrixXd held = J.leftCols(2);
  const Eigen::MatrixXd inverse = (held.transpose() * held).inverse();
  CHECK(std::abs(result.inverse(1, 1) / inverse(1, 1) - 1.0) < 1e-10);
}

TEST_CASE("an unknown without influence is named, and leaves the others alone") {
  Eigen::Matrix2d A;
  A << 4, 0, 0, 1e-20;
  const DeterminedInverse result = invert_determined(A, Eigen::Vector2d(1e-15, 1e-15));
  CHECK(result.determined == std::vector<char>{1, 0});
  CHECK(result.undetermined_sets == std::vector<std::vector<int>>{{1}});
  CHECK(result.inverse(0, 0) == Approx(0.25));
  CHECK(result.inverse(1, 1) == 0.0);
}
