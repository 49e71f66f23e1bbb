/// Courses of coefficients, the invisible force of motions, and falls that follow a sketch.
#include <cmath>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/base/streams.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/batch/stepper.h"
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

const std::map<std::string, double> kPlate = {{"inertia_ratio", 1.3}, {"theta(0)", 0.6}, {"y(0)", 20.0},
                                              {"C_T", 1.0},           {"C_R", 3.0},      {"A", 1.4}};

CoefficientCourse course() {
  return CoefficientCourse({"C_T", "C_R"}, {1.0, 3.0},
                           {{0.5, {1.3, 2.5}, 1.0}, {1.0, {0.9, 3.5}, 2.0}, {6.0, {1.0, 3.0}, 1.0}});
}

/// A fall with this course, without the coefficients in `fixed`.
Trajectory fall(std::shared_ptr<const ParameterCourse> course, const Eigen::VectorXd& times) {
  std::map<std::string, double> fixed = kPlate;
  for (const std::string& name : course->followed()) fixed.erase(name);
  const ParametricModel model(following(find_model("falling_plate_nd"), std::move(course)), fixed, {});
  return integrate(model, {}, {times.data(), static_cast<std::size_t>(times.size())},
                   {.relative_tolerance = 1e-12});
}

/// Without the damping mu2 |w| w, whose rate has kinks.
ParametricModel smooth_plate() {
  std::map<std::string, double> fixed = kPlate;
  fixed["mu2"] = 0.0;
  return {find_model("falling_plate_nd"), fixed, {}};
}

PosePath path_of_fall(const CoefficientCourse& course, double interval, double end) {
  const auto frames = static_cast<Eigen::Index>(std::lround(end / interval)) + 1;
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(frames, 0.0, end);
  return path_of(find_model("falling_plate_nd")->info(), times,
                 fall(std::make_shared<CoefficientCourse>(course), times).states);
}

ParametricModel declared(const CoefficientCourse& course, std::map<std::string, double> fixed = kPlate) {
  for (const std::string& name : course.followed()) fixed.erase(name);
  return {following(find_model("falling_plate_nd"), std::make_shared<CoefficientCourse>(course)), fixed, {}};
}

const GhostOptions kBox = {.box = {{"C_T", {0.8, 1.4}}, {"C_R", {2.0, 4.0}}}};

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

TEST_CASE("a course is the one that a stepper takes, and its codebook gives it back to round-off") {
  const CoefficientCourse c = course();
  const ParametricModel plate(find_model("falling_plate_nd"), {}, {"C_T", "C_R"});
  Stepper lane(plate, {"C_T", "C_R"}, 1);
  lane.load(0, c.first());
  const samara::codebooks::Codebook book =
      course_codebook(c, plate.model().info(), {{"inertia_ratio", 1.3}}, 10.0);
  const auto replayed = samara::identification::codebook_course(book, plate.model().info());
  std::size_t next = 0;
  for (int step = 0; step <= 80; ++step) {
    const double t = 0.125 * step;
    if (next < c.knots().size() && t == c.knots()[next].t) {
      lane.ramp(0, c.knots()[next].values, c.knots()[next].ramp);
      ++next;
    }
    std::array<double, 2> exact, stepped, read;
    c.values(t, {}, exact);
    lane.read_parameters(0, stepped);
    replayed->values(t, {}, read);
    for (const std::size_t j : {0, 1}) {
      CHECK(std::abs(stepped[j] - exact[j]) < 1e-14);
      CHECK(std::abs(read[j] - exact[j]) < 1e-13);
    }
    lane.step(0.125);
  }
  CHECK(book.certificate()->met);
  CHECK(book.certificate()->times == 4 * 6 + 1);  // quarters between 0, three knots, two ends of ramps, 10
  CHECK(book.certificate()->max_error < 1e-13);
  CHECK(book.model().fixed.at("inertia_ratio") == 1.3);
}

