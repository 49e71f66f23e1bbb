/// Trajectories whose parameters change while they run.
#include "samara/models/batch/stepper.h"

#include <array>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "../allocation_counter.h"
#include "falling_card.h"
#include "samara/base/errors.h"
#include "samara/models/batch/batch.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/following_model.h"

using namespace samara::models;

namespace {

/// C_R from `first` to `second` by a smoothstep over [1, 2], then at rest.
class Ramp final : public ParameterCourse {
 public:
  Ramp(double first, double second) : first_(first), second_(second) {}
  const std::vector<std::string>& followed() const override { return followed_; }
  void values(double t, std::span<const double>, std::span<double> followed) const override {
    const double s = std::clamp(t - 1.0, 0.0, 1.0);
    followed[0] = first_ + (second_ - first_) * s * s * (3.0 - 2.0 * s);
  }

 private:
  std::vector<std::string> followed_ = {"C_R"};
  double first_, second_;
};

constexpr double kFirst = 1.6, kSecond = 2.6;

/// Not from rest, where the angle of attack changes too fast for the order to show.
const std::map<std::string, double> kThrown = {
    {"theta(0)", 0.4}, {"inertia_ratio", 1.1}, {"vx(0)", 0.4}, {"vy(0)", -0.6}};

ParametricModel flutter() {
  return {find_model("falling_plate_nd"), kThrown, {"C_R"}};
}

/// The plate after the ramp and one unit of rest. @param steps per unit of time
Eigen::VectorXd after_ramp(Stepper& plates, int steps) {
  const double h = 1.0 / steps;
  plates.load(0, std::array{kFirst});
  plates.step(h, steps);
  plates.ramp(0, std::array{kSecond}, 1.0);
  plates.step(h, 2 * steps);
  Eigen::VectorXd state(plates.state_count());
  plates.read(0, {state.data(), static_cast<std::size_t>(state.size())});
  return state;
}

}  // namespace

TEST_CASE("lanes whose parameters rest take the steps of a batch, to the bit") {
  const ParametricModel card = falling_card({"C_R", "ux(0)"});
  constexpr Eigen::Index kCount = 11;  // the last pack is not full
  Eigen::MatrixXd points(kCount, 2);
  for (Eigen::Index n = 0; n < kCount; ++n) points.row(n) << 0.9 + 0.05 * double(n), 0.01 * double(n);
  constexpr double kStep = 1.0 / 2048.0;  // sums of it are exact
  const BatchTrajectories batch = integrate_batch(card, points, std::array{256 * kStep}, {.step = kStep});
  Stepper cards(card, {"C_R"}, kCount);
  for (Eigen::Index n = 0; n < kCount; ++n) cards.load(n, std::array{points(n, 0), points(n, 1)});
  for (int frame = 0; frame < 16; ++frame) cards.step(kStep, 16);
  for (Eigen::Index n = 0; n < kCount; ++n) {
    CHECK(cards.time(n) == 256 * kStep);
    CHECK(cards.finite(n));
    for (Eigen::Index i = 0; i < card.state_count(); ++i) CHECK(cards.state(i, n) == batch.states(i, n));
  }
}

