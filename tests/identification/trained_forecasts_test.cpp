#include "samara/identification/forecasts/trained_forecasts.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/streams.h"
#include "samara/identification/forecasts/point_with_drag.h"

using namespace samara::identification;

namespace {

constexpr double kFrameTime = 0.01;
constexpr int kSeenFrames = 20;
constexpr double kWayAhead = 0.1;

/// Bodies that swing as they fall, about an axis of their own with an amplitude and a phase of their own: a line
/// errs, and the last places say all.
SeenMotion swinging(std::uint64_t number, double noise, Eigen::RowVector3d* next = nullptr) {
  samara::Stream stream(3, number);
  const double heading = 6.28 * stream.uniform(), phase = 6.28 * stream.uniform();
  const double amplitude = 0.05 + 0.1 * stream.uniform(), speed = 0.8 + 0.4 * stream.uniform();
  const auto place = [&](double t) -> Eigen::RowVector3d {
    const double swing = amplitude * std::sin(12.0 * t + phase);
    return {std::cos(heading) * swing, std::sin(heading) * swing,
            -speed * t + 0.2 * amplitude * std::cos(24.0 * t + 2.0 * phase)};
  };
  SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(kSeenFrames, 0.0, (kSeenFrames - 1) * kFrameTime),
                  .positions = Eigen::MatrixXd(kSeenFrames, 3),
                  .up = 2};
  for (int k = 0; k < kSeenFrames; ++k) {
    seen.positions.row(k) = place(seen.times[k]);
    for (int c = 0; c < 3; ++c) seen.positions(k, c) += noise * stream.normal();
  }
  if (next) *next = place(seen.times[kSeenFrames - 1] + kWayAhead);
  return seen;
}

AskedMoment moment(std::uint64_t number, double noise = 1e-4) {
  Eigen::RowVector3d next;
  SeenMotion seen = swinging(number, noise, &next);
  const double time = seen.times[kSeenFrames - 1] + kWayAhead;
  return {.moment = {.cluster = static_cast<int>(number / 4), .seen = std::move(seen), .next = next},
          .time = time};
}

/// A model that is right but for an error of its own.
AskedMoment asked(std::uint64_t number, double error) {
  AskedMoment one = moment(number);
  samara::Stream stream(4, number);
  one.model = one.moment.next;
  for (int c = 0; c < 3; ++c) one.model[c] += error * stream.normal();
  return one;
}

std::vector<AskedMoment> all_asked(std::uint64_t first, std::uint64_t count, double error) {
  std::vector<AskedMoment> moments;
  for (std::uint64_t k = first; k < first + count; ++k) moments.push_back(asked(k, error));
  return moments;
}

const Components kLevel = {.level = {0, 1}};

/// Root of the mean squared distance of a predictor.
double rms_of(const TrainedForecasts& trained, const std::vector<AskedMoment>& moments,
              const std::string& predictor) {
  double sum = 0.0;
  for (const AskedMoment& one : moments) {
    const auto said = trained.say(one);
    const auto found = std::ranges::find(said, predictor, &SaidForecast::predictor);
    REQUIRE(found != said.end());
    sum += (found->mean - one.moment.next).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(moments.size()));
}

}  // namespace

TEST_CASE("bands are wider where errors in training grew with the speed, and for motions unlike all of it") {
  const TrainedForecasts trained = TrainedForecasts::train(all_asked(0, 200, 0.02), kLevel);
  const auto width = [&](const AskedMoment& one, const std::string& predictor) {
    const auto said = trained.say(one);
    return std::ranges::find(said, predictor, &SaidForecast::predictor)->parts[0].deviations[0];
  };
  double usual = 0.0, unlike = 0.0;
  for (std::uint64_t k = 1000; k < 1020; ++k) {
    AskedMoment one = asked(k, 0.02);
    usual += width(one, to_string(Baseline::constant_velocity));
    one.moment.seen.positions *= 3.0;
    unlike += width(one, to_string(Baseline::constant_velocity));
  }
  CHECK(unlike > 1.2 * usual);
}

