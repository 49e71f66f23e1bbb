#include "samara/codebooks/build/time_mesh.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"

using namespace samara::codebooks;

namespace {

const samara::pgd::Axis::Label kTimeAxis = {"t", "s", samara::pgd::AxisRole::time};

/// Fast decays exp(-rate t) and slow waves, one trajectory per rate.
PilotTrajectories decays(const std::vector<double>& rates) {
  return [rates](const std::vector<double>& times) {
    std::vector<Eigen::MatrixXd> states;
    for (const double rate : rates) {
      Eigen::MatrixXd table(static_cast<Eigen::Index>(times.size()), 2);
      for (Eigen::Index i = 0; i < table.rows(); ++i) {
        const double t = times[static_cast<std::size_t>(i)];
        table.row(i) << std::exp(-rate * t), 100.0 * std::sin(t);
      }
      states.push_back(std::move(table));
    }
    return states;
  };
}

}  // namespace

TEST_CASE("a mesh of time follows all pilots between its nodes, with short elements where they are fast") {
  const PilotTrajectories pilots = decays({1.0, 300.0});
  const double tolerance = 1e-6;
  const TimeMesh mesh = *mesh_time(kTimeAxis, 4.0, pilots, {.tolerance = tolerance});
  CHECK(mesh.resolved);
  CHECK(mesh.error <= tolerance);
  CHECK(mesh.axis.lower() == 0.0);
  CHECK(mesh.axis.upper() == 4.0);
  const Eigen::VectorXd& borders = mesh.axis.borders();
  CHECK(borders[1] - borders[0] < 0.1 * (borders[borders.size() - 1] - borders[borders.size() - 2]));
  // At other times than the mesh was made with: a little more than the largest of those.
  std::vector<double> times;
  for (int i = 0; i <= 5000; ++i) times.push_back(4.0 * i / 5000);
  const std::vector<double> nodes(mesh.axis.nodes().begin(), mesh.axis.nodes().end());
  const auto at_nodes = *pilots(nodes), exact = *pilots(times);
  samara::pgd::InterpolationStencil stencil = mesh.axis.make_stencil();
  double worst = 0.0;
  for (std::size_t j = 0; j < exact.size(); ++j) {
    for (std::size_t i = 0; i < times.size(); ++i) {
      mesh.axis.interpolate(times[i], stencil, false);
      const Eigen::RowVectorXd value =
          stencil.value.transpose() * at_nodes[j].middleRows(stencil.first, stencil.value.size());
      const Eigen::RowVectorXd error = value - exact[j].row(static_cast<Eigen::Index>(i));
      worst = std::max(worst, error.cwiseAbs().cwiseQuotient(mesh.scale.transpose()).maxCoeff());
    }
  }
  CHECK(worst <= 1.5 * tolerance);
}

TEST_CASE("errors on a mesh of time count by the range, and by the floor where that is larger") {
  const PilotTrajectories pilots = decays({50.0});
  const TimeMesh fine = *mesh_time(kTimeAxis, 1.0, pilots, {.tolerance = 1e-6});
  const TimeMesh coarse = *mesh_time(kTimeAxis, 1.0, pilots,
                                     {.tolerance = 1e-6, .measure = {.floors = Eigen::Vector2d(1e4, 0.0)}});
  CHECK(coarse.axis.elements() < fine.axis.elements());
  CHECK(coarse.scale[0] == 1e4);
  CHECK(std::abs(fine.scale[0] - 1.0) < 1e-12);
}

TEST_CASE("a mesh of time that may have few elements says what error is left") {
  const TimeMesh mesh = *mesh_time(kTimeAxis, 1.0, decays({1e7}), {.tolerance = 1e-8, .max_elements = 12});
  CHECK_FALSE(mesh.resolved);
  CHECK(mesh.error > 1e-8);
  CHECK(mesh.axis.borders()[0] == 0.0);
  CHECK(mesh.axis.upper() == 1.0);
}

TEST_CASE("trajectories that rest need two elements") {
  const TimeMesh mesh = *mesh_time(kTimeAxis, 1.0,
                                   [](const std::vector<double>& times) {
                                     return std::vector<Eigen::MatrixXd>{Eigen::MatrixXd::Constant(
                                         static_cast<Eigen::Index>(times.size()), 1, 0.3)};
                                   },
                                   {});
  CHECK(mesh.resolved);
  CHECK(mesh.axis.elements() == 2);
  CHECK(mesh.passes == 1);
}

TEST_CASE("pilots without trajectories end a mesh of time with their reason") {
  const PilotTrajectories none = [](const std::vector<double>&) {
    return samara::Ending{samara::Termination::max_calls, "all calls are used up"};
  };
  const auto mesh = mesh_time(kTimeAxis, 1.0, none, {});
  REQUIRE_FALSE(mesh);
  CHECK(mesh.ending().status == samara::Termination::max_calls);
  CHECK(mesh.ending().message == "all calls are used up");
}

TEST_CASE("a mesh of time without time or tolerance is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  using Catch::Matchers::Contains;
  CHECK_THROWS_WITH(mesh_time(kTimeAxis, 0.0, decays({1.0}), {}), Contains("end of time [s] is 0"));
  CHECK_THROWS_WITH(mesh_time(kTimeAxis, nan, decays({1.0}), {}), Contains("end of time [s] is nan"));
  CHECK_THROWS_WITH(mesh_time(kTimeAxis, 1.0, decays({1.0}), {.tolerance = 0.0}), Contains("tolerance is 0"));
  CHECK_THROWS_WITH(mesh_time(kTimeAxis, 1.0, decays({1.0}), {.degree = 1}), Contains("degree is 1"));
  CHECK_THROWS_WITH(mesh_time(kTimeAxis, 1.0, decays({1.0}), {.max_elements = 1}),
                    Contains("max_elements is 1"));
}
