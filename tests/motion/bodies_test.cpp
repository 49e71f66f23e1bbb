// Many bodies: each is one solution of the model, keeps the kinds that were planned for it, and costs no allocation.
#include "samara/motion/bodies/bodies.h"

#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/following_model.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/bodies/steady_wind.h"
#include "tests/allocation_count.h"
#include "tests/error_text.h"

using namespace samara::motion;

namespace {

const NextPieces& plate_pieces() {
  static const NextPieces pieces(build_database(
      run_sweep(parse_sweep_plan(
                    "model = \"falling_plate_nd\"\n[fixed]\nbeta = 0\ninertia_ratio = 1.3\n[axes]\n"
                    "C_T = { from = 0.8, to = 1.4 }\nC_R = { from = 2, to = 4 }\nA = { from = 1, to = "
                    "1.8 }\n[sample]\ncount = 300\n[releases]\ntilt = [0.6]\n[run]\nuntil = 60\nstep = "
                    "0.05\nsettle = 10\n",
                    "plates.toml"))
          .sweep));
  return pieces;
}

const NextPieces& card_pieces() {
  static const NextPieces pieces(build_database(
      run_sweep(
          parse_sweep_plan(
              "model = \"immersed_body\"\n[fixed]\na = 0.035\nb = 0.02\nc = 1e-4\ndensity = "
              "1200\nC_D0 = 0.05\nC_w = 2\n[axes]\nC_D90 = { from = 0.31, to = 2.71 }\nC_T = { from "
              "= 0.31, to = 2.71 }\nC_R = { from = 0.31, to = 2.71 }\n[sample]\ncount = "
              "150\n[releases]\ntilt = [0.17]\naxis = [0.6]\n[run]\nuntil = 2\nstep = 1e-3\nsettle = 0.5\n",
              "card.toml"))
          .sweep));
  return pieces;
}

/// Ramps of one body, as they were begun.
class Knots final : public samara::models::ParameterCourse {
 public:
  Knots(std::vector<std::string> names, double ramp) : names_(std::move(names)), ramp_(ramp) {}
  void add(double t, Eigen::VectorXd target) {
    times_.push_back(t);
    targets_.push_back(std::move(target));
  }
  const std::vector<std::string>& followed() const override { return names_; }
  void values(double t, std::span<const double>, std::span<double> followed) const override {
    Eigen::VectorXd at = targets_.front();
    for (std::size_t k = 1; k < times_.size() && times_[k] <= t; ++k) {
      // A ramp begins where the one before had come to.
      const double until = k + 1 < times_.size() ? std::min(t, times_[k + 1]) : t;
      const double s = std::clamp((until - times_[k]) / ramp_, 0.0, 1.0);
      at += s * s * (3.0 - 2.0 * s) * (targets_[k] - at);
    }
    Eigen::Map<Eigen::VectorXd>(followed.data(), at.size()) = at;
  }

 private:
  std::vector<std::string> names_;
  double ramp_;
  std::vector<double> times_;
  std::vector<Eigen::VectorXd> targets_;
};

std::vector<double> poses_of(const Bodies& bodies) {
  const auto count = static_cast<std::size_t>(bodies.count());
  std::vector<double> all(7 * count);
  bodies.read_poses(std::span(all).first(3 * count), std::span(all).last(4 * count));
  return all;
}

}  // namespace