TEST_CASE(
    "after a ramp lanes take the steps of a batch at its target, to the bit, and what is driven is set as it "
    "is") {
  const std::array<double, 4> start = {0.3, -0.2, 0.1, 0.4};
  std::vector<std::string> free = {"C_R", "C_T"};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)", "theta(0)"}) free.emplace_back(name);
  const ParametricModel plate(find_model("falling_plate_nd"), {{"inertia_ratio", 1.1}}, free);
  constexpr double kStep = 1.0 / 256.0;
  Stepper lanes(plate, {"C_R"}, 40, {.driven = {"C_T"}});
  Eigen::MatrixXd points(40, 6);
  for (Eigen::Index n = 0; n < 40; ++n) {
    // Pairs of which from + 1 * (to - from) is often not `to`.
    const double from = 1.0 + 0.1 * std::sin(3.7 * double(n)), to = 2.0 + 0.7 * std::sin(5.3 * double(n));
    points.row(n) << to, 0.9 + 0.01 * double(n), start[0], start[1], start[2], start[3];
    lanes.load(n, std::array{from, 1.2, start[0], start[1], start[2], start[3]});
    lanes.ramp(n, std::array{to}, 4 * kStep);
  }
  lanes.step(kStep, 8);
  for (Eigen::Index n = 0; n < 40; ++n) {
    std::array<double, 1> value;
    lanes.read_parameters(n, value);
    CHECK(value[0] == points(n, 0));
    lanes.drive(n, std::array{points(n, 1)});
    std::vector<double> again(6, 0.0);
    std::copy(start.begin(), start.end(), again.begin());  // vx, vy, w, theta
    lanes.set_state(n, 0.0, again);
  }
  lanes.step(kStep, 64);
  const BatchTrajectories batch = integrate_batch(plate, points, std::array{64 * kStep}, {.step = kStep});
  for (Eigen::Index n = 0; n < 40; ++n) {
    for (Eigen::Index i = 0; i < 6; ++i) CHECK(lanes.state(i, n) == batch.states(i, n));
  }
}

TEST_CASE("steps have order two while parameters move and four while they rest, against CVODES") {
  const auto moving = following(find_model("falling_plate_nd"), std::make_shared<Ramp>(kFirst, kSecond));
  const ParametricModel model(moving, kThrown, {});
  const Trajectory exact = integrate(model, {}, std::array{1.0, 3.0}, {.relative_tolerance = 1e-12});
  REQUIRE(exact.is_usable());
  Stepper plates(flutter(), {"C_R"}, 1);
  std::array<double, 3> error;
  for (std::size_t k = 0; k < 3; ++k) {
    error[k] = (after_ramp(plates, 40 << k) - exact.states.row(1).transpose()).norm();
  }
  CHECK(std::log2(error[0] / error[1]) > 1.9);
  CHECK(std::log2(error[1] / error[2]) > 1.9);
  CHECK(error[2] < 1e-5);
  std::array<double, 2> resting;
  for (const int k : {0, 1}) {
    plates.load(0, std::array{kFirst});
    plates.step(1.0 / (20 << k), 20 << k);
    Eigen::VectorXd state(plates.state_count());
    plates.read(0, {state.data(), static_cast<std::size_t>(state.size())});
    resting[static_cast<std::size_t>(k)] = (state - exact.states.row(0).transpose()).norm();
  }
  CHECK(std::log2(resting[0] / resting[1]) > 3.7);
}

TEST_CASE("a ramp that another one interrupts goes on from where it was") {
  Stepper plates(flutter(), {"C_R"}, 2);
  for (const Eigen::Index lane : {0, 1}) plates.load(lane, std::array{1.0});
  plates.ramp(0, std::array{2.0}, 1.0);
  plates.step(0.125, 4);
  std::array<double, 1> value;
  plates.read_parameters(0, value);
  CHECK(value[0] == 1.5);  // the smoothstep at one half
  plates.ramp(0, std::array{0.5}, 0.25);
  plates.read_parameters(0, value);
  CHECK(value[0] == 1.5);
  plates.step(0.125, 1);
  plates.read_parameters(0, value);
  CHECK(value[0] == 1.0);
  plates.step(0.125, 8);
  plates.read_parameters(0, value);
  CHECK(value[0] == 0.5);
  plates.read_parameters(1, value);
  CHECK(value[0] == 1.0);  // its neighbour did not move
}

TEST_CASE("a lane that does not run keeps its state and does not change its neighbours") {
  const ParametricModel card = falling_card({"C_R"});
  Stepper together(card, {"C_R"}, 3), alone(card, {"C_R"}, 1);
  for (const Eigen::Index lane : {0, 1, 2}) together.load(lane, std::array{1.0});
  alone.load(0, std::array{1.0});
  together.set_running(1, false);
  for (Stepper* cards : {&together, &alone}) {
    cards->ramp(0, std::array{1.4}, 0.02);
    cards->step(1e-3, 50);
  }
  CHECK(together.time(1) == 0.0);
  CHECK(together.state(2, 1) == 0.0);
  for (Eigen::Index i = 0; i < card.state_count(); ++i) CHECK(together.state(i, 0) == alone.state(i, 0));
}

