#include "samara/identification/capture.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "files.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// 11 frames at 0, 0.1, ..., 1 s, as binary rounding of k * 0.1 has them.
Capture ten_frames_a_second() {
  Capture capture{.id = "drop", .file = {}, .labels = {}, .times = Eigen::VectorXd(11), .channels = {}};
  for (int k = 0; k <= 10; ++k) capture.times[k] = 0.1 * k;
  capture.channels.push_back({"x", "m", capture.times.array().square()});
  return capture;
}

}  // namespace

TEST_CASE("a window holds the frames up to its end, the one on the border included") {
  const Capture capture = ten_frames_a_second();
  // 0.1 * 3 is a little more than 0.3.
  const Capture part = first(capture, 0.3);
  REQUIRE(part.frame_count() == 4);
  CHECK(part.channel("x").values.size() == 4);
  CHECK(part.channel("x").values[3] == capture.channel("x").values[3]);
  CHECK(first(capture, 0.39).frame_count() == 4);
  CHECK(first(capture, 100.0).frame_count() == 11);
  CHECK(capture.frame_count() == 11);
}

TEST_CASE("a window counts from the first frame, wherever that is") {
  Capture capture = ten_frames_a_second();
  capture.times.array() += 5.0;
  CHECK(first(capture, 0.5).frame_count() == 6);
}

TEST_CASE("a window that is not positive or leaves too few frames is refused") {
  const Capture capture = ten_frames_a_second();
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, 0.0); }), Contains("more than 0 s"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, std::nan("")); }),
             Contains("more than 0 s"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, 0.15); }),
             Contains("2 frames of capture \"drop\"") && Contains("at least 3"));
}

TEST_CASE("a quantity that was not measured is named with the nearest one") {
  const Capture capture = ten_frames_a_second();
  CHECK(capture.has("x"));
  CHECK_FALSE(capture.has("X"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { capture.channel("y"); }),
             Contains("capture \"drop\" does not measure \"y\""));
}