TEST_CASE("a body is one solution of the model whose coefficients change, as CVODES has it") {
  const NextPieces& pieces = plate_pieces();
  constexpr double kStep = 0.005, kRamp = 1.0;
  Bodies bodies(pieces, 1, {.choice = BodiesOptions::Choice::graph, .step = kStep, .ramp = kRamp, .seed = 5});
  bodies.release(0, {0.0, 0.0, 0.0}, 0.0);
  std::vector<double> start(6), end(6), coefficients(3);
  bodies.read_state(0, start);
  bodies.read_coefficients(0, coefficients);
  const auto course = std::make_shared<Knots>(pieces.database().coefficient_names, kRamp);
  course->add(0.0, Eigen::Map<Eigen::VectorXd>(coefficients.data(), 3));
  int events = 0;
  for (int k = 0; k < 6000; ++k) {
    bodies.advance(kStep);
    for (const BodyEvent& event : bodies.events()) {
      course->add(bodies.time(0), pieces.coefficients(event.next));
      ++events;
    }
  }
  REQUIRE(events >= 3);
  bodies.read_state(0, end);
  std::vector<std::string> free;
  for (const std::string& name : pieces.database().state_names) free.push_back(name + "(0)");
  const samara::models::ParametricModel steered(
      following(samara::models::find_model("falling_plate_nd"), course), pieces.database().fixed, free);
  const std::array times = {0.0, bodies.time(0)};
  const auto exact = integrate(steered, start, times, {.relative_tolerance = 1e-10});
  const Eigen::VectorXd difference =
      exact.states.bottomRows(1).transpose() - Eigen::Map<Eigen::VectorXd>(end.data(), 6);
  // Steps have order 2 in ramps: 1e-4 at four times this step.
  CHECK(difference.norm() < 1e-4);
}

TEST_CASE(
    "planned kinds come about, nearly all if pieces are tried ahead, and no event is lost from the counts") {
  const NextPieces& pieces = plate_pieces();
  CHECK(pieces.sound() > 9 * pieces.tried() / 10);
  CHECK(pieces.sturdy_count() > pieces.graph().kept / 2);
  for (const auto choice : {BodiesOptions::Choice::graph, BodiesOptions::Choice::chain}) {
    for (const int tries : {0, 8}) {
      Bodies bodies(pieces, 40, {.choice = choice, .tries = tries, .seed = 9});
      for (Eigen::Index n = 0; n < 40; ++n) bodies.release(n, {0.0, 0.0, 0.0}, 0.0);
      BodyCounts seen;
      for (int k = 0; k < 600; ++k) {
        bodies.advance(0.2);
        for (const BodyEvent& event : bodies.events()) {
          ++seen.events;
          seen.drawn += event.next.drawn.has_value();
          seen.taken += event.next.drawn == event.next.kind;
          seen.redrawn += event.next.is_of_chain && event.next.drawn != event.next.kind;
          if (!event.planned || event.is_steady) continue;
          ++seen.planned;
          seen.kept += event.kind == *event.planned;
        }
      }
      REQUIRE(seen.planned > 300);
      CHECK(static_cast<double>(seen.kept) > (tries == 0 ? 0.95 : 0.99) * static_cast<double>(seen.planned));
      const BodyCounts& all = bodies.counts();
      CHECK(std::array{all.events, all.dropped, all.planned, all.kept, all.drawn, all.taken, all.redrawn} ==
            std::array{seen.events, 0L, seen.planned, seen.kept, seen.drawn, seen.taken, seen.redrawn});
      // A kind that is drawn is not always to be had: then one is drawn among those that are.
      CHECK(all.drawn == (choice == BodiesOptions::Choice::chain ? all.events : 0));
      CHECK(2 * all.taken >= all.drawn);
      CHECK(all.taken + all.redrawn <= all.drawn);
      CHECK(static_cast<double>(all.taken + all.redrawn) >= 0.9 * static_cast<double>(all.drawn));
    }
  }
  Bodies one(pieces, 1, {.seed = 9});
  one.release(0, {0.0, 0.0, 0.0}, 0.0);
  one.advance(120.0);
  CHECK(one.events().size() == 4);
  CHECK(one.counts().dropped == one.counts().events - 4);
}