TEST_CASE("an autoregression of swinging bodies foresees others, whichever way they swing") {
  std::vector<TrainingMoment> moments;
  for (std::uint64_t k = 0; k < 200; ++k) moments.push_back(moment(k).moment);
  const Autoregression trained = Autoregression::fit(moments, kLevel);
  double ours = 0.0, line = 0.0;
  for (std::uint64_t k = 1000; k < 1050; ++k) {
    AskedMoment one = moment(k);
    ours += (trained.predict(one.moment.seen, {}) - one.moment.next).squaredNorm();
    line +=
        (predict(Baseline::straight_line, one.moment.seen, Eigen::VectorXd::Constant(1, one.time)).row(0) -
         one.moment.next)
            .squaredNorm();
    // Turned about the vertical and moved, the forecast turns and moves with it.
    SeenMotion turned = one.moment.seen;
    const Eigen::Matrix2d turn = (Eigen::Matrix2d() << 0.6, -0.8, 0.8, 0.6).finished();
    turned.positions.leftCols<2>() = one.moment.seen.positions.leftCols<2>() * turn.transpose();
    turned.positions.col(2).array() += 5.0;
    Eigen::RowVectorXd expected = trained.predict(one.moment.seen, {});
    expected.head<2>() = expected.head<2>() * turn.transpose();
    expected[2] += 5.0;
    CHECK((trained.predict(turned, {}) - expected).norm() < 1e-9);
  }
  CHECK(std::sqrt(ours) < 0.3 * std::sqrt(line));
  // Four frames are enough to say something, three are not; a motion never seen has all the training.
  SeenMotion few{.times = Eigen::Vector3d(0.0, 0.01, 0.02), .positions = Eigen::MatrixXd::Zero(3, 3)};
  CHECK(trained.predict(few, {}).array().isNaN().all());
  const AskedMoment strange = moment(2000);
  CHECK(trained.predict_without(2000, strange.moment.seen, {}) == trained.predict(strange.moment.seen, {}));
  CHECK_FALSE(trained.predict_without(1, moments[4].seen, {}) == trained.predict(moments[4].seen, {}));
  CHECK_FALSE(Autoregression::fit(std::span(moments).first(3), kLevel).is_fitted());
  moments[5].known = Eigen::VectorXd::Ones(1);
  CHECK_THROWS_WITH(Autoregression::fit(moments, kLevel), Catch::Contains("1 known numbers"));
}

TEST_CASE("a mixture leans on a good model, leaves a bad one, and says how far it errs") {
  const auto unseen = all_asked(5000, 300, 3e-4);
  const auto good = TrainedForecasts::train(all_asked(0, 120, 3e-4), kLevel);
  const auto bad = TrainedForecasts::train(all_asked(0, 120, 0.5), kLevel);
  const auto share_of_model = [](const TrainedForecasts& trained) {
    const auto shares = trained.shares();
    const auto found = std::ranges::find(shares, "model", &TrainedForecasts::Share::predictor);
    return found == shares.end() ? 0.0 : found->share;
  };
  CHECK(share_of_model(good) > 0.8);
  CHECK(share_of_model(bad) < 0.05);
  CHECK(rms_of(good, unseen, "mixture") <= 1.02 * rms_of(good, unseen, "model"));
  CHECK(rms_of(bad, unseen, "mixture of baselines") < rms_of(bad, unseen, "straight line"));
  ProperScores scores;
  for (const AskedMoment& one : unseen) {
    for (const SaidForecast& said : good.say(one)) {
      if (said.predictor != "mixture") continue;
      REQUIRE(said.parts.size() == 3);
      for (Eigen::Index c = 0; c < 3; ++c)
        scores.add(said.parts[static_cast<std::size_t>(c)], one.moment.next[c]);
    }
  }
  CHECK(scores.coverage(0.9) == Approx(0.9).margin(0.05));
  CHECK(scores.coverage(0.5) == Approx(0.5).margin(0.08));
  // A model that fails once leaves the word to the others.
  AskedMoment silent = unseen[0];
  silent.model = {};
  const auto said = good.say(silent);
  CHECK(said.front().parts.empty());
  CHECK(said.back().mean.allFinite());
}

TEST_CASE("a point that falls with drag is carried on by its own drag, in space and in the plane") {
  // From rest, x'' = -g + k v^2: z = -log cosh(sqrt(g k) t)/k.
  const double k = 2.0, g = 9.80665;
  const auto height = [&](double t) { return -std::log(std::cosh(std::sqrt(g * k) * t)) / k; };
  for (const Eigen::Index count : {2, 3}) {
    SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(31, 0.0, 0.3),
                    .positions = Eigen::MatrixXd::Zero(31, count),
                    .up = count - 1};
    for (Eigen::Index row = 0; row < 31; ++row) seen.positions(row, count - 1) = height(seen.times[row]);
    const Eigen::Vector2d times(0.6, 0.4);
    const Eigen::MatrixXd ahead = predict(Baseline::point_with_drag, seen, times);
    CHECK(ahead(0, count - 1) == Approx(height(0.6)).margin(1e-6));
    CHECK(ahead(1, count - 1) == Approx(height(0.4)).margin(1e-6));
    CHECK(ahead.leftCols(count - 1).cwiseAbs().maxCoeff() < 1e-9);
    seen.up = -1;
    CHECK(predict(Baseline::point_with_drag, seen, times).array().isNaN().all());
  }
}

