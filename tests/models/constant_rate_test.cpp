#include <catch2/catch.hpp>

#include "accuracy.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;

TEST_CASE("the constant rate gives the straight line of (6.18)") {
  const ParametricModel model(find_model("constant_rate"), {}, {"k", "u(0)"});
  const std::vector<double> times = {0.0, 0.5, 1.0, 3.0};
  for (const double k : {0.5, 2.0, 10.0, 40.0}) {
    const double u0 = 0.25;
    const Trajectory trajectory = integrate(model, std::vector<double>{k, u0}, times);
    REQUIRE(trajectory.is_usable());
    const double slope = 10.0 / k - 1.0;
    for (Eigen::Index row = 0; row < trajectory.times.size(); ++row) {
      const double t = trajectory.times[row];
      CHECK_THAT(
          trajectory.states(row, 0),
          Catch::Matchers::WithinAbs(u0 + slope * t, promised(trajectory, 1e-10, 1.0 + std::abs(slope) * t)));
    }
  }
}

TEST_CASE("the numerator of (6.18) can be set") {
  const ParametricModel model(find_model("constant_rate"), {{"k", 2.0}, {"rate", 6.0}}, {});
  ParametricModel::Workspace workspace = model.make_workspace();
  std::vector<double> dxdt(1);
  model.rhs(0.0, std::vector<double>{0.0}, {}, dxdt, workspace);
  CHECK(dxdt[0] == 2.0);
}