TEST_CASE("a steady stretch cuts what the chain remembers, and is none that was planned") {
  const NextPieces& pieces = card_pieces();
  REQUIRE(pieces.chain().order() > 0);
  constexpr Eigen::Index kCount = 40;
  constexpr std::uint64_t kSeed = 11;
  Bodies bodies(pieces, kCount, {.seed = kSeed});
  // Flat and from rest: nothing turns them.
  std::vector<double> state(13), coefficients = {1.0, 1.5, 1.5};
  state[3] = 1.0;
  for (Eigen::Index n = 0; n < kCount; ++n) bodies.release(n, state, coefficients);
  std::vector<bool> has_begun(kCount);
  long planned = 0, steady = 0;
  for (int k = 0; k < 180; ++k) {
    bodies.advance(1.0 / 60.0);
    for (const BodyEvent& event : bodies.events()) {
      planned += event.planned && !event.is_steady;
      steady += event.is_steady;
      if (has_begun[static_cast<std::size_t>(event.body)]) continue;
      has_begun[static_cast<std::size_t>(event.body)] = true;
      REQUIRE(event.is_steady);
      samara::Stream stream(kSeed, static_cast<std::uint64_t>(event.body));
      CHECK(static_cast<int>(event.next.drawn.value()) == pieces.chain().draw({}, stream));
    }
  }
  CHECK(steady > kCount);
  CHECK(bodies.counts().planned == planned);
}

TEST_CASE("bodies come to rest on the ground, where their way met it") {
  Bodies bodies(card_pieces(), 30, {.ground = -0.3, .seed = 2});
  for (Eigen::Index n = 0; n < 30; ++n) bodies.release(n, {0.01 * static_cast<double>(n), 0.0, 0.5}, 0.1);
  CHECK(bodies.falling() == 30);
  for (int k = 0; k < 600 && bodies.falling() > 0; ++k) bodies.advance(1.0 / 60.0);
  REQUIRE(bodies.falling() == 0);
  const std::vector<double> before = poses_of(bodies);
  bodies.advance(0.1);
  CHECK(poses_of(bodies) == before);
  for (std::size_t n = 0; n < 30; ++n) {
    CHECK(bodies.status(static_cast<Eigen::Index>(n)) == BodyStatus::landed);
    CHECK(before[3 * n + 2] == Approx(-0.3).margin(1e-12));
  }
}

TEST_CASE("a body that does not start above the ground is refused, and nothing has changed") {
  const BodiesOptions options = {.ground = 0.5, .seed = 2};
  Bodies cards(card_pieces(), 2, options), others(card_pieces(), 2, options);
  CHECK(error_text<samara::ArgumentError>([&] {
          cards.release(1, {0.0, 0.0, -1.0}, 0.0);
        }) == "body 1 starts at a height of -1 m, expected above the ground at 0.5 m");
  std::vector<double> state(13);
  state[3] = 1.0;
  state[2] = 0.5;
  CHECK(error_text<samara::ArgumentError>([&] { cards.release(0, state); }) ==
        "body 0 starts at a height of 0.5 m, expected above the ground at 0.5 m");
  CHECK(cards.status(0) == BodyStatus::waiting);
  CHECK(cards.status(1) == BodyStatus::waiting);
  // Nothing was drawn for it either.
  for (Bodies* bodies : {&cards, &others}) bodies->release(1, {0.0, 0.0, 1.0}, 0.0);
  CHECK(poses_of(cards) == poses_of(others));
  Bodies plates(plate_pieces(), 1, {.ground = 0.0});
  CHECK_THROWS_AS(plates.release(0, {0.0, 0.0, -1.0}, 0.0), samara::ArgumentError);
}

TEST_CASE("a steady wind only carries bodies along, and a body does not know those beside it") {
  const Eigen::Vector3d air(1.5, -0.7, 0.2);
  const BodiesOptions still = {.step = 1e-3, .seed = 4};
  BodiesOptions windy = still;
  windy.wind = steady_wind(air);
  Bodies calm(card_pieces(), 3, still), carried(card_pieces(), 3, windy), alone(card_pieces(), 1, still);
  for (Eigen::Index n = 0; n < 3; ++n) {
    calm.release(n, {0.0, 0.0, 1.0}, 0.4);
    carried.release(n, {0.0, 0.0, 1.0}, 0.4);
  }
  alone.release(0, {0.0, 0.0, 1.0}, 0.4);
  std::size_t events = 0;
  for (int k = 0; k < 10; ++k) {
    for (Bodies* one : {&calm, &carried, &alone}) one->advance(0.05);
    events += calm.events().size();
  }
  REQUIRE(events > 3);
  const std::vector<double> a = poses_of(calm), b = poses_of(carried), c = poses_of(alone);
  for (std::size_t n = 0; n < 3; ++n) {
    for (std::size_t k = 0; k < 3; ++k)
      CHECK(b[3 * n + k] - a[3 * n + k] == Approx(0.5 * air[static_cast<Eigen::Index>(k)]).margin(1e-4));
    for (std::size_t k = 0; k < 4; ++k) CHECK(b[9 + 4 * n + k] == Approx(a[9 + 4 * n + k]).margin(1e-2));
  }
  CHECK(std::equal(c.begin(), c.begin() + 3, a.begin()));
}

