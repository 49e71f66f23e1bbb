/// Courses of coefficients, and the invisible force of motions.
#include <cmath>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "plate_courses.h"
#include "samara/base/streams.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/models/batch/stepper.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/ghost/ghost_force.h"
#include "samara/motion/planning/planner.h"

using namespace samara::motion;
using namespace samara::models;

namespace {

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

const GhostOptions kBox = {.box = {{"C_T", {0.8, 1.4}}, {"C_R", {2.0, 4.0}}}};

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

TEST_CASE("frames that are left out are no noise, and noise is found between uneven ones") {
  const ParametricModel plate = smooth_plate();
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(1201, 0.0, 24.0);
  const Trajectory fall = integrate(plate, {}, {times.data(), 1201}, {.relative_tolerance = 1e-13});
  // Intervals of 2, 1, 1, 2, .. frames.
  std::vector<Eigen::Index> left;
  for (Eigen::Index k = 200; k < 1200; ++k) {
    if (k % 2 == 0 || k % 3 == 0) left.push_back(k);
  }
  const auto frames = static_cast<Eigen::Index>(left.size());
  const PosePath all = path_of(plate.model().info(), times.tail(1000), fall.states.bottomRows(1000));
  PosePath some = path_of(plate.model().info(), times(left), fall.states(left, Eigen::all));
  // Eighth derivatives count for 1.5^8 = 26 times as much at 1.5 times the interval.
  CHECK(noise_of(some).position < 100.0 * noise_of(all).position);
  CHECK(noise_of(some).angle < 100.0 * noise_of(all).angle);
  CHECK_FALSE(ghost_force(plate, some).noise->decides);

  samara::Stream stream(6, 0);
  constexpr double kPlace = 1e-4, kAngle = 2e-4;
  PosePath turning{.times = some.times, .poses = Eigen::MatrixXd::Zero(frames, 7)};
  for (Eigen::Index k = 0; k < frames; ++k) {
    const double t = turning.times[k];
    const Eigen::Quaterniond q = Eigen::AngleAxisd(3.0 * t, Eigen::Vector3d::UnitZ()) *
                                 Eigen::AngleAxisd(2.0 * t, Eigen::Vector3d::UnitX());
    turning.poses.row(k).tail<4>() << q.w(), q.x(), q.y(), q.z();
  }
  CHECK(noise_of(turning).angle < 1e-2 * kAngle);
  for (Eigen::Index k = 0; k < frames; ++k) {
    const Eigen::Vector3d e = kAngle * Eigen::Vector3d(stream.normal(), stream.normal(), stream.normal());
    const Eigen::Vector4d q = turning.poses.row(k).tail<4>();
    const Eigen::Quaterniond noisy = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) *
                                     Eigen::Quaterniond(1.0, 0.5 * e.x(), 0.5 * e.y(), 0.5 * e.z());
    turning.poses.row(k) << kPlace * stream.normal(), kPlace * stream.normal(), kPlace * stream.normal(),
        noisy.w(), noisy.x(), noisy.y(), noisy.z();
    some.poses.row(k) +=
        Eigen::RowVector3d(kPlace * stream.normal(), kPlace * stream.normal(), kAngle * stream.normal());
  }
  for (const PosePath& noisy : {turning, some}) {
    CHECK(noise_of(noisy).position == Approx(kPlace).epsilon(0.15));
    CHECK(noise_of(noisy).angle == Approx(kAngle).epsilon(0.15));
  }
}

TEST_CASE("quaternions of a path need not have the length one, but one length") {
  const std::map<std::string, double> leaf = {
      {"a", 0.035}, {"b", 0.02},  {"c", 1e-4},  {"density", 1200.0}, {"C_D0", 0.05}, {"C_D90", 0.9},
      {"C_T", 1.0}, {"C_R", 1.0}, {"C_w", 2.0}, {"wx(0)", 1.0},      {"wy(0)", 2.0}, {"wz(0)", 3.0}};
  const ParametricModel model(find_model("immersed_body"), leaf, {});
  const Eigen::VectorXd times = Eigen::VectorXd::LinSpaced(51, 0.0, 0.05);
  const Trajectory motion = integrate(model, {}, {times.data(), 51}, {.relative_tolerance = 1e-12});
  const PosePath path = path_of(model.model().info(), times, motion.states);
  const auto scaled = [&](double begin, double end) {
    PosePath other = path;
    other.poses.rightCols(4).array().colwise() *= Eigen::ArrayXd::LinSpaced(51, begin, end);
    return other;
  };
  const double rms = ghost_force(model, path).declared.force_sizes.rms;
  CHECK(ghost_force(model, scaled(0.9695, 0.9695)).declared.force_sizes.rms == Approx(rms).margin(1e-9));
  CHECK_THROWS_WITH(path_rates(scaled(1.0, 1.1)),
                    "the quaternion in frame 1 of the path has the length 1.002, expected 1 as in frame 0");
  CHECK_THROWS_WITH(path_rates(scaled(0.0, 0.0)),
                    "the quaternion in frame 0 of the path has the length 0, expected 0.001 or more");
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
  PosePath fast = path;
  fast.times *= 1e-60;
  CHECK_THROWS_WITH(ghost_force(plain, fast), Catch::Contains("1e+100 net weights or more") &&
                                                  Catch::Contains("frames in 3e-60 takes"));
  path.poses(5, 2) = std::nan("");
  CHECK_THROWS_WITH(ghost_force(plain, path), Catch::Contains("frame 5"));
}
