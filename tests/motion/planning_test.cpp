/// Falls that follow a sketch.
#include <cmath>

#include <catch2/catch.hpp>

#include "plate_courses.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/models/stochastic/turbulent_action.h"
#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/planning/fall_cost.h"
#include "samara/motion/planning/fall_lanes.h"
#include "samara/motion/planning/planner.h"

using namespace samara::motion;
using namespace samara::models;

namespace {

/// To the right by 30 degrees over 20 semi-chords.
MotionPlan slanted_plan() {
  MotionPlan plan;
  plan.model = find_model("falling_plate_nd");
  plan.fixed = kPlate;
  plan.box = {{"C_T", 0.8, 1.4, 1.0}, {"C_R", 2.0, 4.0, 3.0}, {"A", 1.0, 1.8, 1.4}};
  Eigen::MatrixX3d points(2, 3);
  points << 0.0, 0.0, 20.0, 20.0 * std::tan(0.5), 0.0, 0.0;
  plan.sketch = Sketch(points);
  plan.search = {.beam = 12, .children = 12, .sweeps = 1, .step = 0.01, .ramp = 1.0, .seed = 1};
  return plan;
}

std::string plan_text(const std::string& changed = "", const std::string& to = "") {
  std::string text =
      "model = \"falling_plate_nd\"\n[body]\ninertia_ratio = 1.3\n[release]\nheight = 20\ntilt = \"30 deg\"\n"
      "[landing]\nx = 4\n[box]\nC_T = [0.8, 1.4]\nC_R = [2, 4]\n[search]\nbeam = 8\n";
  const std::size_t at = text.find(changed);
  REQUIRE(at != std::string::npos);
  return text.replace(at, changed.size(), to);
}

}  // namespace

TEST_CASE("decisions of a plan fall beside the events that a database has, and the ghost counts the same") {
  const MotionPlan plan = slanted_plan();
  const PlannedFall fall(plan);
  const FallPoint release = fall.release();
  std::vector<FallPiece> pieces(1);
  const samara::ProgressCallback nobody;
  samara::SharedProgress progress(nobody, "falls", 1.0);
  FallLanes(fall).run(std::vector<Continuation>{{.from = &release, .target = fall.natural()}}, pieces,
                      progress);
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(1601, 0.0, 16.0);
  const Trajectory motion = integrate(ParametricModel(plan.model, plan.fixed, {}), {}, {times.data(), 1601});
  const double speed = plan.scales().velocity;
  const EventList list = events_of(MovingStates(plan.model->info(), BodySymmetry::none),
                                   event_options(speed * speed, 2.0 * plan.semi_length()),
                                   {times.data(), 1601}, motion.states.transpose());
  REQUIRE(list.events.size() >= 2);
  CHECK(pieces[0].kind == list.events[0].kind);
  CHECK(std::abs(pieces[0].to.t - list.events[0].t) <= plan.search.step);
  const EventList of_path = [&] {
    const Eigen::Index last = times.size() - 1 - kEndFrames, count = last - kEndFrames + 1;
    const Eigen::MatrixXd states = motion.states.middleRows(kEndFrames, count).transpose();
    const double square = states.topRows(2).colwise().squaredNorm().mean();
    return events_of(MovingStates(plan.model->info(), BodySymmetry::none), event_options(square, 2.0),
                     {times.data() + kEndFrames, static_cast<std::size_t>(count)}, states);
  }();
  CHECK(ghost_force(ParametricModel(plan.model, plan.fixed, {}),
                    path_of(plan.model->info(), times, motion.states))
            .events == std::ssize(of_path.events));
}

