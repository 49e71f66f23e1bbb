#include "samara/identification/forecasts/novelty.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"

using namespace samara::identification;

TEST_CASE("a motion is as new as it lies from those of the training, whichever way it goes") {
  const Components two_level{.level = {0, 1}};
  // Straight ways of some speeds: places six times back lie 1 to 6 intervals' difference of speed apart.
  const auto straight = [](double along, double up, double heading) {
    SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(7, 0.0, 0.06), .positions = Eigen::MatrixXd(7, 3)};
    for (Eigen::Index k = 0; k < 7; ++k) {
      const double t = seen.times[k];
      seen.positions.row(k) << along * t * std::cos(heading), along * t * std::sin(heading), up * t;
    }
    return seen;
  };
  std::vector<TrainingMoment> moments;
  for (int k = 0; k < 10; ++k)
    moments.push_back({.cluster = k % 2, .seen = straight(k % 2 == 0 ? 1.0 : 2.0, -1.0, 0.7 * k)});
  const Novelty novelty = Novelty::fit(moments, two_level);
  const double apart = 0.01 * std::sqrt(1.0 + 4.0 + 9.0 + 16.0 + 25.0 + 36.0);  // of a unit of speed
  CHECK(novelty.at(straight(1.0, -1.0, 2.0)) == Approx(0.0).margin(1e-12));
  CHECK(novelty.without(0, straight(1.0, -1.0, 2.0)) == Approx(apart));
  CHECK(novelty.without(1, straight(1.0, 2.0, 0.3)) == Approx(3.0 * apart));
  CHECK(novelty.without(7, straight(1.0, -1.0, 2.0)) == Approx(0.0).margin(1e-12));
  // Turns of one hand know those of the other.
  const auto turning = [&](double hand) {
    SeenMotion seen = straight(1.0, -1.0, 0.0);
    seen.positions.col(1) = hand * seen.times.array().square();
    return seen;
  };
  std::vector<TrainingMoment> turns(5, {.cluster = 0, .seen = turning(20.0)});
  CHECK(Novelty::fit(turns, two_level).at(turning(-20.0)) == Approx(0.0).margin(1e-12));
  CHECK(Novelty::fit(turns, two_level).at(turning(0.0)) > 0.01);
  // One level component has two hands as well; none has one.
  for (const bool is_level : {true, false}) {
    std::vector<TrainingMoment> ways;
    for (int k = 0; k < 5; ++k) {
      ways.push_back({.cluster = 0, .seen = straight(1.0, -1.0, 0.0)});
      ways.back().seen.positions = ways.back().seen.positions.leftCols(1).eval();
    }
    SeenMotion back = ways.front().seen;
    back.positions *= -1.0;
    const Components components{.level = is_level ? std::vector{0} : std::vector<int>{}};
    CHECK(Novelty::fit(ways, components).at(back) ==
          (is_level ? Approx(0.0).margin(1e-12) : Approx(2.0 * apart)));
    CHECK_THROWS_AS(Novelty::fit(ways, components).at(turning(0.0)), samara::ArgumentError);
    CHECK_THROWS_AS(Novelty::fit(ways, {.level = {1}}), samara::ArgumentError);
  }
  // Too few moments, too few frames, too short a way, too many level components: unknown.
  CHECK(std::isnan(Novelty::fit(std::span(turns).first(4), two_level).at(turning(0.0))));
  SeenMotion brief = turning(0.0);
  brief.times = brief.times.head(5).eval();
  brief.positions = brief.positions.topRows(5).eval();
  CHECK(std::isnan(Novelty::fit(turns, two_level).at(brief)));
  CHECK(std::isnan(Novelty::fit(turns, {.level = {0, 1, 2}}).at(turning(0.0))));
  CHECK(std::isnan(Novelty().at(turning(0.0))));
}
