/// What the search and its windows go by, and that an interrupted one goes on.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "plate_plans.h"
#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/motion/planning/fall_cost.h"
#include "samara/motion/planning/planner.h"
#include "samara/motion/planning/planning_state.h"
#include "samara/motion/planning/window_search.h"
#include "samara/motion/planning/windows.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;

TEST_CASE("lines by formula begin at the release and go down to the ground, by their own law") {
  const Eigen::Vector3d from(0.5, -0.25, 3.0);
  const samara::models::RosePath rose = {.descent_speed = 0.5,
                                         .amplitude_x = 0.2,
                                         .amplitude_y = 0.2,
                                         .modulation = 0.0,
                                         .lobes = 4.0,
                                         .angular_frequency = 4.0};
  const Sketch spiral = sketch_of(rose, from, 0.0);
  CHECK(spiral.points().row(0) == from.transpose());
  CHECK(spiral.bottom() <= 0.0);
  CHECK(spiral.bottom() > -0.05);
  CHECK_FALSE(spiral.is_timed());
  // A circle about a centre that lies an amplitude beside the release.
  for (const auto& point : spiral.points().rowwise())
    CHECK(std::hypot(point.x() - 0.3, point.y() + 0.25) == Approx(0.2));
  // A period goes down by 2 pi U/W.
  CHECK(spiral.points()(64, 2) == Approx(3.0 - 0.25 * 3.14159265358979));
  const samara::models::SideToSidePath rising = {
      .descent_speed = 0.1, .horizontal_speed = 0.5, .vertical_speed = 0.3, .angular_frequency = 5.0};
  CHECK_THROWS_WITH(sketch_of(rising, from, 0.0), Catch::Contains("goes down"));
  CHECK_THROWS_WITH(sketch_of(samara::models::RosePath{.descent_speed = 1e-9}, from, 0.0),
                    Catch::Contains("more than 100000 points"));
}

TEST_CASE("search and windows ask one cost, and refining never loses the landing") {
  MotionPlan plan = sequence_plan(30.0);
  plan.sketch = slanted_sketch(30.0);
  plan.landing = Eigen::Vector3d(12.0, 0.0, 0.0);
  for (const double turbulence : {0.0, 0.5}) {
    plan.turbulence = turbulence;
    const PlannedFall fall(plan);
    BeamState state = BeamState::from(fall.release());
    const FoundFall found = search_beam(fall, state, {}).falls.front();
    // The same fall by itself, step by step: every part of the cost.
    const ReplayedFall alone = replay(fall, fall.release(), found.knots);
    const FallCost searched = cost_of(fall, found.end), replayed = cost_of(fall, alone.end);
    CHECK(std::abs(searched.path - replayed.path) < 1e-9 * replayed.path);
    CHECK(std::abs(searched.changes - replayed.changes) < 1e-12);
    CHECK(std::abs(searched.turbulence - replayed.turbulence) < 1e-9 * (1.0 + replayed.turbulence));
    CHECK(std::abs(searched.landing - replayed.landing) < 1e-9);
    CHECK((replayed.turbulence > 0.0) == (turbulence > 0.0));
    CHECK(std::abs(found.cost - alone.cost) < 1e-9 * alone.cost);
    // From a fall that lands well, with the sketch drawing it elsewhere.
    RefiningState refining = RefiningState::from(fall, fall.release(), found);
    REQUIRE(refine_in_windows(fall, fall.release(), refining, {}));
    const ReplayedFall refined = replay(fall, fall.release(), refining.best.knots);
    CHECK(refined.cost == refining.best.cost);
    CHECK(refined.cost < alone.cost);
    CHECK(cost_of(fall, refined.end).landing <= alone.cost);
  }
}

