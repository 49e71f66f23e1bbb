#include "samara/identification/captures/capture_suspicions.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/captures/capture_file.h"
#include "synthetic.h"

using namespace samara::identification;
using Eigen::Index;
using Sentences = std::vector<std::string>;

namespace {

/// A fall from rest with noise of 1 mm, 100 Hz.
Capture fall(int count) {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal(0.0, 1e-3);
  Capture capture;
  capture.id = "fall";
  capture.times = Eigen::VectorXd::LinSpaced(count, 0.0, 0.01 * (count - 1));
  Eigen::VectorXd z(count);
  for (Index k = 0; k < count; ++k)
    z[k] = 2.0 - 0.5 * 9.81 * capture.times[k] * capture.times[k] + normal(random);
  capture.channels = {{"z", "m", z}};
  return capture;
}

}  // namespace

TEST_CASE("an ordinary capture raises no suspicion") {
  CHECK(suspicions(fall(50)).empty());
  for (const Capture& coin : read_captures(SAMARA_EXAMPLES_DIR "/coin/coin.toml")) {
    CHECK(suspicions(coin) == Sentences{});
  }
}

TEST_CASE("a stray row a lifetime later is a gap of so many frames") {
  Capture capture = fall(50);
  capture.times[49] = 1e9;
  const Sentences found = suspicions(capture);
  const auto said = std::ranges::find_if(
      found, [](const std::string& one) { return one.ends_with("in 1 gaps of the times"); });
  REQUIRE(said != found.end());
  CHECK(std::stod(*said) == Approx(1e11).epsilon(1e-6));
}

TEST_CASE("bad captures are suspected for what is wrong with them") {
  Capture capture = fall(50);
  Eigen::VectorXd& z = capture.channels[0].values;

  SECTION("one frame") {
    CHECK(suspicions(fall(1)) == Sentences{"it has 1 frame"});
  }
  SECTION("constant positions") {
    z.setConstant(0.7);
    CHECK(suspicions(capture) == Sentences{"z never changes over 50 frames"});
  }
  SECTION("rows out of order, with their times") {
    std::mt19937_64 random(2);
    std::shuffle(capture.times.begin(), capture.times.end(), random);
    const Sentences found = suspicions(capture);
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0], Catch::EndsWith("of 50 times do not increase: are the rows out of order?"));
  }
  SECTION("rows out of order under times in order") {
    std::mt19937_64 random(2);
    std::shuffle(z.begin(), z.end(), random);
    CHECK_THAT(suspicions(capture).front(), Catch::EndsWith("the frame before: are the rows out of order?"));
  }
  SECTION("millimetres taken for metres") {
    z *= 1000.0;
    const Sentences found = suspicions(capture);
    REQUIRE(found.size() == 2);
    CHECK_THAT(found[0], Catch::StartsWith("z jumps by"));
    CHECK_THAT(found[1], Catch::Contains("gravity times 10^3"));
  }
  SECTION("centimetres taken for metres") {
    z *= 100.0;
    const Sentences found = suspicions(capture);
    REQUIRE_FALSE(found.empty());
    CHECK_THAT(found.back(), Catch::Contains("gravity times 10^2"));
  }
  SECTION("metres taken for millimetres") {
    z *= 0.001;
    const Sentences found = suspicions(capture);
    REQUIRE(found.size() == 1);
    CHECK_THAT(found[0], Catch::Contains("gravity times 10^-3"));
    // Of a body in balance, such as a blimp, that is no sign of another unit.
    CHECK(suspicions(capture, false).empty());
  }
  SECTION("milliseconds taken for seconds") {
    capture.times *= 1000.0;
    CHECK(suspicions(capture).front() == "frames are 10 s apart: are times in another unit?");
  }
  SECTION("one frame far away") {
    z[20] = 30.0;
    const Sentences found = suspicions(capture);
    CHECK(std::ranges::any_of(found, [](const std::string& s) { return s.starts_with("z jumps by 28"); }));
  }
  SECTION("a track that goes on with another body") {
    z.tail(20).array() += 0.4;
    CHECK(suspicions(capture).size() == 1);
    CHECK_THAT(suspicions(capture).front(), Catch::StartsWith("the position moves at 37"));
    CHECK_THAT(suspicions(capture).front(), Catch::EndsWith("another body, or a wrong frame?"));
  }
  SECTION("missing and infinite values") {
    z.segment(10, 30).setConstant(NAN);
    z[5] = INFINITY;
    CHECK(suspicions(capture) == Sentences{"some values of z are infinite", "z is seen in 19 of 50 frames"});
  }
  SECTION("dropped frames") {
    capture.times.tail(25).array() += 0.05;
    CHECK(suspicions(capture).front() == "5 frames are missing, in 1 gaps of the times");
  }
  SECTION("degrees taken for radians") {
    capture.channels.push_back({"theta", "1", 900.0 * capture.times});
    CHECK(suspicions(capture) == Sentences{"theta turns by 9 rad from frame to frame: are these degrees?"});
  }
  SECTION("quaternions that are none") {
    for (const std::string& q : kQuaternionChannels)
      capture.channels.push_back({q, "1", 0.6 + 0.01 * capture.times.array()});
    CHECK(suspicions(capture) == Sentences{"50 of 50 quaternions are not of unit length"});
  }
}

TEST_CASE("a fall that nears its final speed is not taken for one in another unit") {
  // Whatever the speed at first, the acceleration fades: at some time it is a hundredth of gravity, or a thousandth.
  for (const double C_D : {0.7, 1.1, 1.3, 1.7}) {
    for (double speed = -0.2; speed < 0.75; speed += 0.05) {
      CAPTURE(C_D, speed);
      CHECK(suspicions(coin_capture("coin", C_D, speed, 0.0)) == Sentences{});
    }
  }
}

TEST_CASE("a long recording is suspected by some of its frames") {
  // With all of them in spans of a quarter of the recording this would take minutes.
  Capture capture = fall(20001);
  capture.times *= 1e-3;
  capture.channels[0].values = 1000.0 * (2.0 - 0.5 * 9.81 * capture.times.array().square()).matrix();
  const Sentences found = suspicions(capture);
  CHECK(std::ranges::count_if(found, [](const std::string& sentence) {
          return sentence.starts_with("positions accelerate by 9.81e+03 m/s^2, gravity times 10^3");
        }) == 1);
}

TEST_CASE("a channel of another length than its times is refused, not suspected") {
  Capture capture = fall(50);
  capture.times.conservativeResize(40);
  CHECK_THROWS_AS(suspicions(capture), samara::ArgumentError);
}
