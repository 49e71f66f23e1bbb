// Events: where they lie, of which kind the segments between them are, and what is left of a state without symmetries.
#include <algorithm>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "known_motions.h"
#include "samara/base/errors.h"
#include "samara/motion/events/event_finder.h"
#include "tests/allocation_counter.h"
#include "tests/error_text.h"

using namespace samara::motion;

namespace {

/// Trajectory of a model, with what events need to know of it.
struct Run {
  std::vector<double> times;
  Eigen::MatrixXd states;
  MovingStates moving;
  EventOptions options;

  EventList events() const { return events_of(moving, options, times, states); }
};

Run run_of(const std::string& name, const Values& fixed, double until, double frame, double length,
           double step) {
  const samara::models::ParametricModel model(samara::models::find_model(name), fixed, {});
  Run run = {equal_times(until, frame), {}, MovingStates::of(model.model(), model.parameters({})), {}};
  run.states = integrate_batch(model, Eigen::MatrixXd(1, 0), run.times, {.step = step}).states;
  double square = 0.0;
  for (Eigen::Index k = 0; k < run.states.cols(); ++k)
    square += run.moving.at({run.states.col(k).data(), run.moving.state_count()}).velocity.squaredNorm();
  run.options = event_options(square / static_cast<double>(run.states.cols()), length);
  return run;
}

Run plate_run(double inertia_ratio, double until = 150.0, double frame = 0.02) {
  return run_of("falling_plate_nd", {{"inertia_ratio", inertia_ratio}, {"beta", 0.0}}, until, frame, 2.0,
                0.005);
}

Values card_values(const Eigen::Quaterniond& attitude) {
  return {{"a", 0.035},
          {"b", 0.02},
          {"c", 1e-4},
          {"density", 1200.0},
          {"C_D90", 0.61},
          {"C_D0", 0.05},
          {"C_T", 1.81},
          {"C_R", 1.21},
          {"C_w", 2.0},
          {"qw(0)", attitude.w()},
          {"qx(0)", attitude.x()},
          {"qy(0)", attitude.y()},
          {"qz(0)", attitude.z()}};
}

Eigen::Quaterniond oblique() {
  const Eigen::Vector3d axis(std::cos(0.6), std::sin(0.6), 0.0);
  return Eigen::Quaterniond(Eigen::AngleAxisd(0.3, axis));
}

Run card_run(const Eigen::Quaterniond& attitude) {
  return run_of("immersed_body", card_values(attitude), 2.0, 2e-3, 0.07, 5e-4);
}

std::vector<EventKind> kinds_of(const EventList& list) {
  std::vector<EventKind> kinds;
  for (const Event& event : list.events) kinds.push_back(event.kind);
  return kinds;
}

}  // namespace

TEST_CASE(
    "events of a fluttering plate lie half its period apart and change their sign, and a tumbling one only "
    "turns one way") {
  // Model sheet, section 3: periods by I*.
  for (const auto& [inertia_ratio, period] : {std::pair(0.5, 6.37), std::pair(1.1, 15.957)}) {
    const EventList list = plate_run(inertia_ratio).events();
    const std::size_t count = list.events.size();
    REQUIRE(count > 8);
    for (std::size_t k = count - 4; k < count; ++k) {
      CHECK(list.events[k].duration == Approx(period / 2).epsilon(2e-3));
      CHECK(list.events[k].turn == Approx(-list.events[k - 1].turn).epsilon(1e-3));
    }
  }
  CHECK(to_string(plate_run(0.5).events().events.back().kind).substr(0, 5) == "swing");
  const EventList tumbling = plate_run(1.4).events();
  for (std::size_t k = tumbling.events.size() - 4; k < tumbling.events.size(); ++k) {
    CHECK(tumbling.events[k].kind == EventKind::turn_minus);
    // 7.79 turns in 100 a/U; a half turn each.
    CHECK(tumbling.events[k].duration == Approx(100.0 / (2 * 7.79)).epsilon(2e-3));
    CHECK(std::abs(tumbling.events[k].turn) == Approx(std::numbers::pi).epsilon(1e-3));
  }
}

