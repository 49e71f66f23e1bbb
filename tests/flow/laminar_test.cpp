#include <cmath>
#include <string>

#include <catch2/catch.hpp>

#include "flow_cases.h"

using namespace samara::flow;
using namespace flow_cases;

TEST_CASE("Taylor and Green's vortices converge at second order, pressure included", "[flow]") {
  const TaylorGreenErrors coarse = taylor_green_errors(32, 0.0), fine = taylor_green_errors(64, 0.0);
  INFO("errors of u " << coarse.u << ", " << fine.u << "; of p " << coarse.p << ", " << fine.p);
  CHECK(std::log2(coarse.u / fine.u) > 1.9);
  CHECK(std::log2(coarse.p / fine.p) > 1.7);
  CHECK(fine.u < 2e-3);
  CHECK(fine.divergence < 1e-8);
}

TEST_CASE(
    "vortices carried by a stream converge at second order, with seven times the error of those at rest",
    "[flow]") {
  const TaylorGreenErrors coarse = taylor_green_errors(32, 0.5), fine = taylor_green_errors(64, 0.5);
  INFO("errors of u " << coarse.u << ", " << fine.u);
  CHECK(std::log2(coarse.u / fine.u) == Approx(2.0).margin(0.1));
  // At rest the vortices' own advection is balanced by the pressure on the grid as well.
  CHECK(fine.u < 8.0 * taylor_green_errors(64, 0.0).u);
}

TEST_CASE("the lid-driven cavity at Re 100 has the published extrema", "[flow]") {
  // Marchi, Suero, Araki, J. Braz. Soc. Mech. Sci. Eng. 31 (2009) 186, extrapolated from grids of up to 1024^2.
  const CavityExtrema published{-0.2140424, 0.1795728, -0.2538030};
  const CavityExtrema coarse = cavity_extrema(32, 100.0, 1e-5), fine = cavity_extrema(64, 100.0, 1e-5);
  INFO("u_min " << coarse.u_min << ", " << fine.u_min << "; v_max " << coarse.v_max << ", " << fine.v_max
                << "; v_min " << coarse.v_min << ", " << fine.v_min);
  // Second order: 0.3 % at 128 cells are 1.2 % at 64.
  CHECK(std::abs(fine.u_min / published.u_min - 1.0) < 0.012);
  CHECK(std::abs(fine.v_max / published.v_max - 1.0) < 0.012);
  CHECK(std::abs(fine.v_min / published.v_min - 1.0) < 0.012);
  CHECK(std::log2((coarse.v_min - published.v_min) / (fine.v_min - published.v_min)) > 1.8);
  CHECK(std::log2((coarse.u_min - published.u_min) / (fine.u_min - published.u_min)) > 1.8);
}

TEST_CASE("a flow in space that does not change along z is the flow in the plane", "[flow]") {
  const auto run = [](int dimensions) {
    Borders borders;
    for (int side = 0; side < 4; ++side) borders.side[static_cast<std::size_t>(side)].kind = BorderKind::wall;
    borders.side[3].velocity = {1.0, 0.0, 0.0};
    borders.side[4].kind = borders.side[5].kind = BorderKind::periodic;
    const int n = 16;
    FlowMarch march({.grid = MacGrid(dimensions, {n, n, 4}, 1.0 / n, Eigen::Vector3d::Zero()),
                     .borders = borders,
                     .viscosity = 0.01,
                     .divergence = 1e-12});
    march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(0.0, 0.0, 0.0); });
    for (int s = 0; s < 30; ++s) march.advance(0.02);
    Eigen::MatrixXd middle(n, n);
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i)
        middle(i, j) =
            march.state().u[0][static_cast<std::size_t>(march.grid().at(i, j, dimensions == 3 ? 2 : 0))];
    }
    return middle;
  };
  const Eigen::MatrixXd plane = run(2), space = run(3);
  CHECK(plane.cwiseAbs().maxCoeff() > 0.3);
  CHECK((plane - space).cwiseAbs().maxCoeff() < 1e-10);
}

TEST_CASE("what is no number does not enter a march, nor pass for no divergence", "[flow]") {
  const double nan = std::nan("");
  const auto setup = [] {
    return FlowSetup{.grid = MacGrid(2, {16, 16, 1}, 0.1, Eigen::Vector3d::Zero()),
                     .borders = stream(),
                     .viscosity = 0.01};
  };
  const auto refused = [&](const auto& change, const std::string& sentence) {
    FlowSetup changed = setup();
    change(changed);
    CHECK_THROWS_WITH(FlowMarch(changed), Catch::Contains(sentence));
  };
  refused([&](FlowSetup& s) { s.body_force.y() = nan; }, "body_force is not finite");
  refused(
      [&](FlowSetup& s) {
        s.grid.cells[1] = 1;
        s.borders.side[2].kind = s.borders.side[3].kind = BorderKind::periodic;
      },
      "cells is 1; at least 2 along a periodic direction");
  refused([&](FlowSetup& s) { s.largest_eddy_viscosity = nan; }, "largest_eddy_viscosity is nan");
  refused([&](FlowSetup& s) { s.borders.side[0].k = nan; },
          "k and epsilon at the border x low are nan and 0");
  refused([&](FlowSetup& s) { s.borders.side[0].k = 0.01; },
          "k and epsilon at the border x low are 0.01 and 0");

  FlowMarch march(setup());
  CHECK_THROWS_WITH(march.set_velocity([&](const Eigen::Vector3d& x) {
    return Eigen::Vector3d(x.x() > 0.8 ? nan : 1.0, 0.0, 0.0);
  }),
                    Catch::Contains("the velocity is nan at (0.9, 0.05, 0), expected a number"));
  FlowSetup profiled = setup();
  profiled.borders.side[0].profile = [&](const Eigen::Vector3d& x) { return x.y() > 0.8 ? nan : 1.0; };
  FlowMarch blown(profiled);
  const auto uniform = [](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, 0.0, 0.0); };
  CHECK_THROWS_WITH(blown.set_velocity(uniform),
                    Catch::Contains("the profile of the inflow at x low is nan"));

  march.set_velocity(uniform);
  CHECK(march.divergence() < 1e-12);
  march.state().u[1][static_cast<std::size_t>(march.grid().at(5, 5))] = nan;
  CHECK_FALSE(std::isfinite(march.divergence()));
}
