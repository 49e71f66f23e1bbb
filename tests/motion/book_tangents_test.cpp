/// Tangents of planned falls from a codebook.
#include <cmath>

#include <catch2/catch.hpp>

#include "plate_courses.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/motion/planning/fall_tangents.h"
#include "samara/motion/planning/planner.h"
#include "tests/io/temporary_directory.h"

using namespace samara::motion;
using namespace samara::models;

namespace {

/// Windows of the plate of plate_courses.h at A = 1.4, of velocities above zero: the others are images.
std::shared_ptr<const samara::codebooks::Codebook> windows(const char* tolerance) {
  const std::string text =
      std::string(
          "model = \"falling_plate_nd\"\n[fixed]\ninertia_ratio = 1.3\nA = 1.4\n[box]\nC_T = [0.9, 1.2]\n"
          "C_R = [2.6, 3.2]\n\"vx(0)\" = [0, 3.5]\n\"vy(0)\" = [0, 1.2]\n\"w(0)\" = [-1.5, 1.5]\n"
          "\"theta(0)\" = [-3.14159265358979324, 3.14159265358979324]\n[time]\nend = 0.1\n[tolerance]\n"
          "relative = ") +
      tolerance;
  return std::make_shared<const samara::codebooks::Codebook>(
      samara::codebooks::build(samara::codebooks::parse_plan(text, "windows.toml")).book);
}

const std::shared_ptr<const samara::codebooks::Codebook>& plate_windows() {
  static const auto book = windows("1e-4");
  return book;
}

/// To the right by 30 degrees over 20 semi-chords.
MotionPlan steered_plan() {
  MotionPlan plan;
  plan.model = find_model("falling_plate_nd");
  plan.fixed = kPlate;
  plan.box = {{"C_R", 2.6, 3.2, 3.0}, {"C_T", 0.9, 1.2, 1.0}};
  Eigen::MatrixX3d points(2, 3);
  points << 0.0, 0.0, 20.0, 20.0 * std::tan(0.5), 0.0, 0.0;
  plan.sketch = Sketch(points);
  plan.search = {.beam = 8, .children = 8, .sweeps = 1, .step = 0.01, .ramp = 1.0, .seed = 1};
  return plan;
}

struct Steered {
  std::vector<double> state;
  Eigen::MatrixXd tangents;
  BookUse use;
};

/// A fall along four knots, of which two are unknown, looked at every 37 steps.
Steered steer(const MotionPlan& plan) {
  const PlannedFall fall(plan);
  FallTangents motion(fall, 2);
  motion.begin(fall.release(), 2);
  for (const auto& [C_R, C_T] : {std::pair(2.7, 1.1), {3.1, 0.95}, {2.9, 1.15}, {3.0, 1.0}}) {
    motion.turn({.t = motion.time(), .values = {C_R, C_T}, .ramp = 1.0});
    for (int k = 0; k < 8; ++k) REQUIRE(motion.step(37));
  }
  return {motion.state(), motion.tangents(), motion.use()};
}

}  // namespace

TEST_CASE("tangents of a codebook are those of the steps, within its certificate") {
  MotionPlan plan = steered_plan();
  const Steered steps = steer(plan);
  plan.codebook = plate_windows();
  const Steered book = steer(plan);
  // Ramps take a third of the time, and are always made of steps.
  CHECK(book.use.asked == 4 * 8 * 37);
  CHECK(book.use.share() > 0.5);
  CHECK(book.use.share() < 0.67);
  // The state does not know of the codebook.
  for (std::size_t i = 0; i < steps.state.size(); ++i)
    CHECK(book.state[i] == Approx(steps.state[i]).epsilon(1e-10).margin(1e-10));
  // Slopes of a polynomial of degree n err by up to 2 n^2/width of its own error (Markov): here some hundreds of the
  // tolerance, of which the sum over windows shows some. A finer codebook errs less.
  const auto error = [&](const Steered& of) {
    return (of.tangents - steps.tangents).norm() / steps.tangents.norm();
  };
  CHECK(error(book) < 100.0 * 1e-4);
  plan.codebook = windows("1e-5");
  CHECK(error(steer(plan)) < 0.4 * error(book));
}

TEST_CASE("a plan with a codebook comes as near to its sketch, by one solution of the same steps") {
  MotionPlan plan = steered_plan();
  const MotionResult steps = plan_motion(plan);
  CHECK_FALSE(steps.book);
  plan.codebook = plate_windows();
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.book);
  CHECK(motion.book->windows > 100);
  CHECK(motion.book->share() > 0.3);
  CHECK(motion.deviation == Approx(steps.deviation).epsilon(1e-3));
  CHECK(motion.states == realise(plan, *motion.course).states);
  // Nothing is refined where nothing has tangents.
  plan.search.sweeps = 0;
  CHECK(plan_motion(plan).book->share() == 0.0);
}

