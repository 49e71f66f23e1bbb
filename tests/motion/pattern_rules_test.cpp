// The rule: known motions, and that it says so when it cannot know.
#include "samara/motion/patterns/pattern_rules.h"

#include <array>
#include <vector>

#include <catch2/catch.hpp>

#include "known_motions.h"
#include "samara/models/bodies/kinematic_paths.h"
#include "tests/error_text.h"

using namespace samara::motion;

namespace {

Pattern pattern(const MotionRecord& record) {
  const PatternLabel answer = label(features(record));
  INFO(answer.why);
  return answer.pattern;
}

/// Swings of `amplitude` rad at 1 rad per unit of time about broadside, sinking at 1 and swaying along.
MotionRecord swinging(double amplitude, double until) {
  MotionRecord record;
  record.times = Eigen::VectorXd::LinSpaced(static_cast<Eigen::Index>(until * 10.0) + 1, 0.0, until);
  record.angles = amplitude * record.times.array().sin();
  record.positions.setZero(record.frame_count(), 3);
  record.positions.col(0) = amplitude * record.times.array().cos();
  record.positions.col(2) = -record.times;
  record.length = 2.0;
  record.position_noise = record.angle_noise = 0.0;
  return record;
}

struct Row {
  double inertia_ratio;
  Pattern pattern;
};
/// Model sheet, section 3.
constexpr std::array kRegimes = {Row{0.5, Pattern::zigzag},       Row{1.1, Pattern::zigzag},
                                 Row{1.3, Pattern::autorotation}, Row{1.45, Pattern::autorotation},
                                 Row{1.5, Pattern::mixed},        Row{2.1, Pattern::chaotic},
                                 Row{3.0, Pattern::zigzag}};

}  // namespace

TEST_CASE("the regimes of the thin plate get their names, with attitude in a plane and in space") {
  for (const Row& row : kRegimes) {
    INFO("I* " << row.inertia_ratio);
    const MotionRecord record = plate({{"inertia_ratio", row.inertia_ratio}}, 400.0);
    CHECK(pattern(record) == row.pattern);
    CHECK(pattern(in_space(record)) == row.pattern);
  }
  CHECK(pattern(plate({{"mu1", 2.0}, {"C_R", 1.2}})) == Pattern::steady);
}

TEST_CASE(
    "labels stay the same under yaw, mirror, units, time shift, the other side, and from 60 to 240 frames a "
    "second") {
  struct Card {
    double C_D90, C_T, C_R;
    Pattern pattern;
  };
  // Figure 5.6 of the dissertation, as the model falls: released about body x.
  for (const Card& set :
       {Card{1.81, 0.31, 0.31, Pattern::zigzag}, Card{0.31, 0.91, 0.61, Pattern::zigzag},
        Card{0.61, 1.81, 1.21, Pattern::chaotic}, Card{0.61, 2.71, 0.91, Pattern::autorotation}}) {
    INFO("C_D90 " << set.C_D90 << ", C_T " << set.C_T);
    const MotionRecord record = card(set.C_D90, set.C_T, set.C_R, 0.0, 3.0, 1.0 / 240.0);
    CHECK(pattern(record) == set.pattern);
    CHECK(pattern(turned(record, 0.9)) == set.pattern);
    CHECK(pattern(mirrored(turned(record, 2.2))) == set.pattern);
    MotionRecord other = record;
    other.normals *= -1.0;
    other.positions *= 100.0;
    other.length *= 100.0;
    other.times = other.times.array() + 3.0;
    CHECK(pattern(other) == set.pattern);
    CHECK(pattern(card(set.C_D90, set.C_T, set.C_R, 0.0, 3.0, 1.0 / 120.0)) == set.pattern);
  }
}

TEST_CASE("released aslant the card neither autorotates nor zigzags: labels hold for a release") {
  CHECK(pattern(card(0.61, 2.71, 0.91, 0.6, 3.0)) == Pattern::chaotic);
  CHECK(pattern(card(0.61, 2.71, 0.91, 0.0, 3.0)) == Pattern::autorotation);
}

TEST_CASE("drawn spirals and helices are told from places alone, either way round and adrift") {
  for (const double sense : {1.0, -1.0}) {
    for (const double modulation : {0.0, 0.4}) {
      const samara::models::RosePath path = {.descent_speed = 1.0,
                                             .amplitude_x = 1.0,
                                             .amplitude_y = 1.0,
                                             .modulation = modulation,
                                             .lobes = 4.0,
                                             .angular_frequency = 0.8};
      MotionRecord record;
      record.times = Eigen::VectorXd::LinSpaced(241, 0.0, 60.0);
      record.positions.resize(241, 3);
      for (Eigen::Index k = 0; k < 241; ++k) {
        const Eigen::Vector3d p = at(path, record.times[k]).position;
        record.positions.row(k) << p.x() + 0.1 * record.times[k], sense * p.y(), p.z();
      }
      record.length = 2.0;
      CHECK(pattern(noisy(record, 0.02, 0.0, 11)) == (modulation > 0.0 ? Pattern::helix : Pattern::spiral));
    }
  }
}