TEST_CASE("courses that are none are refused") {
  CHECK_THROWS_WITH(CoefficientCourse({"C_T"}, {1.0}, {{1.0, {1.1}, 1.0}, {0.5, {1.2}, 1.0}}),
                    Catch::Contains("increase"));
  CHECK_THROWS_WITH(CoefficientCourse({"C_T"}, {1.0}, {{1.0, {1.1}, 0.0}}),
                    Catch::Contains("ramp of a knot is 0"));
  CHECK_THROWS_WITH(CoefficientCourse({"C_T"}, {1.0, 2.0}), Catch::Contains("2 values"));
  CHECK_THROWS_WITH(
      course_codebook(CoefficientCourse({"C_t"}, {1.0}), find_model("falling_plate_nd")->info(), {}, 1.0),
      Catch::Contains("did you mean"));
}

TEST_CASE("rates of a path come with order six, in a plane and in space") {
  // In space R = Rz(t) Rx(1.3 t): w = (1.3, sin 1.3 t, cos 1.3 t) in body axes.
  std::array<double, 2> planar, spatial;
  for (const int k : {0, 1}) {
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced((50 << k) + 1, 0.0, 5.0);
    PosePath flat{.times = t, .poses = Eigen::MatrixXd(t.size(), 3)},
        deep{.times = t, .poses = Eigen::MatrixXd(t.size(), 7)};
    flat.poses << t.array().sin(), (2.0 * t.array()).cos(), (1.3 * t.array()).sin();
    for (Eigen::Index i = 0; i < t.size(); ++i) {
      const double c = std::cos(0.5 * t[i]), s = std::sin(0.5 * t[i]);
      const double cx = std::cos(0.65 * t[i]), sx = std::sin(0.65 * t[i]);
      // Of either sign: q and -q are the same attitude.
      deep.poses.row(i) << std::sin(t[i]), 0.0, std::cos(2.0 * t[i]), c * cx, c * sx, s * sx, s * cx;
      if (i % 3 == 0) deep.poses.row(i).tail<4>() *= -1.0;
    }
    const PathRates in_plane = path_rates(flat), in_space = path_rates(deep);
    double worst_planar = 0.0, worst_spatial = 0.0;
    for (Eigen::Index i = 0; i < in_plane.velocities.rows(); ++i) {
      const double at = t[i + kEndFrames], theta = std::sin(1.3 * at), b = 1.3 * at;
      const double ax = -std::sin(at), ay = -4.0 * std::cos(2.0 * at);
      const double vy = -std::sin(theta) * std::cos(at) - std::cos(theta) * 2.0 * std::sin(2.0 * at);
      const double w = 1.3 * std::cos(1.3 * at);
      worst_planar = std::max(
          {worst_planar, std::abs(in_plane.velocities(i, 1) - vy),
           std::abs(in_plane.accelerations(i, 0) - (std::cos(theta) * ax + std::sin(theta) * ay + w * vy)),
           std::abs(in_plane.accelerations(i, 2) + 1.69 * theta)});
      worst_spatial = std::max(
          {worst_spatial,
           (in_space.velocities.row(i).tail<3>() - Eigen::RowVector3d(1.3, std::sin(b), std::cos(b))).norm(),
           (in_space.accelerations.row(i).tail<3>() -
            Eigen::RowVector3d(0.0, 1.3 * std::cos(b), -1.3 * std::sin(b)))
               .norm()});
    }
    planar[static_cast<std::size_t>(k)] = worst_planar;
    spatial[static_cast<std::size_t>(k)] = worst_spatial;
  }
  CHECK(std::log2(planar[0] / planar[1]) > 5.7);
  CHECK(std::log2(spatial[0] / spatial[1]) > 5.7);
}

TEST_CASE("a solution needs no ghost") {
  const ParametricModel plate = smooth_plate();
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(601, 0.0, 12.0);
  const Trajectory fall = integrate(plate, {}, {times.data(), 601}, {.relative_tolerance = 1e-13});
  // The release is not smooth.
  const GhostForce ghost =
      ghost_force(plate, path_of(plate.model().info(), times.tail(450), fall.states.bottomRows(450)));
  CHECK(ghost.declared.force_sizes.max < 1e-6);
  CHECK(ghost.declared.torque_sizes.max < 1e-6);
}