TEST_CASE("a planned fall is one solution that follows its sketch, whatever the threads") {
  MotionPlan plan = slanted_plan();
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.status == MotionStatus::found);
  // Every constant set of coefficients stays further off: the body as it is, to begin with.
  const RealisedFall natural = realise(plan, CoefficientCourse({"C_T", "C_R", "A"}, {1.0, 3.0, 1.4}));
  CHECK(motion.deviation < 0.5 * natural.deviation);
  for (const CourseKnot& knot : motion.course->knots()) {
    for (std::size_t j = 0; j < plan.box.size(); ++j) {
      CHECK(knot.values[j] >= plan.box[j].lower);
      CHECK(knot.values[j] <= plan.box[j].upper);
    }
  }
  // It needs no ghost at its own course, whose accelerations have kinks in their rates at knots.
  const PosePath path = path_of(plan.model->info(), motion.times, motion.states);
  CHECK(ghost_force(declared(*motion.course), path).declared.force_sizes.max < 1e-3);

  plan.search.threads = 1;
  const MotionResult alone = plan_motion(plan);
  CHECK(alone.deviation == motion.deviation);
  CHECK(alone.states == motion.states);
  CHECK(std::ssize(motion.history) > 3);
}

TEST_CASE(
    "windows of Gauss and Newton's method do not make a fall worse, and the end of a plan is a status") {
  MotionPlan plan = slanted_plan();
  plan.search.sweeps = 0;
  const double beam = plan_motion(plan).deviation;
  plan.search.sweeps = 2;
  plan.deviation = 1e-3;
  const MotionResult refined = plan_motion(plan);
  CHECK(refined.deviation < beam * (1.0 + 1e-3));  // both costs count changes too
  CHECK(refined.status == MotionStatus::deviation_missed);
  CHECK_THAT(refined.message, Catch::Contains("was asked"));
  plan.deviation.reset();
  plan.duration = 1e3;
  CHECK(plan_motion(plan).status == MotionStatus::landed_early);
  CHECK(plan_motion(plan, {.progress = [](const samara::Progress&) { return false; }}).status ==
        MotionStatus::cancelled);
  const MotionResult late = plan_motion(
      plan, {.progress = [](const samara::Progress& report) { return report.stage != "refining"; }});
  CHECK(late.status == MotionStatus::cancelled);
  CHECK_FALSE(late.is_usable());
  plan.search.step = 1e-9;
  CHECK_THROWS_WITH(plan_motion(plan), Catch::Contains("a step of 1e-09 makes"));
}

TEST_CASE("a search whose falls all leave the numbers is lost, and says so") {
  // Damping of the rate that no step can follow: within the first one it overflows.
  MotionPlan plan = slanted_plan();
  plan.fixed["mu2"] = 1e300;
  const MotionResult motion = plan_motion(plan);
  CHECK(motion.status == MotionStatus::lost);
  CHECK(to_string(motion.status) == "lost");
  CHECK_FALSE(motion.is_usable());
  CHECK(motion.times.size() == 0);
  CHECK_THAT(motion.message, Catch::Contains("no fall came to the ground") && Catch::Contains("not finite"));
}

TEST_CASE("a long fall is one solution, though who replays its course comes to another place") {
  // Plates of I* 2 are chaotic: an error grows by a factor of e within some lengths.
  MotionPlan plan = slanted_plan();
  plan.fixed["inertia_ratio"] = 2.0;
  plan.fixed["y(0)"] = 250.0;
  plan.sketch.reset();
  plan.landing = Eigen::Vector3d(0.0, 0.0, 0.0);
  plan.search = {.beam = 2, .children = 4, .sweeps = 0, .step = 0.02, .ramp = 1.0, .seed = 1};
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.is_usable());
  CHECK(motion.replayed_until < motion.end);
  CHECK(motion.replayed_until > 10.0);
  const PosePath path = path_of(plan.model->info(), motion.times, motion.states);
  CHECK(ghost_force(declared(*motion.course, plan.fixed), path).declared.force_sizes.max < 5e-3);
  // The states are those of the course by the plan's steps, to the bit.
  CHECK(realise(plan, *motion.course).states == motion.states);

  plan.fixed["y(0)"] = 10.0;
  const MotionResult brief = plan_motion(plan);
  CHECK(brief.replayed_until == brief.end);
}