TEST_CASE(
    "events are roots of v . a, to third order in the step, and their states to the order of the cubic") {
  const auto event_at = [](double frame) {
    const EventList list = plate_run(1.1, 12.0, frame).events();
    REQUIRE(list.events.size() >= 1);
    return std::pair(list.events[0].t, Eigen::VectorXd(list.states.col(0)));
  };
  const auto exact = event_at(0.005), coarse = event_at(0.08), fine = event_at(0.04);
  CHECK(std::log2(std::abs(coarse.first - exact.first) / std::abs(fine.first - exact.first)) > 2.5);
  CHECK((fine.second - exact.second).norm() < 1e-4);
  // d|v|^2/dt of the model itself at that state.
  const samara::models::ParametricModel plate(samara::models::find_model("falling_plate_nd"),
                                              {{"inertia_ratio", 1.1}, {"beta", 0.0}}, {});
  auto workspace = plate.make_workspace();
  std::vector<double> x(exact.second.begin(), exact.second.end()), rate(6);
  plate.rhs(0.0, x, {}, rate, workspace);
  CHECK(std::abs(x[0] * rate[0] + x[1] * rate[1]) < 1e-4);
}

TEST_CASE(
    "events and kinds do not know the yaw or the symmetric copy of an attitude, and a mirror changes no "
    "length") {
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(1.1, Eigen::Vector3d::UnitZ()));
  const Run plain = card_run(oblique());
  const EventList events = plain.events();
  REQUIRE(events.events.size() > 6);
  const EventList turned = card_run(yaw * oblique()).events();
  REQUIRE(turned.events.size() == events.events.size());
  CHECK(kinds_of(turned) == kinds_of(events));
  for (std::size_t k = 0; k < events.events.size(); ++k)
    CHECK((turned.events[k].displacement - yaw * events.events[k].displacement).norm() < 1e-6);
  REQUIRE(plain.moving.symmetry() == BodySymmetry::ellipsoid);
  const std::array axes = {Eigen::Vector3d::UnitX().eval(), Eigen::Vector3d::UnitY().eval(),
                           Eigen::Vector3d::UnitZ().eval()};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Quaterniond half(Eigen::AngleAxisd(std::numbers::pi, axes[static_cast<std::size_t>(k)]));
    const Run copy = card_run(oblique() * half);
    CHECK(kinds_of(copy.events()) == kinds_of(events));
    for (const Eigen::Index frame : {0, 200, 399}) {
      Eigen::VectorXd here(9), there(9);
      plain.moving.reduce({plain.states.col(frame).data(), 13}, {here.data(), 9});
      copy.moving.reduce({copy.states.col(frame).data(), 13}, {there.data(), 9});
      plain.moving.turn_to_copy(k + 1, {here.data(), 9});
      CHECK((here - there).norm() < 1e-6 * (1.0 + here.norm()));
    }
  }
}

TEST_CASE(
    "a plate turned by pi has the copy of its reduced state, and a disc one that no turn about its normal "
    "changes") {
  const Run one = plate_run(1.1, 5.0);
  const Run other = run_of("falling_plate_nd",
                           {{"inertia_ratio", 1.1},
                            {"beta", 0.0},
                            {"theta(0)", 0.4 + std::numbers::pi},
                            {"vx(0)", -0.001},
                            {"vy(0)", -0.001}},
                           5.0, 0.02, 2.0, 0.005);
  Eigen::VectorXd here(5), there(5);
  one.moving.reduce({one.states.col(200).data(), 6}, {here.data(), 5});
  other.moving.reduce({other.states.col(200).data(), 6}, {there.data(), 5});
  one.moving.turn_to_copy(1, {here.data(), 5});
  CHECK((here - there).norm() < 1e-9);

  Values values = card_values(oblique());
  values["b"] = 0.035;
  const auto disc = [&](double turn) {
    const Eigen::Quaterniond attitude =
        oblique() * Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
    Values turned = values;
    turned["qw(0)"] = attitude.w();
    turned["qx(0)"] = attitude.x();
    turned["qy(0)"] = attitude.y();
    turned["qz(0)"] = attitude.z();
    const Run run = run_of("immersed_body", turned, 0.4, 2e-3, 0.07, 5e-4);
    REQUIRE(run.moving.symmetry() == BodySymmetry::disc);
    Eigen::VectorXd reduced(9);
    run.moving.reduce({run.states.col(150).data(), 13}, {reduced.data(), 9});
    return reduced;
  };
  CHECK((disc(0.0) - disc(0.7)).norm() < 1e-6 * disc(0.0).norm());
}

