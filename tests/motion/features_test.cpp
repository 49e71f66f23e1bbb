// Features: free of yaw, mirror, units, frame rate, the plate's symmetry and noise; and what they are by hand.
#include "samara/motion/patterns/features.h"

#include <catch2/catch.hpp>

#include "known_motions.h"
#include "samara/base/streams.h"
#include "samara/models/bodies/kinematic_paths.h"
#include "samara/motion/patterns/pattern_rules.h"
#include "samara/motion/records/even_frames.h"
#include "tests/error_text.h"

using namespace samara::motion;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kHalfTurn = std::numbers::pi;

/// @param length_factor, time_factor of the second's units
void check_same(const Features& first, const Features& second, double tolerance, double length_factor = 1.0,
                double time_factor = 1.0) {
  for (std::size_t k = 0; k < kFeatures; ++k) {
    const FeatureInfo& info = feature_infos()[k];
    INFO(info.name << " " << first.values[k] << " " << second.values[k]);
    const double factor = info.unit == "m"     ? length_factor
                          : info.unit == "s"   ? time_factor
                          : info.unit == "m/s" ? length_factor / time_factor
                          : info.unit == "1/s" ? 1.0 / time_factor
                                               : 1.0;
    REQUIRE(std::isfinite(first.values[k]) == std::isfinite(second.values[k]));
    if (!std::isfinite(first.values[k])) continue;
    CHECK_THAT(second.values[k] / factor,
               WithinAbs(first.values[k], tolerance * (1.0 + std::abs(first.values[k]))));
  }
}

/// Fluttering, tumbling and chaotic plates, a card that turns over anyhow, and a spiral.
std::vector<MotionRecord> samples() {
  std::vector<MotionRecord> all = {plate({{"inertia_ratio", 1.0}}), plate({{"inertia_ratio", 1.4}}),
                                   plate({{"inertia_ratio", 2.1}}), card(0.61, 1.81, 1.21, 0.6, 2.0),
                                   positions_only(card(0.31, 0.91, 0.61, 0.0, 2.0))};
  return all;
}

}  // namespace

TEST_CASE("features do not change when the world is turned about the vertical or mirrored") {
  for (const MotionRecord& record : samples()) {
    const Features here = features(record);
    check_same(here, features(mirrored(record)), 1e-9);
    if (record.is_planar()) continue;  // which has no other azimuth
    check_same(here, features(turned(record, 1.1)), 1e-6);
    check_same(here, features(mirrored(turned(record, -2.3))), 1e-6);
  }
}

TEST_CASE("features do not change with the side of the plate that is called its upper one") {
  for (MotionRecord record : samples()) {
    const Features here = features(record);
    record.normals *= -1.0;
    record.angles.array() += kHalfTurn;
    check_same(here, features(record), 1e-9);
  }
}

TEST_CASE(
    "features without a unit do not change with units, those with one change like them, and none with the "
    "origin") {
  for (MotionRecord record : samples()) {
    const Features here = features(record);
    record.positions.rowwise() += Eigen::RowVector3d(3.0, -4.0, 5.0);
    record.positions *= 100.0;
    record.length *= 100.0;
    record.times.array() += 7.0;
    record.times *= 1000.0;
    check_same(here, features(record), 1e-6, 100.0, 1000.0);
  }
}

TEST_CASE("features hardly change with the frame rate") {
  for (const double I : {1.0, 1.4, 1.5}) {
    INFO("I* " << I);
    const Features coarse = features(plate({{"inertia_ratio", I}}, 120.0, 0.3));
    const Features fine = features(plate({{"inertia_ratio", I}}, 120.0, 0.075));
    CHECK(coarse[Feature::flips] == fine[Feature::flips]);
    CHECK_THAT(fine[Feature::tilt], WithinRel(coarse[Feature::tilt], 0.01));
    CHECK_THAT(fine[Feature::fall], WithinRel(coarse[Feature::fall], 0.01));
    CHECK_THAT(fine[Feature::sway], WithinRel(coarse[Feature::sway], 0.02));
    CHECK_THAT(fine[Feature::recurrence], WithinAbs(coarse[Feature::recurrence], 0.05));
  }
}

