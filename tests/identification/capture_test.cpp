#include "samara/identification/captures/capture.h"

#include <cmath>
#include <memory>

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

TEST_CASE("a span holds the frames up to its end, the one on the border included") {
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

TEST_CASE("what was known of a cleaned capture are as many frames, however far cleaning moved the clock") {
  const auto clean = [](Capture capture) {
    for (int k = 1; k < capture.frame_count(); ++k) capture.times[k] = capture.times[0] + 0.1 * k;
    return capture;
  };
  Capture late_from_five = ten_frames_a_second(), late_first = late_from_five;
  late_from_five.times.tail(6).array() += 0.1;
  late_first.times[0] += 0.07;
  for (const Capture& raw : {late_from_five, late_first}) {
    Capture capture = clean(raw);
    capture.before_cleaning =
        std::make_shared<const BeforeCleaning>(BeforeCleaning{raw, clean, capture.times});
    const Capture known = known_at(capture, 0.7);
    REQUIRE(known.frame_count() == 8);
    CHECK(known.times.isApprox(capture.times.head(8)));
    const Capture later = spans(capture, 0.6, 0.3).at(1);
    const Eigen::VectorXd seen = capture.channel("x").values.segment(3, 4);
    CHECK(known_at(later, 0.3).channel("x").values == seen);
  }
}

TEST_CASE("a span counts from the first frame, wherever that is") {
  Capture capture = ten_frames_a_second();
  capture.times.array() += 5.0;
  CHECK(first(capture, 0.5).frame_count() == 6);
}

TEST_CASE("a span that is not positive or leaves too few frames is refused") {
  const Capture capture = ten_frames_a_second();
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, 0.0); }), Contains("more than 0 s"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, std::nan("")); }),
             Contains("more than 0 s"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { first(capture, 0.15); }),
             Contains("2 frames of capture \"drop\"") && Contains("at least 3"));
}

TEST_CASE("spans of a capture begin a stride apart, count from their first frames, and lie within it") {
  Capture capture = ten_frames_a_second();
  capture.labels["drop"] = "7";
  capture.times.array() += 2.0;
  const std::vector<Capture> parts = spans(capture, 0.3, 0.4);
  // From 0, 0.4; from 0.8 on there is no span of 0.3 s.
  REQUIRE(parts.size() == 2);
  for (const Capture& part : parts) {
    CHECK(part.frame_count() == 4);
    CHECK(part.times[0] == 0.0);
    CHECK(part.motion == "drop");
    CHECK(part.labels == capture.labels);
  }
  CHECK(parts[1].id == "drop from 2.4 s");
  CHECK(parts[1].channel("x").values[0] == capture.channel("x").values[4]);
  // A stride between frames goes to the next one, and spans may overlap.
  CHECK(spans(capture, 0.3, 0.15).size() == 4);
  // Most of a span must be seen.
  capture.channels[0].values.segment(4, 3).setConstant(std::nan(""));
  CHECK(spans(capture, 0.3, 0.4).size() == 1);
  CHECK(spans(capture, 0.3, 0.4, {"y"}).size() == 2);
  CHECK_THROWS_AS(spans(capture, 0.3, 0.0), samara::ArgumentError);
  CHECK_THROWS_AS(spans(capture, std::nan(""), 0.1), samara::ArgumentError);
}

TEST_CASE("a quantity that was not measured is named with the nearest one") {
  const Capture capture = ten_frames_a_second();
  CHECK(capture.has("x"));
  CHECK_FALSE(capture.has("X"));
  CHECK_THAT(error_of<samara::ArgumentError>([&] { capture.channel("y"); }),
             Contains("capture \"drop\" does not measure \"y\""));
}

TEST_CASE("spans have ids of their own, however long a recording has run") {
  Capture capture = ten_frames_a_second();
  capture.times.array() += 12345.0;
  const std::vector<Capture> parts = spans(capture, 0.3, 0.4);
  REQUIRE(parts.size() == 2);
  CHECK(parts[0].id == "drop from 12345 s");
  CHECK(parts[1].id == "drop from 12345.4 s");
  CHECK(span_id("drop", 0.1 + 0.2) == "drop from 0.3 s");
}

TEST_CASE("a channel that has not a value for each frame is refused before it is cut") {
  Capture capture = ten_frames_a_second();
  capture.channels[0].values.conservativeResize(10);
  const std::string expected =
      "capture \"drop\" has 10 values of \"x\"; one for each of its 11 frames was expected";
  CHECK(error_of<samara::ArgumentError>([&] { first(capture, 0.5); }) == expected);
  CHECK(error_of<samara::ArgumentError>([&] { spans(capture, 0.3, 0.4); }) == expected);
  capture.file = "drop.csv";
  CHECK_THAT(error_of<samara::InputError>([&] { first(capture, 0.5); }), Contains("drop.csv: " + expected));
}
