#include <cmath>
#include <map>
#include <numbers>

#include <catch2/catch.hpp>

#include "samara/base/names.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/composition/mixed_trajectories.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/check_family.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "sample_books.h"

using namespace samara::codebooks;
using samara::models::Derivatives;
using samara::models::TrajectoryStatus;

namespace {

const Codebook& window() {
  static const Codebook book =
      build(parse_plan("model = 'vertical_fall'\n"
                       "[fixed]\ndensity = 6339\narea = 4.714e-4\nthickness = '2.55 mm'\n"
                       "[box]\nC_D = [0.8, 1.6]\n'v(0)' = [0.0, 1.0]\n"
                       "[time]\nend = 0.05\n[tolerance]\nrelative = 1e-5\n",
                       "plan.toml"),
            {.certificate_points = 50})
          .book;
  return book;
}

/// Wider than the codebook's box: some points are its own, others the family's.
std::unique_ptr<samara::models::TrajectoryFamily> wider() {
  return samara::models::step_trajectories(samara::models::find_model("vertical_fall"),
                                           {{"density", 6339.0}, {"area", 4.714e-4}, {"thickness", 2.55e-3}},
                                           {{"C_D", {0.6, 1.6}}, {"v(0)", {0.0, 1.2}}, {"x(0)", {-1.0, 1.0}}},
                                           1e-3);
}

void check_passes(const samara::models::TrajectoryFamily& family, const std::vector<double>& times = {}) {
  const samara::Check check = check_family(family, {.points = 8, .times = times});
  INFO(samara::join(check.findings));
  CHECK(check.passed());
}

}  // namespace

TEST_CASE("every family of a codebook keeps the laws of families") {
  check_passes(*codebook_trajectories(window()));
  check_passes(*codebook_trajectories(coin_build().book));
  check_passes(*reference_trajectories(window()));
  check_passes(*flow_map_trajectories(window()), {0.0, 0.03, 0.05, 0.12, 0.2});
  check_passes(*mixed_trajectories(window(), wider()), {0.0, 0.01, 0.03, 0.05});
  check_passes(*mixed_trajectories(window(), wider()), {0.0, 0.03, 0.3});
}

TEST_CASE("codebook, flow map and reference are one motion where all answer") {
  const std::vector<double> times = {0.0, 0.02, 0.05};
  const std::vector<double> q = {1.2, 0.4};
  const auto reference = reference_trajectories(window());
  const auto truth = trajectory(*reference, q, times, {"v", "x"}, Derivatives::yes);
  for (const auto& family : {codebook_trajectories(window()), flow_map_trajectories(window())}) {
    const auto one = trajectory(*family, q, times, {"v", "x"}, Derivatives::yes);
    REQUIRE(one.outcome);
    // The codebook is to 1e-5 of the range, which is about 1 m/s for v.
    CHECK((one.values - truth.values).cwiseAbs().maxCoeff() < 1e-5);
    CHECK((one.derivatives - truth.derivatives).cwiseAbs().maxCoeff() < 1e-3);
  }
}

TEST_CASE("a flow map goes on after the end of the codebook, and says where it leaves the box") {
  const auto reference = reference_trajectories(window());
  const auto flow_map = flow_map_trajectories(window());
  CHECK(std::isinf(flow_map->info().end_time));
  const std::vector<double> times = {0.1, 0.3};
  const std::vector<double> q = {1.2, 0.4};
  const auto one = trajectory(*flow_map, q, times, {"x"});
  REQUIRE(one.outcome);
  CHECK((one.values - trajectory(*reference, q, times, {"x"}).values).cwiseAbs().maxCoeff() < 1e-4);

  const auto out = trajectory(*flow_map, std::vector{1.2, 1.5}, times, {"x"});
  CHECK(out.outcome.status == TrajectoryStatus::outside_box);
  CHECK_THAT(out.outcome.message, Catch::Contains("left the box at t = 0: v = 1.5"));
  CHECK(std::isnan(out.values(0, 0)));
}