TEST_CASE("noise is subtracted from variances") {
  // Sinking at 1 without any motion: what is left is the scatter of an estimate of nothing.
  MotionRecord still;
  still.times = Eigen::VectorXd::LinSpaced(601, 0.0, 60.0);
  still.positions.setZero(601, 3);
  still.positions.col(2) = -still.times;
  still.angles.setZero(601);
  still.length = 2.0;
  const Features noisy_still = features(noisy(still, 0.01, 0.1, 3));
  CHECK(noisy_still[Feature::tilt_noise] > 0.1);
  CHECK(noisy_still[Feature::tilt] < 0.5 * noisy_still[Feature::tilt_noise]);
  CHECK(noisy_still[Feature::sway] < 0.02);
  // A plate that moves: the features of the noisy record are those of the clean one.
  const MotionRecord moving = plate({{"inertia_ratio", 1.1}}, 240.0);
  const Features clean = features(moving);
  const Features noisy_moving = features(noisy(moving, 0.02, 0.05, 4));
  CHECK_THAT(noisy_moving[Feature::tilt], WithinRel(clean[Feature::tilt], 0.02));
  CHECK_THAT(noisy_moving[Feature::sway], WithinRel(clean[Feature::sway], 0.02));
  CHECK(clean[Feature::recurrence] < 0.05);
  CHECK(noisy_moving[Feature::recurrence] < 0.1);
}

TEST_CASE("noise of one horizontal direction is not subtracted twice where a record has one only") {
  // Swaying sideways in the plane y = 0 a little more than the noise.
  MotionRecord record;
  record.times = Eigen::VectorXd::LinSpaced(4001, 0.0, 400.0);
  record.positions.setZero(4001, 3);
  record.positions.col(0) = 0.08 * (0.5 * record.times.array()).sin();
  record.positions.col(2) = -record.times;
  record.length = 2.0;
  const double clean = features(record)[Feature::sway];
  CHECK_THAT(clean, WithinRel(0.04 / std::sqrt(2.0), 0.01));
  MotionRecord with_noise = noisy(record, 0.05, 0.0, 8);
  with_noise.positions.col(1).setZero();
  const Features planar = features(with_noise);
  REQUIRE(planar[Feature::sway_noise] > 0.4 * clean);  // or nothing is tested
  CHECK_THAT(planar[Feature::sway], WithinRel(clean, 0.1));
  const Features in_both = features(noisy(record, 0.05, 0.0, 8));
  CHECK_THAT(in_both[Feature::sway_noise], WithinRel(std::sqrt(2.0) * planar[Feature::sway_noise], 0.1));
}

TEST_CASE("noise is subtracted from the scatter of radii, and from the variances of the ground") {
  // A circle, of which noise makes the radius uneven, and a line, which noise makes wide.
  MotionRecord round;
  round.times = Eigen::VectorXd::LinSpaced(601, 0.0, 60.0);
  round.positions.resize(601, 3);
  round.positions.col(0) = round.times.array().cos();
  round.positions.col(1) = round.times.array().sin();
  round.positions.col(2) = -round.times;
  round.length = 2.0;
  const Features uneven = features(noisy(round, 0.2, 0.0, 9));
  CHECK(uneven[Feature::wobble] < 0.05);
  MotionRecord line = round;
  line.positions.col(1).setZero();
  line.positions.col(0) *= 0.5;
  line.positions.col(1).setConstant(1e-12);
  CHECK(features(noisy(line, 0.2, 0.0, 10))[Feature::e] > 0.99);
}

TEST_CASE("fourth differences tell the noise of a smooth motion") {
  MotionRecord record = noisy(plate({{"inertia_ratio", 1.0}}, 400.0, 0.1), 0.03, 0.07, 5);
  CHECK_THAT(noise_of(record.positions.col(0), record.times), WithinRel(0.03, 0.05));
  CHECK_THAT(noise_of(record.angles, record.times), WithinRel(0.07, 0.05));
}

TEST_CASE("flutter has the statistics of the model sheet") {
  const Features flutter = features(plate({{"inertia_ratio", 1.1}}, 600.0));
  CHECK_THAT(flutter[Feature::fall], WithinAbs(0.585, 0.01));
  CHECK_THAT(1.0 / flutter[Feature::frequency], WithinRel(15.953, 0.05));
  CHECK(flutter[Feature::tilt] < 3.04);  // the whole range
  CHECK(flutter[Feature::tilt] > 2.7);
  CHECK(flutter[Feature::flips] == 0.0);
  const Features tumbling = features(plate({{"inertia_ratio", 1.4}}, 600.0));
  CHECK_THAT(tumbling[Feature::flips], WithinAbs(2.0 * 7.79 * 3.0, 1.5));  // 300 a/U are watched
  CHECK(tumbling[Feature::coherence] == 1.0);
  CHECK_THAT(tumbling[Feature::drift], WithinRel(0.756 / 0.327, 0.05));
}