TEST_CASE("the squares that a window sums up are the cost of the fall, at any coefficients") {
  MotionPlan plan = sequence_plan(15.0);
  samara::Stream stream(25, 0);
  for (int n = 0; n < 6; ++n) {
    plan.turbulence = n % 2 == 0 ? 0.0 : 0.5;
    plan.sketch = n % 3 == 0 ? std::optional<Sketch>() : slanted_sketch(15.0);
    plan.landing = n % 3 != 1 ? std::optional<Eigen::Vector3d>() : Eigen::Vector3d(10.0, 0.0, 0.0);
    const PlannedFall fall(plan);
    std::vector<CourseKnot> knots;
    for (int k = 0; k < 6; ++k) {
      CourseKnot knot;
      knot.t = 3.0 * k;
      knot.ramp = plan.search.ramp;
      for (const SteeredCoefficient& range : plan.box)
        knot.values.push_back(range.lower + (range.upper - range.lower) * stream.uniform());
      knots.push_back(knot);
    }
    const ReplayedFall replayed = replay(fall, fall.release(), knots);
    const FallCost cost = cost_of(fall, replayed.end);
    // Samples every 0.15 a/U or so of a fall of 15 a/U: 1e-3 of the path; accelerations are looked at every 0.32 a/U, a
    // tenth of a piece; the place of landing is that of a step, not of the ground.
    const double expected = cost.total() - cost.kinds;
    const double error = 1e-9 + 2e-3 * cost.path + 0.1 * cost.turbulence + 0.1 * std::sqrt(cost.landing);
    INFO(n << ": " << cost.path << " " << cost.changes << " " << cost.turbulence << " " << cost.landing);
    CHECK(std::abs(Windows(fall, knots).look(0, replayed, false).cost - expected) < error);
    CHECK((cost.path > 0.1) == (n % 3 != 0));
    CHECK(cost.changes > 1e-3);
    CHECK((cost.turbulence > 0.01) == (plan.turbulence > 0.0));
  }
}

TEST_CASE("a window that looks past the end of a fall costs what the fall does") {
  MotionPlan plan = sequence_plan(15.0);
  plan.sketch = slanted_sketch(15.0);
  const PlannedFall fall(plan);
  std::vector<CourseKnot> knots(4);
  for (std::size_t k = 0; k < knots.size(); ++k)
    knots[k] = {.t = 3.0 * static_cast<double>(k), .values = fall.natural(), .ramp = plan.search.ramp};
  std::vector<CourseKnot> more = knots;
  for (const double t : {100.0, 103.0}) more.push_back({.t = t, .values = fall.natural(), .ramp = 1.0});
  const auto cost = [&](std::vector<CourseKnot>& of) {
    const ReplayedFall replayed = replay(fall, fall.release(), of);
    return Windows(fall, of).look(0, replayed, false).cost;
  };
  CHECK(cost(more) == Approx(cost(knots)).epsilon(0.02));
}

TEST_CASE("windows find the landing that the search has missed") {
  MotionPlan plan = sequence_plan(20.0);
  plan.landing = Eigen::Vector3d(2.0, 0.0, 0.0);
  plan.search.beam = 1;
  plan.search.children = 2;
  plan.search.sweeps = 0;
  const double missed = plan_motion(plan).landing_miss;
  plan.search.sweeps = 4;
  CHECK(plan_motion(plan).landing_miss < 0.3 * missed);
}

TEST_CASE(
    "a search that is interrupted again and again, or kept at its end, has the same motion to the bit") {
  MotionPlan plan = sequence_plan();
  plan.database = plate_motions();
  plan.sketch = slanted_sketch(40.0);
  plan.sequence = read_text("length = 5\nseed = 3");
  const MotionResult whole = plan_motion(plan);
  const TemporaryDirectory directory;
  const auto part = directory / "planning.part";
  int interruptions = 0;
  MotionResult parts;
  do {
    // Later and later: on a slow machine a step may take longer than a few reports, and nothing be kept.
    int calls = 0;
    const int most = 4 + interruptions / 10;
    parts = plan_motion(plan, {.progress = [&](const samara::Progress&) { return ++calls < most; },
                               .checkpoint = part,
                               .keep_checkpoint = true});
    if (parts.status == MotionStatus::cancelled && interruptions++ == 0) {
      MotionPlan other = plan;
      other.search.seed = 2;
      CHECK_THROWS_WITH(plan_motion(other, {.checkpoint = part}), Catch::Contains("belongs to another plan"));
      CHECK(std::filesystem::exists(part));
    }
    REQUIRE(interruptions < 1000);
  } while (parts.status == MotionStatus::cancelled);
  CHECK(interruptions > 3);
  CHECK(std::filesystem::exists(part));
  CHECK(plan_motion(plan, {.checkpoint = part}).states == whole.states);
  CHECK_FALSE(std::filesystem::exists(part));
  CHECK(parts.status == whole.status);
  CHECK(parts.states == whole.states);
  CHECK(parts.cost.total() == whole.cost.total());
  REQUIRE(parts.history.size() == whole.history.size());
  for (std::size_t k = 0; k < whole.history.size(); ++k) {
    CHECK(parts.history[k].cost == whole.history[k].cost);
    CHECK(parts.history[k].pieces == whole.history[k].pieces);
  }
}