TEST_CASE("packs that are stepped one by one take the steps of all, and say which lanes run and are finite") {
  const ParametricModel card = falling_card({"C_R"});
  Stepper together(card, {"C_R"}, 11), one_by_one(card, {"C_R"}, 11);
  for (Stepper* cards : {&together, &one_by_one}) {
    for (Eigen::Index lane = 0; lane < 11; ++lane)
      cards->load(lane, std::array{1.0 + 0.1 * static_cast<double>(lane)});
    cards->ramp(3, std::array{2.0}, 0.01);
    cards->set_running(5, false);
    std::vector<double> state(13);
    cards->read(10, state);
    state[0] = std::numeric_limits<double>::quiet_NaN();
    cards->set_state(10, 0.0, state);
  }
  together.step(1e-3, 20);
  for (Eigen::Index pack = 0; pack < one_by_one.packs(); ++pack) one_by_one.step_pack(pack, 1e-3, 20);
  const auto width = static_cast<Eigen::Index>(one_by_one.width());
  CHECK(one_by_one.packs() == (11 + width - 1) / width);
  for (Eigen::Index lane = 0; lane < 11; ++lane) {
    const Stepper::PackView pack = one_by_one.pack(lane / width);
    const Eigen::Index slot = lane % width;
    CHECK(pack.times[slot] == together.time(lane));
    CHECK((pack.running >> slot & 1) == (lane == 5 ? 0 : 1));
    CHECK((one_by_one.finite_lanes(lane / width) >> slot & 1) == (lane == 10 ? 0 : 1));
    for (Eigen::Index i = 0; i < 13 && lane != 10; ++i)
      CHECK(pack.states[static_cast<std::size_t>(i) * pack.stride + static_cast<std::size_t>(slot)] ==
            together.state(i, lane));
  }
}

TEST_CASE("a default that depends on a steered parameter moves with it") {
  const std::map<std::string, double> fixed = {{"theta(0)", 0.3}, {"inertia_ratio", 1.1}};
  Stepper alone(ParametricModel(find_model("falling_plate_nd"), fixed, {"mu1"}), {"mu1"}, 1);
  Stepper both(ParametricModel(find_model("falling_plate_nd"), fixed, {"mu1", "mu2"}), {"mu1", "mu2"}, 1);
  alone.load(0, std::array{0.1});
  both.load(0, std::array{0.1, 0.1});
  alone.ramp(0, std::array{0.4}, 1.0);
  both.ramp(0, std::array{0.4, 0.4}, 1.0);
  for (Stepper* plates : {&alone, &both}) plates->step(0.01, 300);
  for (Eigen::Index i = 0; i < alone.state_count(); ++i) CHECK(alone.state(i, 0) == both.state(i, 0));
}

TEST_CASE("tangents of steered lanes are the slopes of their states") {
  // The first ramp is interrupted by the second; the direction is the first one's target.
  const auto run = [](Stepper& plates, double target, bool tangents) {
    plates.load(0, std::array{kFirst});
    plates.step(0.02, 20);
    Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(1, plates.directions());
    if (tangents) seeds(0, 1) = 1.0;
    plates.ramp(0, std::array{target}, 1.0, seeds);
    plates.step(0.02, 40);
    plates.ramp(0, std::array{kFirst}, 0.5, Eigen::MatrixXd::Zero(1, plates.directions()));
    plates.step(0.02, 60);
    Eigen::VectorXd state(plates.state_count());
    plates.read(0, {state.data(), static_cast<std::size_t>(state.size())});
    return state;
  };
  Stepper plain(flutter(), {"C_R"}, 1), lanes(flutter(), {"C_R"}, 1, {.tangents = true});
  REQUIRE(lanes.directions() >= 2);
  constexpr double kStep = 1e-5;
  const Eigen::VectorXd slope =
      (run(plain, kSecond + kStep, false) - run(plain, kSecond - kStep, false)) / (2.0 * kStep);
  const Eigen::VectorXd state = run(lanes, kSecond, true);
  CHECK((state - run(plain, kSecond, false)).norm() < 1e-12 * state.norm());
  Eigen::VectorXd tangent(lanes.state_count());
  const auto numbers = std::span(tangent.data(), static_cast<std::size_t>(tangent.size()));
  lanes.read_tangent(0, 1, numbers);
  // Difference quotients: step^2 of third derivatives, eps/step of round-off.
  CHECK((tangent - slope).norm() < 1e-6 * slope.norm());
  lanes.read_tangent(0, 0, numbers);
  CHECK(tangent.norm() == 0.0);
}