TEST_CASE("half turns there and back have the coherence 0 in a plane, and -1 in space") {
  MotionRecord record;
  record.times = Eigen::VectorXd::LinSpaced(1201, 0.0, 120.0);
  record.positions.setZero(1201, 3);
  record.positions.col(2) = -record.times;
  record.angles = 0.5 * kHalfTurn * (1.0 - (record.times.array() * kHalfTurn / 30.0).cos());
  record.length = 2.0;
  const FeatureOptions all = {.settle_share = 0.0};
  CHECK(features(record, all)[Feature::coherence] == 0.0);
  CHECK_THAT(features(in_space(record), all)[Feature::coherence], WithinAbs(-1.0, 1e-12));
}

TEST_CASE("a drifting spiral winds about a centre that follows it, and a helix wobbles") {
  // Revolutions and a half: the mean of the places is no centre.
  for (const double modulation : {0.0, 0.5}) {
    const samara::models::RosePath path = {.descent_speed = 1.0,
                                           .amplitude_x = 0.8,
                                           .amplitude_y = 0.8,
                                           .modulation = modulation,
                                           .lobes = 4.0,
                                           .angular_frequency = 2.0};
    MotionRecord record;
    record.times = Eigen::VectorXd::LinSpaced(401, 0.0, 11.0);
    record.positions.resize(401, 3);
    for (Eigen::Index k = 0; k < 401; ++k)
      record.positions.row(k) = at(path, record.times[k]).position.transpose() +
                                record.times[k] * Eigen::RowVector3d(0.3, -0.2, 0.0);
    const Features round = features(record);
    CHECK_THAT(round[Feature::turns], WithinAbs(2.0 * 5.5 / (2.0 * kHalfTurn), 0.05));
    CHECK_THAT(round[Feature::winding], WithinAbs(1.0, 1e-3));
    CHECK_THAT(round[Feature::wobble], WithinAbs(modulation / std::sqrt(2.0), 0.02));
  }
}

TEST_CASE("records that cannot be meant are refused in one sentence") {
  MotionRecord record = plate({{"inertia_ratio", 1.0}});
  const auto with = [&](auto change) {
    MotionRecord bad = record;
    change(bad);
    return error_text<samara::ArgumentError>([&] { features(bad); });
  };
  CHECK(with([](MotionRecord& r) { r.times[5] = r.times[4]; }).find("the time of frame 5") !=
        std::string::npos);
  CHECK(with([](MotionRecord& r) { r.positions(7, 2) = NAN; }).find("frame 7 of the record is not finite") !=
        std::string::npos);
  CHECK(with([](MotionRecord& r) { r = part(r, 0, 11); }).find("has 11 frames, expected at least 12") !=
        std::string::npos);
  CHECK(with([](MotionRecord& r) { r.length = -1.0; }).find("is -1") != std::string::npos);
  CHECK(with([](MotionRecord& r) {
          r = in_space(r), r.normals.row(3) *= 2.0;
        }).find("the normal in frame 3") != std::string::npos);
  CHECK(with([](MotionRecord& r) {
          r.normals = in_space(r).normals;
        }).find("has normals and angles, expected one") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          features(record, {.settle_share = 1.0});
        }).find("settle_share is 1") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([&] {
          features(record, {.settle = 119.0});
        }).find("settle is 119") != std::string::npos);
  const auto refused = [&](const FeatureOptions& options) {
    return error_text<samara::ArgumentError>([&] { features(record, options); });
  };
  CHECK(refused({.settle = -1.0}).find("settle is -1") == 0);
  CHECK(refused({.settle = NAN}).find("settle is nan") == 0);
  CHECK(refused({.exponent = INFINITY}).find("exponent is inf") == 0);
  CHECK(refused({.flip_margin_plane = NAN}).find("flip_margin_plane is nan") == 0);
  CHECK(refused({.flip_margin_space = 2.0}).find("flip_margin_space is 2") == 0);
  CHECK(refused({.swing_margin = -0.1}).find("swing_margin is -0.1") == 0);
  CHECK(error_text<samara::ArgumentError>([] { feature_of("tlit"); }).find("did you mean \"tilt\"") !=
        std::string::npos);
}