TEST_CASE(
    "a refining that is interrupted goes on with its own codebook only, and counts all that it served") {
  MotionPlan plan = steered_plan();
  plan.search.sweeps = 2;
  plan.codebook = plate_windows();
  const MotionResult whole = plan_motion(plan);
  const TemporaryDirectory directory;
  const auto part = directory / "refining.part", file = directory / "windows.h5";
  samara::codebooks::save(*plan.codebook, file);
  plan.codebook = std::make_shared<const samara::codebooks::Codebook>(samara::codebooks::load(file));
  MotionPlan coarser = plan, without = plan;
  coarser.codebook = windows("1e-3");
  without.codebook.reset();
  int interruptions = 0;
  MotionResult parts;
  do {
    // One window of knots each time.
    int calls = 0;
    const auto progress = [&](const samara::Progress& at) { return at.stage != "refining" || ++calls < 2; };
    parts = plan_motion(plan, {.progress = progress, .checkpoint = part});
    if (parts.status == MotionStatus::cancelled && interruptions++ == 0) {
      for (const MotionPlan& other : {coarser, without}) {
        CHECK_THROWS_WITH(plan_motion(other, {.checkpoint = part}),
                          Catch::Contains("belongs to another plan"));
      }
    }
    REQUIRE(interruptions < 1000);
  } while (parts.status == MotionStatus::cancelled);
  CHECK(interruptions > 3);
  CHECK(parts.states == whole.states);
  REQUIRE(parts.book);
  CHECK(parts.book->windows == whole.book->windows);
  CHECK(parts.book->served == whole.book->served);
  CHECK(parts.book->asked == whole.book->asked);
}

TEST_CASE("outside the box of a codebook tangents are those of the steps") {
  MotionPlan plan = steered_plan();
  plan.box = {{"C_R", 2.0, 3.2, 3.0}, {"C_T", 0.5, 1.2, 1.0}};
  plan.codebook = plate_windows();
  const PlannedFall fall(plan);
  FallTangents motion(fall, 1);
  motion.begin(fall.release(), 1);
  motion.turn({.t = 0.0, .values = {3.0, 0.6}, .ramp = 1.0});
  REQUIRE(motion.step(300));
  CHECK(motion.use().windows == 0);
  const Eigen::MatrixXd first = motion.tangents();
  plan.codebook.reset();
  const PlannedFall alone(plan);
  FallTangents same(alone, 1);
  same.begin(alone.release(), 1);
  same.turn({.t = 0.0, .values = {3.0, 0.6}, .ramp = 1.0});
  REQUIRE(same.step(300));
  CHECK(first == same.tangents());
}

TEST_CASE("a codebook of another body, or that is no flow map of it, is refused") {
  MotionPlan plan = steered_plan();
  const auto refuses = [&](const std::string& sentence) {
    CHECK_THROWS_WITH(plan_motion(plan), Catch::Contains(sentence));
  };
  plan.codebook = plate_windows();
  plan.fixed["inertia_ratio"] = 1.2;
  refuses("the codebook has inertia_ratio = 1.3, the body has 1.2");
  plan.fixed["inertia_ratio"] = 1.3;
  plan.box.push_back({"A", 1.0, 1.8, 1.4});
  refuses("no coordinate A");
  plan.box = {{"C_T", 0.2, 0.5, 0.4}};
  refuses("the codebook has C_T from 0.9 to 1.2, the plan 0.2 to 0.5");
  plan.box = {{"C_T", 0.9, 1.2, 1.0}};
  plan.fixed["C_R"] = 3.5;
  refuses("the codebook has C_R from 2.6 to 3.2, the plan 3.5");
  plan = steered_plan();
  plan.codebook = plate_windows();
  plan.search.step = 0.2;
  refuses("expected a step of the plan, 0.2, or more");
  plan = steered_plan();
  plan.codebook = std::make_shared<const samara::codebooks::Codebook>(
      samara::codebooks::build(
          samara::codebooks::parse_plan("model = \"falling_plate_nd\"\n[fixed]\ninertia_ratio = 1.3\n[box]\n"
                                        "C_T = [0.9, 1.2]\n[time]\nend = 0.1\n[tolerance]\nrelative = 1e-3\n",
                                        "no_windows.toml"))
          .book);
  refuses("a flow map needs");
  plan.model = find_model("falling_plate");
  plan.fixed = {{"semi_chord", 5e-3}, {"semi_thickness", 5e-4}, {"density", 1e4}, {"y(0)", 0.3}};
  plan.box = {{"C_T", 0.9, 1.2, 1.0}};
  refuses("the codebook is of \"falling_plate_nd\", expected one of \"falling_plate\"");
}