TEST_CASE("in air that accelerates evenly a plate falls as if gravity were tilted") {
  const NextPieces pieces(build_database(
      run_sweep(
          parse_sweep_plan("model = \"falling_plate\"\n[fixed]\nsemi_chord = 5e-3\nsemi_thickness = 5e-4\n"
                           "density = 2700\nmu1 = 0\nmu2 = 0.2\n[axes]\n\"theta(0)\" = { from = 0.2, to = "
                           "1.2, count = 8 }\n[run]\nuntil = 3\nstep = 1e-3\nsettle = 0.2\n",
                           "plates.toml"))
          .sweep));
  static constexpr double kPush = 3.0;
  constexpr double kGravity = 9.81, kStart = 0.4, kEnd = 0.5;
  class PushedAir final : public samara::models::AmbientFlow {
   public:
    samara::models::AmbientSample sample(double t, const Eigen::Vector3d&) const override {
      // Across the plane it may do what it likes.
      return {{kPush * t, 7.0 * t, 0.0}, Eigen::Matrix3d::Zero(), {kPush, 7.0, 0.0}};
    }
    double length() const override { return 1.0; }
  };
  Bodies pushed(pieces, 1, {.step = 1e-3, .wind = std::make_shared<PushedAir>()});
  pushed.release(0, std::array{0.0, 0.0, 0.0, kStart, 0.0, 0.0});
  pushed.advance(kEnd);
  std::array<double, 6> state;
  pushed.read_state(0, state);
  // In axes that the air carries along, turned so that what pulls is downward.
  const double tilt = std::atan2(kPush, kGravity);
  std::map<std::string, double> fixed = pieces.database().fixed;
  fixed["g"] = std::hypot(kPush, kGravity);
  fixed["theta(0)"] = kStart + tilt;
  const samara::models::ParametricModel plate(samara::models::find_model("falling_plate"), fixed, {});
  const auto exact = integrate(plate, {}, std::array{0.0, kEnd}, {.relative_tolerance = 1e-11});
  const Eigen::VectorXd still = exact.states.row(1);
  CHECK(state[3] == Approx(still[3] - tilt).margin(1e-5));
  CHECK(
      state[4] ==
      Approx(std::cos(tilt) * still[4] + std::sin(tilt) * still[5] + 0.5 * kPush * kEnd * kEnd).margin(1e-6));
  CHECK(state[5] == Approx(std::cos(tilt) * still[5] - std::sin(tilt) * still[4]).margin(1e-6));
  CHECK(std::abs(still[4]) > 0.01);
}

