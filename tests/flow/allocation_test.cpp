#include <catch2/catch.hpp>
#include <tbb/task_arena.h>

#include "../allocation_counter.h"
#include "flow_cases.h"

using namespace samara::flow;
using namespace flow_cases;

TEST_CASE("a step of a flow does not allocate") {
  // With several threads the scheduler has its own memory, which grows now and then.
  tbb::task_arena(1).execute([] {
    FlowMarch march({.grid = MacGrid(2, {120, 80, 1}, 0.0625, Eigen::Vector3d::Zero()),
                     .borders = stream(),
                     .body = PlacedShape(rectangle_section(1.0, 0.3), {2.1, 2.4, 0.0}, 0.6),
                     .viscosity = 5e-5,
                     .turbulence = TurbulenceModel::k_epsilon});
    march.set_velocity([](const Eigen::Vector3d&) { return Eigen::Vector3d(1.0, 0.0, 0.0); });
    march.set_turbulence(6e-4, 3.4e-5);
    for (int s = 0; s < 3; ++s) march.advance();
    Eigen::Vector3d force;
    CHECK(allocation_counter::during([&] {
            for (int s = 0; s < 5; ++s) march.advance();
            force = march.loads().force;
          }) == 0);
    CHECK(force.x() > 0.0);
    CHECK(allocation_counter::during([&] { Eigen::VectorXd::Ones(1000).eval(); }) > 0);
  });
}