TEST_CASE("noise grows on the way to a forecast by as much as noisy places make it scatter") {
  const auto seen_with = [](int frames, std::uint64_t number) {
    samara::Stream stream(7, number);
    SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(frames, 0.0, 0.01 * (frames - 1)),
                    .positions = Eigen::MatrixXd(frames, 1),
                    .rates = Eigen::MatrixXd(frames, 1)};
    for (int k = 0; k < frames; ++k) {
      seen.positions(k, 0) = stream.normal();
      seen.rates(k, 0) = 1e3 * stream.normal();
    }
    return seen;
  };
  constexpr int kDraws = 2000;
  for (const Baseline baseline : all_baselines()) {
    if (baseline == Baseline::point_with_drag) continue;
    const bool by_rates = baseline == Baseline::measured_velocity;
    const Eigen::VectorXd time = Eigen::VectorXd::Constant(1, 0.3);
    double squares = 0.0;
    for (std::uint64_t k = 0; k < kDraws; ++k)
      squares += std::pow(predict(baseline, seen_with(20, k), time)(0, 0), 2);
    const double gain = noise_gain(baseline, seen_with(20, 0), 0.3);
    CAPTURE(to_string(baseline));
    CHECK((by_rates ? 1e3 : 1.0) * gain == Approx(std::sqrt(squares / kDraws)).epsilon(0.08));
    CHECK(noise_gain(baseline, seen_with(6, 0), 0.3) > 2.0 * gain);
    CHECK(std::isnan(noise_gain(baseline, seen_with(1, 0), 0.3)));
  }
  CHECK(std::isnan(noise_gain(Baseline::point_with_drag, seen_with(20, 0), 0.3)));  // nothing is up
}

TEST_CASE("a mixture does not hear a polynomial that has much less to go by than in training") {
  // Where a third derivative rules, the cubic has the share; of five frames, far ahead, it knows nothing.
  const auto asked_of = [](std::uint64_t number, int frames) {
    samara::Stream stream(8, number);
    const double c3 = 20.0 * stream.normal(), c1 = stream.normal();
    SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(frames, 0.0, kFrameTime * (frames - 1)),
                    .positions = Eigen::MatrixXd(frames, 3)};
    const auto place = [&](double t) {
      return Eigen::RowVector3d(c1 * t + c3 * t * t * t, c3 * t * t * t, -c1 * t);
    };
    for (int k = 0; k < frames; ++k) {
      seen.positions.row(k) = place(seen.times[k]);
      for (int c = 0; c < 3; ++c) seen.positions(k, c) += 1e-4 * stream.normal();
    }
    const double time = (kSeenFrames - 1) * kFrameTime + kWayAhead;
    AskedMoment one{.moment = {.cluster = static_cast<int>(number), .seen = seen, .next = place(time)},
                    .time = time};
    one.model = one.moment.next;
    for (int c = 0; c < 3; ++c) one.model[c] += 0.02 * stream.normal();
    return one;
  };
  std::vector<AskedMoment> training;
  for (std::uint64_t k = 0; k < 80; ++k) training.push_back(asked_of(k, kSeenFrames));
  const auto trained = TrainedForecasts::train(training, kLevel);
  double share = 0.0;
  for (const auto& one : trained.shares()) share += one.predictor == "cubic" ? one.share : 0.0;
  REQUIRE(share > 0.3);
  std::vector<AskedMoment> few, enough;
  for (std::uint64_t k = 200; k < 240; ++k) {
    few.push_back(asked_of(k, 5));
    enough.push_back(asked_of(k, kSeenFrames));
  }
  CHECK(rms_of(trained, few, "cubic") > 10.0 * rms_of(trained, few, "model"));
  CHECK(rms_of(trained, few, "mixture") <= 1.05 * rms_of(trained, few, "model"));
  CHECK(rms_of(trained, enough, "mixture") < rms_of(trained, enough, "model"));
  // Baselines say what they say; of their mixture, if none is as sure, all.
  CHECK(rms_of(trained, few, "mixture of baselines") > 0.0);
}