TEST_CASE("a body in space needs no ghost either, and a push is found in its own size") {
  const std::map<std::string, double> leaf = {
      {"a", 0.035}, {"b", 0.02},  {"c", 1e-4},  {"density", 1200.0}, {"C_D0", 0.05}, {"C_D90", 0.9},
      {"C_T", 1.0}, {"C_R", 1.0}, {"C_w", 2.0}, {"wx(0)", 1.0},      {"wy(0)", 2.0}, {"wz(0)", 3.0}};
  const ParametricModel model(find_model("immersed_body"), leaf, {});
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(401, 0.0, 0.2);
  const Trajectory motion = integrate(model, {}, {times.data(), 401}, {.relative_tolerance = 1e-12});
  PosePath path = path_of(model.model().info(), times, motion.states);
  const GhostForce none = ghost_force(model, path);
  CHECK(none.declared.force_sizes.max < 1e-4);
  CHECK(none.declared.torque_sizes.max < 1e-4);
  // An acceleration of 0.1 g more along world x: at least the mass times that, at most with all of the added mass.
  for (Eigen::Index k = 0; k < times.size(); ++k) path.poses(k, 0) += 0.5 * 0.981 * times[k] * times[k];
  const GhostForce pushed = ghost_force(model, path);
  CHECK(pushed.declared.force_sizes.max > 0.09);
}