TEST_CASE("a fall comes down where it is asked to") {
  const MotionPlan plan = parse_motion_plan(plan_text(), "motion.toml");
  const MotionResult motion = plan_motion(plan);
  REQUIRE(motion.is_usable());
  const RealisedFall natural = realise(plan, CoefficientCourse({"C_R", "C_T"}, {3.0, 1.1}));
  CHECK(motion.landing_miss < 0.5);
  CHECK(natural.landing_miss > 2.0);
  CHECK(motion.status == MotionStatus::found);
  MotionPlan hasty = plan;
  hasty.duration = 2.0;
  const MotionResult above = plan_motion(hasty);
  CHECK(above.status == MotionStatus::not_landed);
  CHECK_THAT(above.message, Catch::Contains("above the ground after 2"));
  // Path and place are judged both: the sketch ends forty away from the landing place.
  MotionPlan both = slanted_plan();
  both.landing = Eigen::Vector3d(-30.0, 0.0, 0.0);
  both.deviation = 20.0;
  const MotionResult torn = plan_motion(both);
  CHECK(torn.landing_miss > 20.0);
  CHECK(torn.deviation < 20.0);
  CHECK(torn.status == MotionStatus::deviation_missed);
  CHECK_THAT(torn.message, Catch::Contains("rms from the sketch") && Catch::Contains("landing place"));
}

TEST_CASE("calm air keeps coefficients at home") {
  MotionPlan plan = slanted_plan();
  const auto roams = [&] {
    const MotionResult motion = plan_motion(plan);
    double sum = 0.0;
    for (const CourseKnot& knot : motion.course->knots()) sum += std::abs(knot.values[1] - 3.0);
    return sum / static_cast<double>(motion.course->knots().size());
  };
  const double free = roams();
  plan.turbulence = 1e-3;
  CHECK(roams() < 0.2 * free);
}

TEST_CASE("the price of turbulence is the action of its energy, and 1 for what turbulence does by itself") {
  MotionPlan plan = slanted_plan();
  CHECK(turbulence_factor(plan) == 0.0);
  plan.turbulence = 0.3;
  const double k = 1.5 * std::pow(0.3 * plan.scales().velocity, 2);
  const double epsilon = std::pow(0.09, 0.75) * std::pow(k, 1.5) / (0.14 * plan.semi_length());
  const Eigen::Vector3d extra(0.7, -0.2, 1.1);
  const double action = turbulent_action(extra, 0.3, {.k = k, .epsilon = epsilon}, {.C_0 = 2.1});
  CHECK(turbulence_factor(plan) * extra.squaredNorm() * 0.3 == Approx(action / 1.5).epsilon(1e-12));
}

TEST_CASE("plans of motions say in one sentence what is wrong with them") {
  const auto refuses = [](const std::string& text, const std::string& sentence) {
    CHECK_THROWS_WITH(parse_motion_plan(text, "motion.toml"),
                      Catch::Contains("motion.toml") && Catch::Contains(sentence));
  };
  refuses(plan_text("C_R = [2, 4]", "C_r = [2, 4]"), "did you mean");
  refuses(plan_text("C_R = [2, 4]", "C_R = [4, 2]"), "the first less");
  refuses(plan_text("[landing]\nx = 4\n", ""), "expected one of them");
  refuses(plan_text("beam = 8", "beam = 0"), "expected 1 to");
  refuses(plan_text("beam = 8", "step = 2"), "expected a ramp");
  refuses(plan_text("beam = 8", "step = 1e-9"), "steps of 1e-09");
  refuses(plan_text("height = 20", "height = -1"), "more than 0");
  refuses(plan_text("inertia_ratio = 1.3", "inertia_ratio = -1.3"), "inertia_ratio");
  Eigen::MatrixX3d rising(2, 3);
  rising << 0.0, 0.0, 1.0, 0.0, 0.0, 2.0;
  CHECK_THROWS_WITH(Sketch(rising), Catch::Contains("goes down"));
}
