#include "samara/models/batch/rk4_frames.h"

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/batch/batch.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"

using namespace samara::models;

namespace {

/// A card in air whose whole state and coefficients are free: 18 directions, more than one pass carries.
ParametricModel free_card() {
  std::vector<std::string> free = {"C_D0", "C_D90", "C_T", "C_R", "C_w"};
  const auto model = find_model("immersed_body");
  for (const StateInfo& state : model->info().states) free.push_back(state.name + "(0)");
  return {model, {{"a", 0.035}, {"b", 0.02}, {"c", 1e-4}, {"density", 1200.0}}, free};
}

std::vector<double> card_point() {
  return {0.05, 0.61, 1.81, 1.21, 2.0, 0.1, -0.2, 0.3, 0.9, 0.3, -0.2, 0.1, 0.4, -0.2, -0.9, 3.0, -5.0, 2.0};
}

std::vector<int> all_of(int count) {
  std::vector<int> indices;
  for (int i = 0; i < count; ++i) indices.push_back(i);
  return indices;
}

}  // namespace

TEST_CASE("frames agree with the reference integrator in values and in all derivatives") {
  const ParametricModel model = free_card();
  const std::vector<double> q = card_point();
  const std::vector<double> times = {0.0, 0.0125, 0.025, 0.06};
  Rk4Frames frames(model, times, {.step = 1e-4, .states = all_of(13), .directions = all_of(18)});
  Eigen::MatrixXd values(4, 13), derivatives(4, 13 * 18), alone(4, 13);
  REQUIRE(frames(q, values, &derivatives));
  REQUIRE(frames(q, alone, nullptr));
  CHECK((values - alone).cwiseAbs().maxCoeff() < 1e-11);

  const Trajectory exact = integrate(model, q, times, {}, true);
  REQUIRE(exact.is_usable());
  CHECK((values - exact.states).cwiseAbs().maxCoeff() < 1e-6);
  for (std::size_t d = 0; d < 18; ++d) {
    const Eigen::MatrixXd block = derivatives.middleCols(static_cast<Eigen::Index>(13 * d), 13);
    const double size = exact.sensitivities[d].cwiseAbs().maxCoeff();
    INFO("derivative by " << model.free()[d].name);
    CHECK((block - exact.sensitivities[d]).cwiseAbs().maxCoeff() < 1e-5 * size);
  }
}

TEST_CASE("frames hold the states and directions that were asked for, in their order") {
  const ParametricModel model = free_card();
  const std::vector<double> q = card_point();
  const std::vector<double> times = {0.02, 0.04};
  Rk4Frames all(model, times, {.states = all_of(13), .directions = all_of(18)});
  Rk4Frames some(model, times, {.states = {12, 2}, .directions = {17, 3}});
  Eigen::MatrixXd values(2, 13), derivatives(2, 13 * 18), few(2, 2), few_derivatives(2, 4);
  REQUIRE(all(q, values, &derivatives));
  REQUIRE(some(q, few, &few_derivatives));
  CHECK((few.col(0) - values.col(12)).norm() < 1e-11);
  CHECK((few.col(1) - values.col(2)).norm() < 1e-11);
  CHECK((few_derivatives.col(1) - derivatives.col(2 + 13 * 17)).norm() <
        1e-9 * few_derivatives.col(1).norm());
  CHECK((few_derivatives.col(2) - derivatives.col(12 + 13 * 3)).norm() <
        1e-9 * few_derivatives.col(2).norm());
}

TEST_CASE("frames say that a trajectory ceases to exist") {
  // From (0, 1, 1) the coupled triple is infinite at t = 0.953.
  const ParametricModel model(find_model("coupled_triple"), {}, {"u1(0)", "u2(0)", "u3(0)"});
  Rk4Frames frames(model, std::vector{0.5, 3.0}, {.states = {0}, .directions = {0}});
  Eigen::MatrixXd values(2, 1), derivatives(2, 1);
  const std::vector<double> q = {0.0, 1.0, 1.0};
  CHECK_FALSE(frames(q, values, &derivatives));
  CHECK_FALSE(frames(q, values, nullptr));
}

TEST_CASE("frames refuse indices that are none and times that decrease") {
  const ParametricModel model = free_card();
  const auto make = [&](std::vector<double> times, Rk4Frames::Options options) {
    return Rk4Frames(model, times, std::move(options));
  };
  CHECK_THROWS_AS(make({0.1}, {.states = {13}, .directions = {}}), samara::ArgumentError);
  CHECK_THROWS_AS(make({0.1}, {.states = {0}, .directions = {-1}}), samara::ArgumentError);
  CHECK_THROWS_AS(make({0.1, 0.05}, {.states = {0}, .directions = {0}}), samara::ArgumentError);
}