TEST_CASE("steady descent is cut every two lengths of fall, and a finder allocates nothing once it is made") {
  const Run steady =
      run_of("falling_plate_nd",
             {{"inertia_ratio", 0.5}, {"beta", 0.0}, {"theta(0)", 0.0}, {"vx(0)", 0.0}, {"w(0)", 0.0}}, 60.0,
             0.05, 2.0, 0.05);
  const EventList list = steady.events();
  REQUIRE(list.events.size() > 10);
  for (std::size_t k = list.events.size() - 5; k < list.events.size(); ++k)
    CHECK(list.events[k].duration == Approx(steady.options.steady).margin(0.051));
  CHECK(list.events.back().is_steady);
  CHECK_FALSE(plate_run(1.1, 60.0).events().events.back().is_steady);

  const Run run = plate_run(1.1, 60.0);
  EventFinder finder(run.moving, run.options), other(run.moving, run.options);
  std::size_t events = 0;
  const long calls = allocation_counter::during([&] {
    for (std::size_t k = 0; k < run.times.size(); ++k) {
      events += finder.see(run.times[k], {run.states.col(static_cast<Eigen::Index>(k)).data(), 6});
      if (k == 1000) other = finder;
    }
  });
  CHECK(calls == 0);
  CHECK(events == run.events().events.size());
}

namespace {

std::vector<double> numbers_of(const Event& event, std::span<const double> state) {
  std::vector<double> numbers = {event.t, event.duration, event.turn, static_cast<double>(event.kind)};
  numbers.insert(numbers.end(), event.displacement.begin(), event.displacement.end());
  numbers.insert(numbers.end(), state.begin(), state.end());
  return numbers;
}

/// Sees the columns of a run, from different ones on, in lanes of packs; lane `copied` goes on as lane 0 from `from`
/// on.
std::vector<std::vector<double>> seen_in_packs(const Run& run, std::size_t width, std::size_t lanes,
                                               std::size_t copied, std::size_t from) {
  EventLanes finders(run.moving, run.options, static_cast<Eigen::Index>(lanes), width);
  std::vector<std::vector<double>> found(lanes);
  const std::size_t states = run.moving.state_count(), packs = (lanes + width - 1) / width;
  std::vector<double> rows(states * width), times(width);
  const auto column = [&](std::size_t k) {
    return std::span(run.states.col(static_cast<Eigen::Index>(k)).data(), states);
  };
  for (std::size_t k = 0; k + lanes < run.times.size(); ++k) {
    for (std::size_t pack = 0; pack < packs; ++pack) {
      for (std::size_t slot = 0; slot < width; ++slot) {
        const std::size_t lane = pack * width + slot, ahead = lane == copied && k > from ? 0 : lane;
        const std::size_t at =
            std::min(k + ahead, run.times.size() - 1);  // lanes that there are not see the last
        times[slot] = run.times[at];
        for (std::size_t i = 0; i < states; ++i) rows[i * width + slot] = column(at)[i];
      }
      const std::uint64_t used = lanes - pack * width >= width ? ~std::uint64_t{0} >> (64 - width)
                                                               : (std::uint64_t{1} << (lanes % width)) - 1;
      const std::uint64_t events =
          k == 0 ? 0 : finders.see(static_cast<Eigen::Index>(pack), times.data(), {rows.data(), width}, used);
      for (std::size_t slot = 0; slot < width && pack * width + slot < lanes; ++slot) {
        const std::size_t lane = pack * width + slot;
        const auto index = static_cast<Eigen::Index>(lane);
        if (k == 0) finders.begin(index, times[slot], column(lane));
        if ((events >> slot & 1) == 0) continue;
        const std::vector<double> numbers = numbers_of(finders.event(index), finders.state(index));
        found[lane].insert(found[lane].end(), numbers.begin(), numbers.end());
      }
    }
    if (k != from) continue;
    finders.copy(static_cast<Eigen::Index>(copied), finders, 0);
    found[copied] = found[0];
  }
  return found;
}

}  // namespace

