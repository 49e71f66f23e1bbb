#include "samara/codebooks/build/line_nodes.h"

#include <cmath>
#include <optional>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/codebooks/build/line_elements.h"
#include "samara/pgd/tensors/random.h"

// Nodes and elements that functions along lines through a box ask for.

using namespace samara::codebooks;

TEST_CASE("the nodes of lines follow the width of a front, which is named where they are too many") {
  // tanh((x - y/10)/w) has poles at a distance of pi w / 2 from [-1, 1]: with n nodes errors fall like
  // exp(-n pi w / 2), and its steepest slope is a half of its range by w.
  const double bound = 1e-4, tolerance = 1e-3;
  for (const double width : {0.3, 0.02}) {
    LineNodes lines(
        2, [](Eigen::Index, int nodes) { return samara::pgd::Axis::chebyshev({"x"}, -1.0, 1.0, nodes); },
        [&](const Eigen::MatrixXd& points) -> Eigen::MatrixXd {
          return ((points.row(0) - 0.1 * points.row(1)) / width).array().tanh();
        },
        128);
    const Eigen::MatrixXd bases = Eigen::MatrixXd::Random(2, 8);
    lines.look_along(0, bases, bound, tolerance);
    lines.look_along(1, bases, bound, tolerance);
    const double needed = std::log(1.0 / bound) / (0.5 * 3.14159 * width);
    const std::vector<int> nodes = lines.within(bound);
    CAPTURE(width, needed, nodes);
    CHECK(nodes[1] < nodes[0]);
    if (width > 0.1) {
      CHECK_FALSE(lines.front());
      CHECK(nodes[0] >= 0.8 * needed);
      CHECK(nodes[0] <= 1.5 * needed + 3);
    } else {
      CHECK(nodes[0] == 128);
      REQUIRE(lines.front());
      CHECK(lines.front()->coordinate == 0);
      CHECK(lines.front()->width == Approx(2.0 * width).epsilon(0.1));
      CHECK(lines.front()->nodes >= 0.8 * std::log(1.0 / tolerance) / (0.5 * 3.14159 * width));
      CHECK(lines.front()->nodes <= 1.5 * std::log(1.0 / tolerance) / (0.5 * 3.14159 * width));
      CHECK(lines.front()->error > tolerance);
      CHECK(lines.front()->allowed == 128);
    }
  }
}

TEST_CASE("elements are short where a front passes, and are given up where they would be too many") {
  constexpr double kWidth = 0.01;
  const auto values = [&](const Eigen::MatrixXd& points) -> Eigen::MatrixXd {
    return ((points.row(0) - 0.2 * points.row(1)) / kWidth).array().tanh();
  };
  samara::pgd::Random random(3);
  const auto bases = [&] {
    Eigen::MatrixXd some(2, 16);
    for (double& x : some.reshaped()) x = 2.0 * random.uniform() - 1.0;
    return some;
  };
  LineElementsOptions options;
  const std::optional<LineElements> found = elements_along(0, {"x"}, -1.0, 1.0, values, bases, options);
  REQUIRE(found);
  // The steepest places are in the middle of the front, to the distance of nodes, which is less than its width.
  const Eigen::RowVectorXd off = found->steepest.row(0) - 0.2 * found->steepest.row(1);
  CHECK(off.cwiseAbs().maxCoeff() <= kWidth);
  const Eigen::VectorXd& borders = found->axis.borders();
  for (int e = 0; e < found->axis.elements(); ++e) {
    const double size = borders[e + 1] - borders[e], middle = 0.5 * (borders[e + 1] + borders[e]);
    if (std::abs(middle) > 0.9) CHECK(size >= 0.2);
    if (std::abs(middle) < 0.15) CHECK(size <= 8.0 * kWidth);
  }
  // Begun from these, all borders stay, and elements are halved where they err by more than the finer tolerance.
  LineElementsOptions finer = options;
  finer.borders = borders;
  finer.tolerance = 0.01 * options.tolerance;
  const std::optional<LineElements> halved = elements_along(0, {"x"}, -1.0, 1.0, values, bases, finer);
  REQUIRE(halved);
  CHECK(halved->axis.elements() > found->axis.elements());
  for (const double border : borders) CHECK((halved->axis.borders().array() == border).any());
  options.max_nodes = 40;
  CHECK_FALSE(elements_along(0, {"x"}, -1.0, 1.0, values, bases, options));
}