TEST_CASE("zigzag, autorotation and steady descent are told from places alone") {
  CHECK(pattern(positions_only(plate({{"inertia_ratio", 0.8}}))) == Pattern::zigzag);
  CHECK(pattern(positions_only(turned(in_space(plate({{"inertia_ratio", 1.35}})), 0.7))) ==
        Pattern::autorotation);
  CHECK(pattern(positions_only(plate({{"mu1", 2.0}, {"C_R", 1.2}}))) == Pattern::steady);
}

TEST_CASE("noise that hides the answer is unresolved, not chaotic, and less of it is not") {
  const MotionRecord steady = plate({{"mu1", 2.0}, {"C_R", 1.2}}, 60.0);
  CHECK(pattern(noisy(steady, 0.02, 0.05, 1)) == Pattern::steady);
  const MotionRecord coarse = plate({{"mu1", 2.0}, {"C_R", 1.2}}, 12.0, 0.5);
  const PatternLabel hidden = label(features(noisy(coarse, 0.02, 0.4, 2)));
  CHECK(hidden.pattern == Pattern::unresolved);
  CHECK(hidden.why.find("noise") != std::string::npos);
  const PatternLabel drowned = label(features(noisy(positions_only(coarse), 0.5, 0.0, 3)));
  CHECK(drowned.pattern == Pattern::unresolved);
}

TEST_CASE("short records, and turns that frames do not resolve, are unresolved") {
  CHECK(pattern(swinging(0.5, 40.0)) == Pattern::zigzag);
  CHECK(pattern(swinging(0.5, 7.0)) == Pattern::unresolved);
  CHECK(pattern(part(swinging(0.02, 40.0), 0, 40)) == Pattern::unresolved);  // 1 length of the body
  MotionRecord fast = plate({{"inertia_ratio", 1.4}}, 400.0, 0.25);
  fast.angles *= 20.0;
  CHECK(label(features(fast)).why.find("between two frames") != std::string::npos);
}

TEST_CASE("the margin of a label is 0 at the border and grows away from it") {
  PatternThresholds limits;
  const Features small = features(swinging(0.12, 60.0));
  const double tilt = small[Feature::tilt];
  set_threshold(limits, "steady_tilt", tilt * 1.0001);
  CHECK(label(small, limits).pattern == Pattern::steady);
  CHECK(label(small, limits).margin < 2e-4);
  set_threshold(limits, "steady_tilt", tilt * 0.9999);
  CHECK(label(small, limits).pattern == Pattern::zigzag);
  CHECK(label(small, limits).margin < 2e-4);
  set_threshold(limits, "steady_tilt", tilt * 2.0);
  CHECK(label(small, limits).margin == Approx(0.5));
  CHECK(error_text<samara::ArgumentError>([&] {
          set_threshold(limits, "steady_tlit", 1.0);
        }).find("did you mean \"steady_tilt\"") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          set_threshold(limits, "winding", -1.0);
        }).find("winding is -1") != std::string::npos);
}

TEST_CASE(
    "a fall that changes its pattern is a sequence of windows, and its last pattern is that of the fall") {
  // Swings that grow, then turns over and over the same way.
  MotionRecord record;
  record.times = Eigen::VectorXd::LinSpaced(1601, 0.0, 160.0);
  record.positions.setZero(1601, 3);
  record.angles.resize(1601);
  for (Eigen::Index k = 0; k < 1601; ++k) {
    const double t = record.times[k];
    record.angles[k] = t < 80.0 ? 0.6 * std::sin(t) : 0.6 * std::sin(80.0) + 1.5 * (t - 80.0);
    record.positions(k, 0) = t < 80.0 ? std::sin(t) : t - 80.0;
    record.positions(k, 2) = -t;
  }
  record.length = 2.0;
  record.position_noise = record.angle_noise = 0.0;
  const std::vector<LabelledWindow> sequence = label_windows(record);
  REQUIRE(sequence.size() >= 2);
  CHECK(sequence.front().label.pattern == Pattern::zigzag);
  CHECK(sequence.back().label.pattern == Pattern::autorotation);
  CHECK(sequence.front().to > 60.0);
  CHECK(sequence.front().to < 100.0);
  for (std::size_t k = 1; k < sequence.size(); ++k)
    CHECK(sequence[k].label.pattern != sequence[k - 1].label.pattern);
  CHECK(error_text<samara::ArgumentError>([&] {
          label_windows(record, {.overlap = 1.0});
        }).find("overlap is 1") != std::string::npos);
}
