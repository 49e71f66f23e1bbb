#include "samara/identification/problem/chart.h"

#include <catch2/catch.hpp>

#include "samara/pgd/tensors/random.h"

using samara::identification::Chart;
using samara::identification::Turn;
using samara::identification::turn_between;

namespace {

Eigen::VectorXd random_point(samara::pgd::Random& random) {
  Eigen::VectorXd x(6);
  for (double& value : x) value = random.normal();
  x[1] = 0.5 + random.uniform();  // logarithmic
  x.segment<4>(2) = x.segment<4>(2).normalized();
  return x;
}

const Chart kChart({Chart::Kind::linear, Chart::Kind::logarithmic, Chart::Kind::quaternion});

}  // namespace

TEST_CASE("a step in a chart leads to the point from which minus leads back") {
  samara::pgd::Random random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    Eigen::VectorXd step(5), y(6), back(5);
    for (double& value : step) value = 0.8 * random.normal();
    kChart.plus(x.data(), step.data(), y.data());
    CHECK(y.segment<4>(2).norm() == Approx(1.0).epsilon(1e-14));
    CHECK(y[1] > 0.0);
    kChart.minus(y.data(), x.data(), back.data());
    // Turns by more than pi come back the shorter way.
    if (step.tail<3>().norm() < 3.1) CHECK((back - step).norm() < 1e-12);
  }
}

TEST_CASE("the derivatives of a chart are those of its steps") {
  samara::pgd::Random random(2);
  const Eigen::VectorXd x = random_point(random);
  const Eigen::MatrixXd plus = kChart.plus_jacobian(x.data());
  constexpr double kStep = 1e-6;  // central differences: an error of 1e-12 and rounding of 1e-10
  for (Eigen::Index d = 0; d < 5; ++d) {
    Eigen::VectorXd step = Eigen::VectorXd::Zero(5), up(6), down(6);
    step[d] = kStep;
    kChart.plus(x.data(), step.data(), up.data());
    step[d] = -kStep;
    kChart.plus(x.data(), step.data(), down.data());
    CHECK((plus.col(d) - (up - down) / (2.0 * kStep)).norm() < 1e-9);
  }
  // minus after plus is the identity.
  CHECK((kChart.minus_jacobian(x.data()) * plus - Eigen::MatrixXd::Identity(5, 5)).norm() < 1e-12);
}

TEST_CASE("what is held does not move and has no direction") {
  const Chart held = kChart.holding(1);
  CHECK(held.size() == 6);
  CHECK(held.directions() == 4);
  CHECK(held.direction_of(1) == -1);
  CHECK(held.direction_of(0) == 0);
  CHECK(held.direction_of(2) == 1);
  CHECK(held.direction_of(5) == -1);
  samara::pgd::Random random(3);
  const Eigen::VectorXd x = random_point(random);
  Eigen::VectorXd y(6);
  const Eigen::VectorXd step = Eigen::VectorXd::Constant(4, 0.3);
  held.plus(x.data(), step.data(), y.data());
  CHECK(y[1] == x[1]);
  CHECK(y[0] != x[0]);
}

TEST_CASE("a turn between attitudes is its rotation vector, whatever length and sign the quaternions have") {
  samara::pgd::Random random(4);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::VectorXd x = random_point(random);
    Eigen::VectorXd step = Eigen::VectorXd::Zero(5), y(6);
    for (Eigen::Index k = 2; k < 5; ++k) step[k] = random.normal();
    if (trial == 0) step.setZero();
    kChart.plus(x.data(), step.data(), y.data());
    const Eigen::Vector4d from = 3.0 * x.segment<4>(2);
    const Eigen::Vector4d to = -0.2 * y.segment<4>(2);
    const Turn turn = turn_between(from.data(), to.data());
    if (step.tail<3>().norm() < 3.1) CHECK((turn.vector - step.tail<3>()).norm() < 1e-12);
    CHECK(turn.vector.norm() < 3.1416);
    constexpr double kStep = 1e-6;
    for (int part = 0; part < 4; ++part) {
      Eigen::Vector4d up = to, down = to;
      up[part] += kStep;
      down[part] -= kStep;
      const Eigen::Vector3d difference =
          (turn_between(from.data(), up.data()).vector - turn_between(from.data(), down.data()).vector) /
          (2.0 * kStep);
      // Near a half turn the vector jumps to its opposite, and differences mean nothing.
      if (turn.vector.norm() < 3.0) CHECK((turn.by_to.col(part) - difference).norm() < 1e-6);
    }
  }
}