TEST_CASE("captures become records, with the frames that were not seen left out and counted") {
  samara::identification::Capture capture;
  capture.id = "drop";
  const MotionRecord source = card(0.61, 1.81, 1.21, 0.6, 0.5);
  capture.times = source.times;
  for (int c = 0; c < 3; ++c)
    capture.channels.push_back({std::string(1, "xyz"[c]), "m", source.positions.col(c), {}});
  capture.channels[1].values[20] = NAN;
  const MotionRecord record = record_of(capture, 0.07);
  CHECK(record.left_out == 1);
  CHECK(record.frame_count() == source.frame_count() - 1);
  CHECK_FALSE(record.has_attitude());
  capture.channels[0].unit = "px";
  CHECK(error_text<samara::ArgumentError>([&] {
          record_of(capture);
        }).find("capture \"drop\": x is in pixels") != std::string::npos);
  capture.channels[0].unit = "s";
  CHECK(error_text<samara::ArgumentError>([&] {
          record_of(capture);
        }).find("capture \"drop\": x is in s, expected a length") != std::string::npos);
}

TEST_CASE("frames that were not seen leave features as they are, and gaps of many frames are refused") {
  const auto without = [](const MotionRecord& record, Eigen::Index first, Eigen::Index count) {
    std::vector<Eigen::Index> left;
    for (Eigen::Index k = 0; k < record.frame_count(); ++k) {
      if (k < first || k >= first + count) left.push_back(k);
    }
    MotionRecord cut = record;
    cut.times = record.times(left);
    cut.positions = record.positions(left, Eigen::all);
    if (record.is_planar()) cut.angles = record.angles(left);
    return cut;
  };
  // It swings alike every 5 a/U: lags by frame numbers would miss half a swing beyond the gaps.
  const MotionRecord whole = plate({{"inertia_ratio", 1.0}}, 120.0, 0.1);
  MotionRecord cut = whole;
  for (const Eigen::Index first : {700, 800, 900, 1000}) cut = without(cut, first, 10);
  REQUIRE(cut.frame_count() == whole.frame_count() - 40);
  const Features all = features(whole), some = features(cut);
  CHECK(all[Feature::recurrence] < 0.05);
  CHECK_THAT(some[Feature::recurrence], WithinAbs(all[Feature::recurrence], 0.03));
  CHECK(some[Feature::flips] == all[Feature::flips]);
  CHECK(label(some).pattern == label(all).pattern);
  const std::string text = error_text<samara::ArgumentError>([&] { features(without(whole, 700, 30)); });
  CHECK(text.find("no frames from 69.9 to 73 s, 30 at its rate, expected at most 10") != std::string::npos);
}

TEST_CASE("noise is that of the frames that were seen, however many are missing between them") {
  samara::Stream stream(11, 0);
  const auto falling = [&](const auto& is_seen) {
    std::vector<Eigen::Vector4d> rows;
    for (int k = 0; k < 720; ++k) {
      const Eigen::Vector3d noise(stream.normal(), stream.normal(), stream.normal());
      if (!is_seen(k)) continue;
      const double t = k / 120.0;
      rows.emplace_back(t, 0.004 * noise.x(), 0.004 * noise.y(), 0.004 * noise.z() - 0.5 * t);
    }
    MotionRecord record;
    record.length = 0.05;
    record.times.resize(static_cast<Eigen::Index>(rows.size()));
    record.positions.resize(record.times.size(), 3);
    for (Eigen::Index k = 0; k < record.times.size(); ++k) {
      record.times[k] = rows[static_cast<std::size_t>(k)][0];
      record.positions.row(k) = rows[static_cast<std::size_t>(k)].tail<3>();
    }
    return record;
  };
  // Every third missing, no five frames follow each other.
  const MotionRecord whole = falling([](int) { return true; }),
                     third = falling([](int k) { return k % 3 != 1; }),
                     drawn = falling([&](int) { return stream.uniform() > 0.25; });
  for (const MotionRecord& record : {whole, third, drawn}) {
    INFO(record.frame_count() << " frames");
    CHECK_THAT(noise_of(record.positions.col(0), record.times), WithinRel(0.004, 0.2));
  }
  for (const MotionRecord& record : {whole, drawn}) CHECK(label(features(record)).pattern == Pattern::steady);
  // Of even frames the weights are binomials, whose squares add up to 70.
  const Eigen::Matrix<double, 5, 1> binomials = {1.0, -4.0, 6.0, -4.0, 1.0};
  CHECK((divided_difference(whole.times.head(5)) - binomials / std::sqrt(70.0)).norm() < 1e-9);
}
