#include "samara/flow/files/flow_view.h"

#include <cmath>
#include <memory>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "flow_cases.h"
#include "samara/base/errors.h"
#include "samara/models/laws/registry.h"

using namespace samara::flow;

namespace {

/// A made-up flow: u = 1 + x/10 - y/5, v = -y/10 + x/4, (w = z/20), k = (2 + x/3)^2, epsilon = 3.
std::shared_ptr<const StoredFlow> made_up(int dimensions) {
  auto flow = std::make_shared<StoredFlow>(MacGrid(dimensions, {40, 30, 24}, 0.1, {-1.0, -1.5, -1.2}));
  const MacGrid& grid = flow->grid;
  flow->open = grid.field(1.0);
  for (const char* name : {"u", "v", "w", "k", "epsilon"}) flow->fields.push_back({name, "", grid.field()});
  for (int k = 0; k < grid.cells[2]; ++k) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i) {
        const Eigen::Vector3d x = grid.centre(i, j, k);
        const auto c = static_cast<std::size_t>(grid.at(i, j, k));
        flow->fields[0].values[c] = 1.0 + x.x() / 10 - x.y() / 5;
        flow->fields[1].values[c] = -x.y() / 10 + x.x() / 4;
        flow->fields[2].values[c] = x.z() / 20;
        flow->fields[3].values[c] = std::pow(2.0 + x.x() / 3, 2);
        flow->fields[4].values[c] = 3.0;
      }
    }
  }
  return flow;
}

}  // namespace

TEST_CASE("a flow in the world has its size and speed, its y upwards, and exact gradients", "[flow]") {
  const int dimensions = GENERATE(2, 3);
  const FlowPlacement placement{.speed = 3.0, .length = 0.5, .body = {10.0, -4.0, 2.0}};
  const FlowView view(made_up(dimensions), placement);
  // Flow place (0.73, 0.21, 0.34).
  const Eigen::Vector3d place(10.0 + 0.365, dimensions == 3 ? -4.0 - 0.17 : 7.0, 2.0 + 0.105);
  const samara::models::AmbientSample sample = view.sample(0.0, place);
  CHECK(sample.velocity.x() == Approx(3.0 * (1.0 + 0.073 - 0.042)));
  CHECK(sample.velocity.z() == Approx(3.0 * (-0.021 + 0.1825)));
  CHECK(sample.velocity.y() == Approx(dimensions == 3 ? -3.0 * 0.017 : 0.0));
  // Differences, also across the middle between two cells, where the spline changes.
  const double step = 1e-6;
  for (int j = 0; j < 3; ++j) {
    const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(j);
    const Eigen::Vector3d slope =
        (view.sample(0, place + d).velocity - view.sample(0, place - d).velocity) / (2 * step);
    CHECK((slope - sample.gradient.col(j)).norm() < 1e-8);
    const auto sigma = [&](const Eigen::Vector3d& x) {
      return std::sqrt(2.0 / 3.0 * view.turbulence(0.0, x).k);
    };
    CHECK((sigma(place + d) - sigma(place - d)) / (2 * step) ==
          Approx(view.turbulence(0.0, place).sigma_gradient(j)).margin(1e-7));
  }
  const samara::models::Turbulence energy = view.turbulence(0.0, place);
  CHECK(energy.k == Approx(9.0 * std::pow(2.0 + 0.73 / 3, 2)).epsilon(1e-3));
  CHECK(energy.epsilon == Approx(27.0 / 0.5 * 3.0));
  CHECK(energy.inside);
}

TEST_CASE("a motion that begins within the body of a flow is refused, and one beside it is not", "[flow]") {
  const int dimensions = GENERATE(2, 3);
  auto flow = std::make_shared<StoredFlow>(*made_up(dimensions));
  // The cells about the flow place (0.55, 0.25, 0.35). Of those that the surface cuts, most decides.
  const double share = GENERATE(0.0, 0.4, 0.6);
  flow->open[static_cast<std::size_t>(flow->grid.at(15, 17, dimensions == 3 ? 15 : 0))] = share;
  const FlowView view(flow, {.speed = 3.0, .length = 0.5, .body = {10.0, -4.0, 2.0}});
  const auto refusal = [&](double x) {
    const samara::models::ParametricModel body(samara::models::find_model("sphere_flight_in_gusts"),
                                               {{"x(0)", x}, {"y(0)", -4.175}, {"z(0)", 2.125}}, {});
    return error_text<samara::ArgumentError>([&] { check_release(view, body); });
  };
  CHECK_THAT(refusal(10.276),
             Catch::StartsWith(share < 0.5 ? "the motion begins at (10.276, -4.175, 2.125) m, "
                                             "within the body"
                                           : "no exception"));
  CHECK(refusal(10.324) == "no exception");
}

TEST_CASE("beyond its grid a flow is the stream, without energy", "[flow]") {
  const FlowView view(made_up(2), {.speed = 2.0, .length = 1.0});
  CHECK(view.sample(0.0, {50.0, 0.0, 0.0}).velocity == Eigen::Vector3d(2.0, 0.0, 0.0));
  CHECK_FALSE(view.turbulence(0.0, {0.0, 0.0, -1.48}).inside);
  CHECK(view.turbulence(0.0, {0.0, 0.0, -1.48}).k == 0.0);
  CHECK_FALSE(view.inside({NAN, 0.0, 0.0}));
  CHECK_THROWS_AS(FlowView(made_up(2), {.speed = -2.0}), samara::ArgumentError);
}

TEST_CASE("beyond its grid the stream goes on with its energy, where that is asked for", "[flow]") {
  const FlowPlacement placement{.speed = 2.0, .length = 0.5, .stream_beyond = true};
  CHECK_THROWS_WITH(FlowView(made_up(2), placement), Catch::Contains("does not say its intensity"));
  auto flow = std::make_shared<StoredFlow>(*made_up(2));
  flow->summary.intensity = 0.1;
  const FlowView view(flow, placement);
  const samara::models::Turbulence far = view.turbulence(0.0, {50.0, 0.0, 0.0});
  CHECK(far.inside);
  // u' is a tenth of the speed, and eddies are 7 % of the length.
  CHECK(far.k == Approx(1.5 * 0.2 * 0.2));
  CHECK(far.epsilon == Approx(std::pow(0.09, 0.75) * std::pow(far.k, 1.5) / (0.07 * 0.5)));
  CHECK(far.sigma_gradient.isZero(0.0));
  CHECK(view.sample(0.0, {50.0, 0.0, 0.0}).velocity == Eigen::Vector3d(2.0, 0.0, 0.0));
  CHECK_FALSE(view.inside({50.0, 0.0, 0.0}));
  // Within it nothing is changed.
  const FlowView ending(flow, {.speed = 2.0, .length = 0.5});
  CHECK(view.turbulence(0.0, {0.2, 0.0, 0.1}).k == ending.turbulence(0.0, {0.2, 0.0, 0.1}).k);
  CHECK_FALSE(ending.turbulence(0.0, {50.0, 0.0, 0.0}).inside);
}