TEST_CASE("a codebook and a family shift a motion from where the model starts it") {
  const Plan plan = parse_plan(
      "[equations]\nname = 'drift'\nstates.x = { initial = 3 }\nstates.v = { initial = 0 }\n"
      "parameters.pull = {}\nrates.x = 'v'\nrates.v = 'pull - v'\n"
      "[box]\npull = [0.5, 1.5]\n[time]\nend = 1\n",
      "plan.toml");
  const Codebook book = build(plan, {.certificate_points = 10}).book;
  const auto mixed = mixed_trajectories(
      book, reference_trajectories(plan.definition, {{"x(0)", 5.0}}, {{"pull", {0.4, 1.6}}}));
  const auto one = trajectory(*mixed, std::vector{1.0}, {0.0, 1.0}, {"x"});
  REQUIRE(one.outcome);
  CHECK(one.values(0, 0) == Approx(5.0).margin(1e-3));
  CHECK(one.values(1, 0) == Approx(5.0 + std::exp(-1.0)).margin(2e-3));
}

TEST_CASE("what a codebook leaves to its model's defaults, the family beside it holds there, too") {
  using samara::models::Interval;
  const Codebook book = build(parse_plan("model = 'vertical_fall'\n"
                                         "[fixed]\ndensity = 6339\narea = 4.714e-4\nthickness = '2.55 mm'\n"
                                         "[box]\nC_D = [0.8, 1.6]\n[time]\nend = 0.05\n",
                                         "plan.toml"),
                              {.certificate_points = 10})
                            .book;
  const auto mixed = [&](const std::map<std::string, double>& held,
                         const std::map<std::string, Interval>& free) {
    std::map<std::string, double> fixed = {{"density", 6339.0}, {"area", 4.714e-4}, {"thickness", 2.55e-3}};
    fixed.insert(held.begin(), held.end());
    std::map<std::string, Interval> box = {{"C_D", {0.6, 1.6}}};
    box.insert(free.begin(), free.end());
    return mixed_trajectories(
        book, step_trajectories(samara::models::find_model("vertical_fall"), fixed, box, 1e-3));
  };
  using Catch::Contains;
  CHECK_THROWS_WITH(mixed({}, {{"v(0)", {0.0, 1.0}}}), Contains("\"v(0)\" is free in the Runge-Kutta steps"));
  CHECK_THROWS_WITH(mixed({{"fluid_density", 1025.0}}, {}),
                    Contains("holds \"fluid_density\" at 1025; 998.2 was expected"));
  CHECK_THROWS_WITH(mixed({{"v(0)", 0.1}}, {}), Contains("holds \"v(0)\" at 0.1; 0 was expected"));
  CHECK_THROWS_WITH(mixed({{"m_a", 0.01}}, {}), Contains("holds \"m_a\" at 0.01"));
  const double disc = 8.0 / 3.0 * 998.2 * std::pow(4.714e-4 / std::numbers::pi, 1.5);
  CHECK_NOTHROW(mixed({{"fluid_density", 998.2}, {"m_a", disc}, {"v(0)", 0.0}, {"x(0)", 3.0}}, {}));
  CHECK_NOTHROW(mixed({}, {{"x(0)", {-1.0, 1.0}}}));
  // Without a drag at small Reynolds numbers no motion depends on the viscosity.
  CHECK_NOTHROW(mixed({{"nu", 1.19e-6}}, {}));
  CHECK_NOTHROW(mixed({}, {{"nu", {1e-6, 2e-6}}}));
  CHECK_THROWS_WITH(mixed({{"Re_drag", 20.0}}, {}), Contains("holds \"Re_drag\" at 20; 0 was expected"));
}

TEST_CASE("in a gap between the pieces of a codebook the family answers") {
  const Codebook book(sample_model(),
                      {random_piece({0.0, 0.5, 0.5, 1.0}, 1), random_piece({0.0, 0.5, 1.2, 2.0}, 2)});
  std::map<std::string, double> fixed = sample_model().fixed;
  fixed["area"] = 4.714e-4;
  fixed["thickness"] = 2.55e-3;
  const auto direct = [&] {
    return step_trajectories(samara::models::find_model("vertical_fall"), fixed,
                             {{"C_D", {0.5, 2.0}}, {"v(0)", {-0.3, 0.6}}}, 1e-3);
  };
  const std::vector<double> q = {1.1, 0.2}, times = {0.1, 0.4};
  const auto one = trajectory(*mixed_trajectories(book, direct()), q, times, {"v"});
  REQUIRE(one.outcome);
  CHECK(one.values == trajectory(*direct(), q, times, {"v"}).values);
}