TEST_CASE("motions have the same events alone and in packs of any width, to the bit") {
  for (const Run& run : {plate_run(1.1, 60.0, 0.05), card_run(oblique())}) {
    constexpr std::size_t kLanes = 11;  // the last pack is not full
    const auto alone = seen_in_packs(run, 1, kLanes, kLanes - 1, 200);
    REQUIRE(alone[0].size() > 50);
    for (const std::size_t width : {2, 4, 8, 13})
      CHECK(seen_in_packs(run, width, kLanes, 9, 200)[3] == alone[3]);
    const auto wide = seen_in_packs(run, 8, kLanes, kLanes - 1, 200);
    CHECK(wide == alone);
    // What goes on as another lane does sees what that sees.
    CHECK(wide[kLanes - 1] == wide[0]);
    EventFinder finder(run.moving, run.options);
    std::vector<double> found;
    for (std::size_t k = 3; k + kLanes < run.times.size() + 3; ++k) {
      const std::span<const double> state(run.states.col(static_cast<Eigen::Index>(k)).data(),
                                          run.moving.state_count());
      if (!finder.see(run.times[k], state)) continue;
      const std::vector<double> numbers = numbers_of(finder.event(), finder.state());
      found.insert(found.end(), numbers.begin(), numbers.end());
    }
    CHECK(found == alone[3]);
  }
}

TEST_CASE("a normal that is the opposite one in the next frame leaves the turns finite") {
  const MovingStates moving = MovingStates::of_record(true);
  const std::vector<double> times = equal_times(12.0, 0.1);
  Eigen::MatrixXd states = Eigen::MatrixXd::Zero(9, static_cast<Eigen::Index>(times.size()));
  for (Eigen::Index k = 0; k < states.cols(); ++k) {
    states(3, k) = 2.0 + std::cos(times[static_cast<std::size_t>(k)]);
    states(8, k) = k < 7 ? 1.0 : -1.0;
  }
  const EventList list = events_of(moving, {.mean_square_speed = 4.5}, times, states);
  REQUIRE(list.events.size() == 2);
  for (const Event& event : list.events) CHECK(event.turn == 0.0);
}

TEST_CASE("turns are those of the axis, however far a body turns in a frame, past a quarter as well") {
  // A spin about the horizontal axis along -y, and a speed with minima 1 s apart.
  const samara::models::ParametricModel card(samara::models::find_model("immersed_body"),
                                             card_values(Eigen::Quaterniond::Identity()), {});
  const MovingStates moving = MovingStates::of(card.model(), card.parameters({}));
  const StateLayout& at = moving.layout();
  for (const double per_frame : {0.01, 0.3, 1.2, 2.5}) {
    constexpr double kFrame = 0.05;
    const std::vector<double> times = equal_times(6.0, kFrame);
    Eigen::MatrixXd states = Eigen::MatrixXd::Zero(13, static_cast<Eigen::Index>(times.size()));
    for (Eigen::Index k = 0; k < states.cols(); ++k) {
      const double t = times[static_cast<std::size_t>(k)], angle = per_frame * t / kFrame;
      states(static_cast<Eigen::Index>(at.position[0]), k) = t;
      states(static_cast<Eigen::Index>(at.attitude[0]), k) = std::cos(0.5 * angle);
      states(static_cast<Eigen::Index>(at.attitude[2]), k) = -std::sin(0.5 * angle);
      states(static_cast<Eigen::Index>(at.velocity[0]), k) = 2.0 - std::cos(2.0 * std::numbers::pi * t);
    }
    const EventList list = events_of(moving, {.mean_square_speed = 4.5}, times, states);
    REQUIRE(list.events.size() >= 4);
    for (const Event& event : list.events) {
      if (event.is_first) continue;
      CHECK(event.duration == Approx(1.0).epsilon(1e-3));
      CHECK(event.turn == Approx(per_frame * event.duration / kFrame).epsilon(1e-6));
    }
  }
}