TEST_CASE("a point under water weighs less, and what is lighter than water rises") {
  // From rest, x'' = -w + k v^2, as above with w in place of g.
  const double k = 2.0;
  for (const double w : {2.85, -2.85}) {
    const double up = w > 0.0 ? 1.0 : -1.0, a = std::abs(w);
    const auto height = [&](double t) { return -up * std::log(std::cosh(std::sqrt(a * k) * t)) / k; };
    SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(31, 0.0, 0.6),
                    .positions = Eigen::MatrixXd::Zero(31, 3),
                    .up = 2,
                    .net_weight = w};
    for (Eigen::Index row = 0; row < 31; ++row) seen.positions(row, 2) = height(seen.times[row]);
    const Eigen::VectorXd time = Eigen::VectorXd::Constant(1, 1.2);
    CHECK(predict(Baseline::point_with_drag, seen, time)(0, 2) == Approx(height(1.2)).margin(1e-6));
  }
}

namespace {

/// Bodies that swing in the plane of an axis of their own, faster the wider (a pendulum), and turn about the vertical
/// the faster the wider too: no sum of places with constant weights foresees them.
AskedMoment bending(std::uint64_t number) {
  samara::Stream stream(41, number);
  const double heading = 6.28 * stream.uniform(), phase = 6.28 * stream.uniform();
  const double wide = 0.3 + 2.0 * stream.uniform(), hand = stream.uniform() < 0.5 ? -1.0 : 1.0;
  const double frequency = 12.0 * (1.0 - 0.2 * wide);
  const auto place = [&](double t) -> Eigen::RowVector3d {
    const double swing = 0.1 * wide * std::sin(frequency * t + phase), angle = heading + hand * wide * t;
    return {std::cos(angle) * swing, std::sin(angle) * swing, -t};
  };
  SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(kSeenFrames, 0.0, (kSeenFrames - 1) * kFrameTime),
                  .positions = Eigen::MatrixXd(kSeenFrames, 3),
                  .up = 2};
  for (int k = 0; k < kSeenFrames; ++k) seen.positions.row(k) = place(seen.times[k]);
  const double time = seen.times[kSeenFrames - 1] + 2.0 * kWayAhead;
  return {.moment = {.cluster = static_cast<int>(number / 4), .seen = std::move(seen), .next = place(time)},
          .time = time};
}

Autoregression of_bending(std::uint64_t count) {
  std::vector<TrainingMoment> moments;
  for (std::uint64_t k = 0; k < count; ++k) moments.push_back(bending(k).moment);
  return Autoregression::fit(moments, kLevel);
}

double rms_of(const Autoregression& trained) {
  double squares = 0.0;
  for (std::uint64_t k = 5000; k < 5100; ++k) {
    const TrainingMoment one = bending(k).moment;
    squares += (trained.predict(one.seen, {}) - one.next).squaredNorm();
  }
  return std::sqrt(squares / 100.0);
}

}  // namespace

TEST_CASE("a correction learns what no linear prediction can, the more it has seen") {
  const Autoregression few = of_bending(80), many = of_bending(640);
  REQUIRE(many.correction().is_fitted());
  CHECK(rms_of(many) < 0.6 * rms_of(few));
  // Motions too short for its places are left to the linear prediction.
  SeenMotion short_one = bending(9000).moment.seen;
  const Eigen::VectorXd times = short_one.times.tail(8);
  const Eigen::MatrixXd positions = short_one.positions.bottomRows(8);
  short_one.times = times;
  short_one.positions = positions;
  CHECK(many.predict(short_one, {}).allFinite());
}

TEST_CASE("a corrected forecast turns with the motion, and is its mirror image's") {
  const Autoregression trained = of_bending(200);
  REQUIRE(trained.correction().is_fitted());
  const Eigen::Matrix2d turn = (Eigen::Matrix2d() << 0.6, -0.8, 0.8, 0.6).finished(),
                        mirror = (Eigen::Matrix2d() << 0.28, 0.96, 0.96, -0.28).finished();
  for (std::uint64_t k = 6000; k < 6020; ++k) {
    const SeenMotion seen = bending(k).moment.seen;
    for (const Eigen::Matrix2d& change : {turn, mirror}) {
      SeenMotion changed = seen;
      changed.positions.leftCols<2>() = seen.positions.leftCols<2>() * change.transpose();
      Eigen::RowVectorXd expected = trained.predict(seen, {});
      expected.head<2>() = expected.head<2>() * change.transpose();
      CHECK((trained.predict(changed, {}) - expected).norm() < 1e-9);
      expected = trained.predict_without(3, seen, {});
      expected.head<2>() = expected.head<2>() * change.transpose();
      CHECK((trained.predict_without(3, changed, {}) - expected).norm() < 1e-9);
    }
  }
}