TEST_CASE("bodies feel a gust at the same instant, whenever they were released") {
  static constexpr double kGust = 0.1005, kPush = 3.0;  // in the midst of a step
  class Gust final : public samara::models::AmbientFlow {
   public:
    samara::models::AmbientSample sample(double t, const Eigen::Vector3d&) const override {
      if (t < kGust) return {};
      return {{kPush * (t - kGust), 0.0, 0.0}, Eigen::Matrix3d::Zero(), {kPush, 0.0, 0.0}};
    }
    double length() const override { return 1.0; }
  };
  constexpr double kStep = 1e-3;
  BodiesOptions options = {.step = kStep, .wind = steady_wind(Eigen::Vector3d::Zero()), .seed = 3};
  Bodies calm(card_pieces(), 3, options);
  options.wind = std::make_shared<Gust>();
  Bodies blown(card_pieces(), 3, options);
  std::vector<double> still(13), moved(13);
  const auto read = [&](Eigen::Index n) {
    calm.read_state(n, still);
    blown.read_state(n, moved);
  };
  const auto release = [&](Eigen::Index n) {
    for (Bodies* bodies : {&calm, &blown}) bodies->release(n, {0.0, 0.0, 1.0}, 0.4);
  };
  std::array<int, 2> felt = {};
  release(0);
  for (int k = 1; k <= 120; ++k) {
    for (Bodies* bodies : {&calm, &blown}) bodies->advance(kStep);
    if (k == 50) release(1);
    for (Eigen::Index n = 0; n < 2; ++n) {
      read(n);
      int& first = felt[static_cast<std::size_t>(n)];
      if (first == 0 && still != moved) first = k;
    }
  }
  CHECK(felt[0] == 102);  // the step that begins with it
  CHECK(felt[1] == felt[0]);
  // What is released now begins in the air that is there now.
  release(2);
  read(2);
  double square = 0.0;
  for (std::size_t k = 7; k < 10; ++k) square += (moved[k] - still[k]) * (moved[k] - still[k]);
  CHECK(std::sqrt(square) == Approx(kPush * (120 * kStep - kGust)).epsilon(1e-9));
}

TEST_CASE("a frame of many bodies allocates nothing, in still air and in wind, in a plane and in space") {
  const BodiesOptions still = {.ground = 0.0, .tries = 4, .seed = 6};
  BodiesOptions windy = still;
  windy.wind = steady_wind({1.0, 0.0, 0.0});
  Bodies plates(plate_pieces(), 50, still), cards(card_pieces(), 50, still), blown(card_pieces(), 50, windy);
  std::vector<double> positions(150), rotations(200);
  std::size_t events = 0;
  for (Bodies* bodies : {&plates, &cards, &blown}) {
    const double dt = bodies == &plates ? 0.5 : 1.0 / 60.0;
    for (Eigen::Index n = 0; n < 50; ++n) bodies->release(n, {0.0, 0.0, 100.0}, 0.0);
    const long calls = allocation_counter::during([&] {
      for (int k = 0; k < 60; ++k) {
        bodies->advance(dt);
        bodies->read_poses(positions, rotations);
        events += bodies->events().size();
      }
    });
    CHECK(calls == 0);
  }
  CHECK(events > 150);
}

TEST_CASE("bodies that cannot be meant are refused in one sentence") {
  const NextPieces& pieces = plate_pieces();
  const auto refusal = [](const auto& call) { return error_text<samara::ArgumentError>(call); };
  CHECK(refusal([&] { Bodies(pieces, 0); }).find("count of bodies") == 0);
  CHECK(refusal([&] { Bodies(pieces, 1, {.step = NAN}); }).find("step of bodies is nan") == 0);
  CHECK(refusal([&] { Bodies(pieces, 1, {.tries = 9}); }) == "tries is 9; 0 to 8 was expected");
  CHECK(refusal([&] {
          Bodies(pieces, 1, {.wind = steady_wind({1.0, 0.0, 0.0})});
        }) ==
        "there is no model \"falling_plate_nd_in_gusts\": bodies of \"falling_plate_nd\" fall in still air "
        "only");
  Bodies bodies(pieces, 2);
  CHECK(bodies.status(1) == BodyStatus::waiting);
  CHECK(refusal([&] { bodies.release(2, {0.0, 0.0, 0.0}, 0.0); }) == "there is no body 2, expected 0 to 1");
  CHECK(refusal([&] { bodies.release(0, {NAN, 0.0, 0.0}, 0.0); }).find("finite") != std::string::npos);
  const std::array few = {0.0, 1.0};
  CHECK(refusal([&] { bodies.release(0, few); }).find("with 2 states") != std::string::npos);
  CHECK(refusal([&] { bodies.advance(-1.0); }).find("time to advance") == 0);
  Bodies cards(card_pieces(), 1);
  CHECK(refusal([&] { cards.release(0, std::vector<double>(13, 0.0)); }) ==
        "the quaternion of a body has the length 0, expected 1");
}
