#include "samara/codebooks/build/stepped_grid.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/codebooks/plan/plan.h"
#include "samara/pgd/tensors/train_points.h"

// The grid of a build by steps, of values of our own in the place of trajectories.

using namespace samara::codebooks;

namespace {

constexpr double kRelative = 1e-3;

double front_at(double x, double y, double width) {
  return std::tanh((x - 0.5 * y) / width);
}

/// Over [-1, 1] x [-1, 1], chosen for tanh((x - y/2)/width): with n nodes errors along x fall like exp(-n pi width / 2),
/// along y twice as fast.
struct FrontGrid {
  explicit FrontGrid(double width, const std::string& builder = "")
      : plan(parse_plan(R"toml([equations]
name = "box"
states.s = { initial = 0 }
parameters.x = { default = 0 }
parameters.y = { default = 0 }
rates.s = "x + y"
[box]
x = [-1, 1]
y = [-1, 1]
[time]
end = 1
[tolerance]
relative = 1e-3
[builder]
kind = "sampling"
strategy = "steps"
)toml" + builder,
                        "plan.toml")),
        grid(plan, labels, trajectories, [width](const Eigen::MatrixXd& points) {
          Eigen::MatrixXd values(1, points.cols());
          for (Eigen::Index j = 0; j < points.cols(); ++j)
            values(0, j) = front_at(points(0, j), points(1, j), width);
          return values;
        }) {
    grid.look_along_lines(random);
  }

  const Plan plan;
  const samara::models::ParametricModel model = plan.parametric_model();
  const samara::ProgressCallback progress;
  const std::vector<samara::pgd::Axis::Label> labels = {{"x"}, {"y"}};
  SteppedTrajectories trajectories = {model, 0.1, 1, 1'000'000, progress};
  samara::pgd::Random random{5};
  SteppedGrid grid;
};

/// Of the interpolation between all nodes, at points about the front.
double error_about(const std::vector<samara::pgd::Axis>& axes, double width) {
  const Eigen::VectorXd& x = axes[0].nodes();
  const Eigen::VectorXd& y = axes[1].nodes();
  Eigen::MatrixXd at_nodes(x.size(), y.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    for (Eigen::Index j = 0; j < y.size(); ++j) at_nodes(i, j) = front_at(x[i], y[j], width);
  }
  constexpr int kPoints = 500;
  samara::pgd::Random random(17);
  Eigen::MatrixXd points(2, kPoints);
  for (int j = 0; j < kPoints; ++j) {
    points(1, j) = 2.0 * random.uniform() - 1.0;
    points(0, j) = std::clamp(0.5 * points(1, j) + 4.0 * width * (2.0 * random.uniform() - 1.0), -1.0, 1.0);
  }
  const Eigen::MatrixXd along_x = samara::pgd::interpolation_matrix(axes[0], points.row(0).transpose());
  const Eigen::MatrixXd along_y = samara::pgd::interpolation_matrix(axes[1], points.row(1).transpose());
  double worst = 0.0;
  for (int j = 0; j < kPoints; ++j) {
    worst = std::max(worst, std::abs(along_x.row(j) * at_nodes * along_y.row(j).transpose() -
                                     front_at(points(0, j), points(1, j), width)));
  }
  return worst;
}

}  // namespace

TEST_CASE("where polynomials follow all lines the grid has no elements, and none are halved") {
  FrontGrid of(0.3);
  CHECK_FALSE(of.grid.has_elements());
  CHECK_FALSE(of.grid.front());
  CHECK_FALSE(of.grid.are_polynomials_used_up(SteppedGrid::kFirstShare));
  const std::vector<int> nodes = of.grid.nodes_within(SteppedGrid::kFirstShare);
  of.grid.halve_elements(1e-6);
  CHECK(of.grid.nodes_within(SteppedGrid::kFirstShare) == nodes);
  CHECK(error_about(of.grid.axes(nodes), 0.3) <= kRelative);
}

TEST_CASE("a front through two coordinates is followed by elements of both") {
  constexpr double kWidth = 0.015;
  FrontGrid of(kWidth);
  CHECK_FALSE(of.grid.front());
  const std::vector<samara::pgd::Axis> axes = of.grid.axes(of.grid.nodes_within(SteppedGrid::kFirstShare));
  for (const samara::pgd::Axis& axis : axes) CHECK(axis.elements() > 2);
  CHECK(error_about(axes, kWidth) <= kRelative);
}

TEST_CASE("elements that are halved in one go are those that are halved share by share between other draws") {
  FrontGrid at_once(0.02), in_steps(0.02);
  const std::vector<int> before = at_once.grid.nodes_within(SteppedGrid::kFirstShare);
  const samara::pgd::Axis axis = at_once.grid.axes(before)[0];
  const double first = SteppedGrid::kFirstShare * SteppedGrid::kTighter;
  const double second = first * SteppedGrid::kTighter;
  at_once.grid.halve_elements(second);
  in_steps.grid.halve_elements(first);
  in_steps.grid.points_near_fronts(100, in_steps.random);
  in_steps.grid.halve_elements(second);
  const std::vector<int> nodes = at_once.grid.nodes_within(second);
  CHECK(nodes[0] > before[0]);
  CHECK_FALSE(at_once.grid.are_same_elements(nodes, before));
  REQUIRE(in_steps.grid.nodes_within(second) == nodes);
  for (std::size_t k = 0; k < nodes.size(); ++k)
    CHECK(in_steps.grid.axes(nodes)[k].borders() == at_once.grid.axes(nodes)[k].borders());
  // Those of before are still there: the best field may lie on them.
  CHECK(at_once.grid.axes(before)[0].borders() == axis.borders());
}

TEST_CASE("where elements would be too many the grid is of polynomials, and tells of the front") {
  FrontGrid of(0.02, "max_nodes = 40\n");
  CHECK_FALSE(of.grid.has_elements());
  CHECK(of.grid.nodes_within(SteppedGrid::kFirstShare) == std::vector<int>{40, 40});
  CHECK(of.grid.are_polynomials_used_up(SteppedGrid::kFirstShare));
  REQUIRE(of.grid.front());
  const Eigen::VectorXd& point = of.grid.front()->point;
  CHECK(std::abs(point[0] - 0.5 * point[1]) <= 0.02);
}