TEST_CASE(
    "of a noisy path the ghost is that of its noise, which is found and said, and a clean one has none") {
  const ParametricModel plate = smooth_plate();
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(1201, 0.0, 24.0);
  const Trajectory fall = integrate(plate, {}, {times.data(), 1201}, {.relative_tolerance = 1e-13});
  PosePath path = path_of(plate.model().info(), times.tail(1000), fall.states.bottomRows(1000));
  const GhostForce clean = ghost_force(plate, path);
  REQUIRE(clean.noise.has_value());
  CHECK(clean.noise->force < 1e-5);
  CHECK_FALSE(clean.noise->decides);
  const auto push = [&](double size) {
    PosePath pushed = path;
    for (Eigen::Index k = 0; k < 1000; ++k) pushed.poses(k, 0) += 0.5 * size * times[k] * times[k];
    return ghost_force(plate, pushed);
  };
  samara::Stream stream(5, 0);
  constexpr double kPlace = 1e-4, kAngle = 2e-4;
  for (Eigen::Index k = 0; k < 1000; ++k) {
    path.poses.row(k) +=
        Eigen::RowVector3d(kPlace * stream.normal(), kPlace * stream.normal(), kAngle * stream.normal());
  }
  const GhostForce noisy = ghost_force(plate, path);
  // Medians of 990 differences that are not independent.
  CHECK(noisy.noise->frames.position == Approx(kPlace).epsilon(0.15));
  CHECK(noisy.noise->frames.angle == Approx(kAngle).epsilon(0.15));
  CHECK(noisy.declared.force_sizes.rms == Approx(noisy.noise->force).epsilon(0.2));
  CHECK(noisy.declared.torque_sizes.rms == Approx(noisy.noise->torque).epsilon(0.2));
  CHECK(noisy.noise->decides);
  CHECK_FALSE(push(10.0).noise->decides);
  CHECK(path.times.size() > kFewestFrames);
  PosePath few = path;
  few.times = path.times.head(9);
  few.poses = path.poses.topRows(9);
  CHECK_FALSE(ghost_force(plate, few).noise.has_value());

  // In space likewise, by rotations.
  PosePath turning{.times = times.head(800), .poses = Eigen::MatrixXd::Zero(800, 7)};
  for (Eigen::Index k = 0; k < 800; ++k) {
    const Eigen::Vector3d e = kAngle * Eigen::Vector3d(stream.normal(), stream.normal(), stream.normal());
    const Eigen::Quaterniond q = Eigen::AngleAxisd(0.7 * times[k], Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(0.4 * times[k], Eigen::Vector3d::UnitX()) *
                                 Eigen::Quaterniond(1.0, 0.5 * e.x(), 0.5 * e.y(), 0.5 * e.z()).normalized();
    turning.poses.row(k) << 0.0, 0.0, kPlace * stream.normal(), q.w(), q.x(), q.y(), q.z();
  }
  CHECK(noise_of(turning).angle == Approx(kAngle).epsilon(0.15));
  CHECK(noise_of(turning).position == Approx(kPlace / std::sqrt(3.0)).epsilon(0.15));
}

TEST_CASE("smooth is not feasible: what was shifted or blended needs a ghost that no coefficient hides") {
  const CoefficientCourse one({"C_T", "C_R"}, {1.0, 3.0}), other({"C_T", "C_R"}, {0.9, 2.4});
  const PosePath path = path_of_fall(one, 0.02, 16.0), second = path_of_fall(other, 0.02, 16.0);
  const ParametricModel plain(find_model("falling_plate_nd"), kPlate, {});
  const GhostForce own = ghost_force(plain, path, kBox);
  CHECK(own.box->ghost.force_sizes.rms < 1e-3);
  CHECK(own.box->travel < 0.1);

  PosePath shifted = path;  // as a follower does that moves the root along a sketch
  for (Eigen::Index k = 0; k < path.times.size(); ++k)
    shifted.poses(k, 0) += 2.0 * std::sin(0.6 * path.times[k]);
  CHECK(ghost_force(plain, shifted, kBox).box->ghost.force_sizes.rms > 0.05);

  PosePath blended = path;  // C2, over two units of time
  for (Eigen::Index k = 0; k < path.times.size(); ++k) {
    const double s = std::clamp((path.times[k] - 8.0) / 2.0, 0.0, 1.0);
    const double weight = s * s * s * (10.0 + s * (6.0 * s - 15.0));
    blended.poses.row(k) += weight * (second.poses.row(k) - path.poses.row(k));
  }
  const GhostForce ghost = ghost_force(plain, blended, kBox);
  CHECK(ghost.box->ghost.force_sizes.max > 100.0 * own.box->ghost.force_sizes.max);
  CHECK(ghost.box->ghost.torque_sizes.max > 0.02);
}

TEST_CASE("what coefficients explain is found in the box, and how far they moved") {
  const CoefficientCourse c({"C_T", "C_R"}, {1.0, 3.0}, {{6.0, {1.3, 2.5}, 2.0}});
  const PosePath path = path_of_fall(c, 0.02, 14.0);
  const ParametricModel plain(find_model("falling_plate_nd"), kPlate, {});
  const GhostForce ghost = ghost_force(plain, path, kBox);
  CHECK(ghost.declared.force_sizes.max > 0.05);  // at the coefficients of before
  CHECK(ghost.box->ghost.force_sizes.rms < 1e-3);
  const Eigen::Index last = ghost.box->coefficients.rows() - 20;
  CHECK(std::abs(ghost.box->coefficients(last, 0) - 2.5) < 0.05);  // by name: C_R, C_T
  CHECK(std::abs(ghost.box->coefficients(last, 1) - 1.3) < 0.05);
}

TEST_CASE("paths and boxes of which no ghost can be told are refused by name") {
  const ParametricModel plain(find_model("falling_plate_nd"), kPlate, {});
  PosePath path = path_of_fall(CoefficientCourse({"C_T"}, {1.0}), 0.1, 3.0);
  CHECK_THROWS_WITH(ghost_force(plain, path, {.box = {{"inertia_ratio", {1.0, 2.0}}}}),
                    Catch::Contains("affine"));
  CHECK_THROWS_WITH(ghost_force(plain, path, {.box = {{"C_T", {2.0, 1.0}}}}),
                    Catch::Contains("range of C_T"));
  CHECK_THROWS_WITH(ghost_force(ParametricModel(find_model("immersed_body"),
                                                {{"a", 1.0}, {"b", 1.0}, {"c", 1.0}, {"density", 2e3}}, {}),
                                path),
                    Catch::Contains("in a plane"));
  path.poses(5, 2) = std::nan("");
  CHECK_THROWS_WITH(ghost_force(plain, path), Catch::Contains("frame 5"));
}

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