TEST_CASE("a search takes no other file for its checkpoint, and does not end where none can be written") {
  MotionPlan plan = sequence_plan();
  plan.sketch = slanted_sketch(40.0);
  const TemporaryDirectory directory;
  const auto capture = directory.put("capture.csv", "t,z\n0,1\n");
  CHECK_THROWS_WITH(
      plan_motion(plan, {.checkpoint = capture}),
      Catch::Contains("capture.csv: this is no checkpoint of a search for a motion, and would be lost"));
  CHECK(content(capture) == "t,z\n0,1\n");
  std::vector<std::string> told;
  const MotionResult cut =
      plan_motion(plan, {.progress = [](const samara::Progress&) { return false; },
                         .checkpoint = directory / std::string(300, 'n'),
                         .warning = [&](const std::string& sentence) { told.push_back(sentence); }});
  CHECK(cut.status == MotionStatus::cancelled);
  REQUIRE(told.size() == 1);
  CHECK_THAT(told.front(), Catch::StartsWith("no checkpoint: cannot write"));
}

TEST_CASE("the identity of a plan changes with the times of its sketch and the kinds of its database") {
  MotionPlan plan = sequence_plan();
  const Eigen::MatrixX3d points = Eigen::MatrixX3d::Zero(3, 3);
  plan.sketch = Sketch(points, Eigen::Vector3d(0.0, 1.0, 3.0));
  auto database = std::make_shared<MotionDatabase>(*plate_motions());
  plan.database = database;
  std::vector<std::string> texts = {identity_of(plan)};
  plan.sketch = Sketch(points, Eigen::Vector3d(0.0, 2.0, 3.0));
  texts.push_back(identity_of(plan));
  Pattern& pattern = database->runs.front().pattern;
  pattern = pattern == Pattern::zigzag ? Pattern::spiral : Pattern::zigzag;
  texts.push_back(identity_of(plan));
  EventKind& kind = database->segments.front().kind;
  kind = kind == EventKind::turn_plus ? EventKind::turn_minus : EventKind::turn_plus;
  texts.push_back(identity_of(plan));
  database->segments.front().is_steady = !database->segments.front().is_steady;
  texts.push_back(identity_of(plan));
  std::ranges::sort(texts);
  CHECK(std::ranges::adjacent_find(texts) == texts.end());
}

TEST_CASE("a checkpoint whose numbers lead out of its lists is damaged") {
  const MotionPlan plan = sequence_plan();
  const PlannedFall fall(plan);
  const TemporaryDirectory directory;
  const auto part = directory / "planning.part";
  PlanningState whole;
  whole.beam = BeamState::from(fall.release());
  whole.beam.rounds.push_back(whole.beam.rounds.front());
  whole.beam.rounds[1][0].parent = 0;
  whole.beam.ended.resize(2);
  whole.beam.finished = {{.round = 1, .index = 0, .cost = 1.0}};
  whole.refining.emplace();
  whole.refining->best.end = fall.release();
  whole.refining->knots = {{.t = 0.0, .values = fall.natural(), .ramp = 1.0}};
  const auto loaded = [&](const std::function<void(PlanningState&)>& change) {
    PlanningState state = whole;
    change(state);
    save_state(state, plan, part);
    return load_state(plan, part);
  };
  CHECK(loaded([](PlanningState&) {}).beam.rounds.size() == 2);
  CHECK(is_planning_state(part));
  const std::vector<std::function<void(PlanningState&)>> changes = {
      [](PlanningState& state) { state.beam.rounds[1][0].parent = 1; },
      [](PlanningState& state) { state.beam.rounds[1][0].parent = -1; },
      [](PlanningState& state) { state.beam.finished[0].index = 1; },
      [](PlanningState& state) { state.beam.finished[0].round = 2; },
      [](PlanningState& state) { state.beam.rounds[1][0].target.pop_back(); },
      [](PlanningState& state) { state.beam.rounds[0][0].point.state.pop_back(); },
      [](PlanningState& state) { state.beam.rounds[0][0].point.heading_for.clear(); },
      [](PlanningState& state) { state.beam.rounds[0][0].point.past = {4}; },
      [](PlanningState& state) { state.refining->best.end.coefficients.clear(); },
      [](PlanningState& state) { state.refining->knots[0].values.clear(); },
      [](PlanningState& state) { state.refining->sweep = -1; },
  };
  for (std::size_t k = 0; k < changes.size(); ++k) {
    INFO(k);
    CHECK_THROWS_WITH(loaded(changes[k]), Catch::Contains("does not hold a search"));
  }
}