TEST_CASE(
    "motions in space have a second prediction, of displacements alone, and those in a plane have none") {
  const Autoregression trained = of_bending(200);
  REQUIRE(trained.turning().is_fitted());
  TrainingMoment one = bending(7000).moment;
  const Eigen::RowVectorXd forecast = trained.predict(one.seen, {});
  one.seen.positions.array() += 3.0;  // moved, the forecast moves
  CHECK((trained.predict(one.seen, {}).array() - 3.0 - forecast.array()).abs().maxCoeff() < 1e-9);
  std::vector<TrainingMoment> in_plane;
  for (std::uint64_t k = 0; k < 200; ++k) {
    in_plane.push_back(bending(k).moment);
    in_plane.back().seen.positions = in_plane.back().seen.positions.rightCols<2>().eval();
    in_plane.back().next = in_plane.back().next.tail<2>().eval();
    in_plane.back().seen.up = 1;
  }
  CHECK_FALSE(Autoregression::fit(in_plane, {.level = {0}}).turning().is_fitted());
}

TEST_CASE("the order of training moments does not matter") {
  std::vector<AskedMoment> moments = all_asked(0, 120, 5e-3);
  for (std::uint64_t k = 200; k < 320; ++k) moments.push_back(moment(k));
  const TrainedForecasts trained = TrainedForecasts::train(moments, kLevel);
  std::ranges::reverse(moments);
  const TrainedForecasts reversed = TrainedForecasts::train(moments, kLevel);
  for (const AskedMoment& one : all_asked(7000, 10, 5e-3)) {
    const auto said = trained.say(one), again = reversed.say(one);
    REQUIRE(said.size() == again.size());
    for (std::size_t p = 0; p < said.size(); ++p) {
      CAPTURE(said[p].predictor);
      if (said[p].mean.allFinite()) CHECK((said[p].mean - again[p].mean).norm() < 1e-6);
    }
  }
}

TEST_CASE("moments for the autoregression alone teach it, and nothing else") {
  std::vector<AskedMoment> moments = all_asked(0, 80, 5e-3);
  const TrainedForecasts alone = TrainedForecasts::train(moments, kLevel);
  for (std::uint64_t k = 400; k < 480; ++k) {
    moments.push_back(moment(k));
    moments.back().for_autoregression_only = true;
    moments.back().moment.next[2] += 0.05;
  }
  const TrainedForecasts both = TrainedForecasts::train(moments, kLevel);
  const AskedMoment one = asked(8000, 5e-3);
  const auto said = alone.say(one), with = both.say(one);
  for (std::size_t p = 0; p < said.size(); ++p) {
    CAPTURE(said[p].predictor);
    if (!is_plain(said[p].predictor) || said[p].parts.empty()) continue;
    CHECK(with[p].mean == said[p].mean);
    CHECK(with[p].parts[0].deviations == said[p].parts[0].deviations);
  }
  CHECK_FALSE(both.autoregression().predict(one.moment.seen, {}) ==
              alone.autoregression().predict(one.moment.seen, {}));
}

TEST_CASE("one component alone is corrected too, and a level one as its mirror image is") {
  const auto along = [](std::uint64_t number) {
    TrainingMoment one = bending(number).moment;
    const Eigen::MatrixXd x = one.seen.positions.leftCols<1>();
    const Eigen::RowVectorXd next = one.next.head<1>();
    one.seen.positions = x;
    one.seen.up = -1;
    one.next = next;
    return one;
  };
  std::vector<TrainingMoment> moments;
  for (std::uint64_t k = 0; k < 300; ++k) moments.push_back(along(k));
  for (const Components& components : {Components{}, Components{.level = {0}}}) {
    const Autoregression trained = Autoregression::fit(moments, components);
    REQUIRE(trained.correction().is_fitted());
    SeenMotion seen = along(4000).seen;
    const Eigen::RowVectorXd forecast = trained.predict(seen, {});
    CHECK(forecast.allFinite());
    seen.positions = -seen.positions;
    if (!components.level.empty()) CHECK((trained.predict(seen, {}) + forecast).norm() < 1e-9);
  }
}