TEST_CASE("a noisy record has the events of the clean motion") {
  const MotionRecord clean = plate({{"inertia_ratio", 1.1}}, 120.0, 0.1);
  const EventList exact = plate_run(1.1, 120.0).events(), seen = events_of(noisy(clean, 0.02, 0.05, 3));
  REQUIRE(seen.events.size() >= exact.events.size() - 1);
  const std::size_t offset = exact.events.size() - seen.events.size();
  for (std::size_t k = 3; k < seen.events.size(); ++k) {
    CHECK(seen.events[k].t == Approx(exact.events[k + offset].t).margin(0.15));
    CHECK(seen.events[k].kind == exact.events[k + offset].kind);
  }
  CHECK(error_text<samara::ArgumentError>([&] {
          events_of(positions_only(clean));
        }).find("has no attitude") != std::string::npos);
}

TEST_CASE("a normal that only precesses about the vertical makes no turn, whatever its tilt") {
  // In a circle, with minima of the speed 1 s apart; what is swept about the vertical is 2 pi sin^2(tilt) a revolution.
  for (const double tilt : {0.3, 0.25 * std::numbers::pi, 1.2, 0.5 * std::numbers::pi}) {
    for (const double revolutions : {-1.0, -0.5, 0.2, 0.5, 1.0, 2.3}) {
      const double rate = 2.0 * std::numbers::pi * revolutions;
      const std::vector<double> times = equal_times(6.0, 0.01);
      Eigen::MatrixXd states = Eigen::MatrixXd::Zero(9, static_cast<Eigen::Index>(times.size()));
      for (Eigen::Index k = 0; k < states.cols(); ++k) {
        const double t = times[static_cast<std::size_t>(k)];
        states.col(k).head<2>() << std::cos(rate * t), std::sin(rate * t);
        states(3, k) = 2.0 - std::cos(2.0 * std::numbers::pi * t);
        states.col(k).tail<3>() << std::sin(tilt) * std::cos(rate * t), std::sin(tilt) * std::sin(rate * t),
            std::cos(tilt);
      }
      const EventList list =
          events_of(MovingStates::of_record(false), {.mean_square_speed = 4.5}, times, states);
      REQUIRE(list.events.size() >= 4);
      // n x dn has the horizontal part -sin cos (cos, sin) d(angle): of an arc its chord is left.
      const double chord = std::abs(std::sin(2.0 * tilt) * std::sin(0.5 * rate));
      for (const Event& event : list.events) {
        if (event.is_first) continue;
        CHECK(std::abs(event.turn) == Approx(chord).margin(2e-3));
        CHECK(to_string(event.kind).substr(0, 5) == "swing");
      }
    }
  }
}

TEST_CASE("what cannot have events or kinds is refused by name") {
  CHECK(error_text<samara::ArgumentError>([] { event_kind_of("glide"); }) ==
        "\"glide\" is no kind of event, expected one of swing-, swing+, turn-, turn+");
  CHECK(event_kind_of("turn+") == EventKind::turn_plus);
  CHECK(error_text<samara::ArgumentError>([] { event_options(0.0, 2.0); }).find("mean square speed") == 0);
  const auto fall = samara::models::find_model("vertical_fall");
  CHECK(error_text<samara::ArgumentError>([&] {
          MovingStates(fall->info(), BodySymmetry::none);
        }).find("model \"vertical_fall\" has no states") == 0);
  const auto plate = samara::models::find_model("falling_plate_nd");
  CHECK(error_text<samara::ArgumentError>([&] {
          MovingStates(plate->info(), BodySymmetry::disc);
        }).find("moves in a plane") != std::string::npos);
}
