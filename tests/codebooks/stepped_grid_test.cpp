#include "samara/codebooks/build/stepped_grid.h"

#include <algorithm>
#include <cmath>
#include <functional>
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

/// Over [-1, 1] x [-1, 1], chosen for tanh((x - y/2)/width): with n nodes errors along x fall like
/// exp(-n pi width / 2), along y twice as fast. Or for another value.
struct FrontGrid {
  explicit FrontGrid(double width, const std::string& builder = "")
      : FrontGrid([width](double x, double y) { return front_at(x, y, width); }, builder) {}

  explicit FrontGrid(const std::function<double(double x, double y)>& value, const std::string& builder = "")
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
        grid(plan, labels, trajectories, [value](const Eigen::MatrixXd& points) {
          Eigen::MatrixXd values(1, points.cols());
          for (Eigen::Index j = 0; j < points.cols(); ++j) values(0, j) = value(points(0, j), points(1, j));
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
double error_about(const SteppedGrid& grid, double width) {
  const std::vector<samara::pgd::Axis> axes = grid.axes(grid.nodes_within(SteppedGrid::kFirstShare));
  const auto value = [&](double x, double y) {
    const Eigen::MatrixXd point = grid.in_box(Eigen::Vector2d(x, y));
    return front_at(point(0, 0), point(1, 0), width);
  };
  const Eigen::VectorXd& x = axes[0].nodes();
  const Eigen::VectorXd& y = axes[1].nodes();
  Eigen::MatrixXd at_nodes(x.size(), y.size());
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    for (Eigen::Index j = 0; j < y.size(); ++j) at_nodes(i, j) = value(x[i], y[j]);
  }
  constexpr int kPoints = 500;
  samara::pgd::Random random(17);
  Eigen::MatrixXd points(2, kPoints);
  for (int j = 0; j < kPoints; ++j) {
    points(1, j) = 2.0 * random.uniform() - 1.0;
    const double front = grid.counted_from() != nullptr ? 0.0 : 0.5 * points(1, j);
    points(0, j) = std::clamp(front + 4.0 * width * (2.0 * random.uniform() - 1.0), -1.0, 1.0);
  }
  const Eigen::MatrixXd along_x = samara::pgd::interpolation_matrix(axes[0], points.row(0).transpose());
  const Eigen::MatrixXd along_y = samara::pgd::interpolation_matrix(axes[1], points.row(1).transpose());
  double worst = 0.0;
  for (int j = 0; j < kPoints; ++j) {
    worst = std::max(worst, std::abs(along_x.row(j) * at_nodes * along_y.row(j).transpose() -
                                     value(points(0, j), points(1, j))));
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
  CHECK(error_about(of.grid, 0.3) <= kRelative);
  CHECK_FALSE(of.grid.counted_from());
}

TEST_CASE("a front through two coordinates is followed by elements of both") {
  constexpr double kWidth = 0.015;
  FrontGrid of(kWidth);
  CHECK_FALSE(of.grid.front());
  CHECK_FALSE(of.grid.counted_from());
  const std::vector<samara::pgd::Axis> axes = of.grid.axes(of.grid.nodes_within(SteppedGrid::kFirstShare));
  for (const samara::pgd::Axis& axis : axes) CHECK(axis.elements() > 2);
  CHECK(error_about(of.grid, kWidth) <= kRelative);
}

TEST_CASE("a front too narrow for elements that move with it is counted from, with few nodes") {
  constexpr double kWidth = 0.002;
  FrontGrid of(kWidth);
  CHECK_FALSE(of.grid.front());
  REQUIRE(of.grid.counted_from());
  CHECK(of.grid.counted_from()->coordinate() == 0);
  const Eigen::Vector2d point(0.9, 0.6);
  CHECK(std::abs(of.grid.counted_from()->front_at(point.data()) - 0.3) <= 0.2 * kWidth);
  const std::vector<int> nodes = of.grid.nodes_within(SteppedGrid::kFirstShare);
  CHECK(nodes[0] <= 250);
  CHECK(nodes[1] > 3);
  CHECK(nodes[1] <= 20);
  CHECK(error_about(of.grid, kWidth) <= kRelative);
}

TEST_CASE("where elements do not follow beside a front that is counted from, nothing is, as before") {
  constexpr double kWidth = 0.002;
  // Another front the other way; and one with an edge.
  FrontGrid two([](double x, double y) { return front_at(x, y, kWidth) + 0.6 * front_at(x, -y, kWidth); });
  FrontGrid edge([](double x, double y) { return front_at(x, std::abs(y), kWidth); });
  for (const FrontGrid* of : {&two, &edge}) {
    CHECK_FALSE(of->grid.counted_from());
    CHECK_FALSE(of->grid.has_elements());
    CHECK(of->grid.front());
    CHECK(of->grid.in_box(Eigen::Vector2d(0.3, 0.4)) == Eigen::Vector2d(0.3, 0.4));
  }
}

TEST_CASE("points that states and times are chosen by lie in corners, inside and about fronts") {
  constexpr double kWidth = 0.002;
  constexpr int kCount = 400;
  FrontGrid counted(kWidth), without(0.3);
  const auto in_corners = [](const Eigen::MatrixXd& points) {
    return (points.cwiseAbs().colwise().minCoeff().array() == 1.0).count();
  };
  CHECK(in_corners(without.grid.mixed_points(kCount, without.random)) == kCount / 2);
  const Eigen::MatrixXd points = counted.grid.mixed_points(kCount, counted.random);
  CHECK(in_corners(points) == kCount / 4);
  CHECK((points.row(0).cwiseAbs().array() <= 10.0 * kWidth).count() >= kCount / 8);
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