TEST_CASE("a lane that is put where another has come goes on like it, with its tangents") {
  Stepper first(flutter(), {"C_R"}, 1, {.tangents = true}), second(flutter(), {"C_R"}, 1, {.tangents = true});
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(1, first.directions());
  seeds(0, 1) = 1.0;
  first.load(0, std::array{kFirst});
  first.ramp(0, std::array{kSecond}, 0.4, seeds);
  first.step(0.02, 30);
  std::vector<double> state(static_cast<std::size_t>(first.state_count())), tangent(state.size());
  first.read(0, state);
  first.read_tangent(0, 1, tangent);
  second.load(0, std::array{kFirst});
  second.set_state(0, first.time(0), state);
  second.set_tangent(0, 1, tangent);
  second.ramp(0, std::array{kSecond}, 0.0, seeds);
  std::vector<double> other = state, other_tangent = tangent;
  for (Stepper* plates : {&first, &second}) plates->step(0.02, 40);
  first.read(0, state);
  second.read(0, other);
  CHECK(state == other);
  first.read_tangent(0, 1, tangent);
  second.read_tangent(0, 1, other_tangent);
  CHECK(tangent == other_tangent);
}

TEST_CASE("steering and stepping do not allocate") {
  const ParametricModel card = falling_card({"C_R"});
  Stepper cards(card, {"C_R"}, 9);
  for (Eigen::Index lane = 0; lane < 9; ++lane) cards.load(lane, std::array{1.0});
  cards.set_running(4, false);
  std::vector<double> state(static_cast<std::size_t>(card.state_count()));
  CHECK(allocation_counter::during([&] {
          for (const double target : {1.2, 0.8}) {
            for (Eigen::Index lane = 0; lane < 9; ++lane) cards.ramp(lane, std::array{target}, 0.005);
            cards.step(1e-3, 10);
            cards.read(3, state);
          }
          cards.set_state(4, 0.0, state);
          cards.load(4, std::array{1.1});
        }) == 0);
}

TEST_CASE("a model without kernels is steered like one with them") {
  const ParametricModel card = falling_card({"C_R"});
  const ParametricModel plain(std::make_shared<PlainModel>(card.shared_model()), card.fixed(), {"C_R"});
  Stepper fast(card, {"C_R"}, 2), slow(plain, {"C_R"}, 2);
  for (Stepper* cards : {&fast, &slow}) {
    for (const Eigen::Index lane : {0, 1}) cards->load(lane, std::array{1.2});
    cards->ramp(1, std::array{0.8}, 0.03);
    cards->step(1e-3, 60);
  }
  for (Eigen::Index i = 0; i < card.state_count(); ++i) {
    CHECK(std::abs(fast.state(i, 1) - slow.state(i, 1)) < 1e-11);
  }
}

TEST_CASE("what cannot be steered is refused by name") {
  CHECK_THROWS_WITH(Stepper(flutter(), {"C_T"}, 1), Catch::Contains("\"C_T\" was to be steered"));
  CHECK_THROWS_WITH(Stepper(flutter(), {"C_R", "C_R"}, 1), Catch::Contains("twice"));
  CHECK_THROWS_WITH(Stepper(flutter(), {"C_R"}, 1, {.driven = {"C_R"}}), Catch::Contains("twice"));
  CHECK_THROWS_WITH(Stepper(flutter(), {"C_R"}, 0), Catch::Contains("lanes is 0"));
}
