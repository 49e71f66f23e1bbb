#include <cmath>
#include <complex>
#include <limits>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/streams.h"
#include "samara/identification/forecasts/autoregression.h"
#include "samara/identification/forecasts/recent_motion.h"
#include "samara/identification/forecasts/turning_prediction.h"

using namespace samara::identification;

namespace {

constexpr int kViewedFrames = 16;
constexpr double kViewedInterval = 0.02, kViewedAhead = 0.1;
constexpr double kNotShown = std::numeric_limits<double>::quiet_NaN();
const Components kLevelOfGliding = {.level = {0, 1}};

/// Tilted plates that fall and glide: places show where to, and as views begin to grow they glide faster from the last
/// frame on. Along an axis a camera sees how much of the tilt is along it.
TrainingMoment gliding(std::uint64_t number) {
  samara::Stream stream(71, number);
  const double heading = 6.28 * stream.uniform(), speed = 0.1 + 0.1 * stream.uniform(),
               tilt = 0.2 + stream.uniform();
  const Eigen::RowVector3d velocity(speed * std::cos(heading), speed * std::sin(heading), -0.2);
  SeenMotion seen{
      .times = Eigen::VectorXd::LinSpaced(kViewedFrames, 0.0, (kViewedFrames - 1) * kViewedInterval),
      .positions = Eigen::MatrixXd(kViewedFrames, 3),
      .up = 2,
      .views = Eigen::MatrixXcd(kViewedFrames, 1)};
  for (int k = 0; k < kViewedFrames; ++k) {
    seen.positions.row(k) = velocity * seen.times[k];
    for (double& one : seen.positions.row(k)) one += 1e-4 * stream.normal();
    const std::complex<double> shown(std::pow(std::cos(heading), 2), std::pow(std::sin(heading), 2));
    seen.views(k, 0) = tilt * seen.times[k] * shown;
  }
  const double glide = 0.2 * tilt * kViewedAhead;
  const Eigen::RowVector3d next = seen.positions.row(kViewedFrames - 1) + kViewedAhead * velocity +
                                  glide * Eigen::RowVector3d(std::cos(heading), std::sin(heading), -0.5);
  return {.cluster = static_cast<int>(number / 4), .seen = std::move(seen), .next = next};
}

Autoregression of_gliding(bool with_views) {
  std::vector<TrainingMoment> moments;
  for (std::uint64_t k = 0; k < 240; ++k) {
    moments.push_back(gliding(k));
    if (!with_views) moments.back().seen.views.resize(0, 0);
  }
  return Autoregression::fit(moments, kLevelOfGliding);
}

double rms_of_gliding(const Autoregression& trained) {
  double squares = 0.0;
  for (std::uint64_t k = 1000; k < 1060; ++k) {
    const TrainingMoment one = gliding(k);
    squares += (trained.predict(one.seen, {}) - one.next).squaredNorm();
  }
  return std::sqrt(squares / 60.0);
}

}  // namespace

TEST_CASE("views some intervals back lie on lines between frames that show them, and stay at the ends") {
  SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0),
                  .positions = Eigen::MatrixXd::Ones(11, 3),
                  .views = Eigen::MatrixXcd(11, 2)};
  seen.views.col(0) = std::complex<double>(2.0, -1.0) * seen.times;
  seen.views.col(1).setConstant({0.5, 3.0});
  for (const int hidden : {0, 4, 5, 10}) seen.views(hidden, 1) = kNotShown;
  const Eigen::MatrixXcd back = views_back(seen, Eigen::Vector4d(0.0, 2.5, 5.5, 12.0));
  const Eigen::Vector4d expected(0.9, 0.75, 0.45, 0.1);  // s: frames 0 and 10 do not show both
  CHECK((back.col(0) - std::complex<double>(2.0, -1.0) * expected).norm() < 1e-12);
  CHECK((back.col(1).array() - std::complex<double>(0.5, 3.0)).abs().maxCoeff() < 1e-12);
  seen.views.setConstant(kNotShown);
  CHECK(views_back(seen, Eigen::Vector2d(0.0, 1.0)).array().isNaN().all());
  seen.views.conservativeResize(12, 2);
  CHECK_THROWS_WITH(views_back(seen, Eigen::Vector2d(0.0, 1.0)), Catch::Contains("12 frames of views"));
}

TEST_CASE("a turning prediction that was not fitted refuses to foretell") {
  const SeenMotion seen{.times = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0),
                        .positions = Eigen::MatrixXd::Ones(11, 3)};
  CHECK_THROWS_WITH(TurningPrediction().moved(seen, {}), Catch::Contains("before it was fitted"));
  CHECK_THROWS_WITH(TurningPrediction().moved_without(0, seen, {}), Catch::Contains("before it was fitted"));
  CHECK_THROWS_WITH(TurningPrediction::fit({}, {.level = {0}}, 11.0),
                    Catch::Contains("1 level components; 2"));
}

TEST_CASE("what views tell of the way ahead is learned") {
  const Autoregression trained = of_gliding(true), blind = of_gliding(false);
  REQUIRE(trained.turning().sees_views());
  CHECK_FALSE(blind.turning().sees_views());
  CHECK(rms_of_gliding(trained) < 0.5 * rms_of_gliding(blind));
  CHECK(trained.turning().share() == 1.0);
  // A quarter turn exchanges the views, and the forecast turns.
  for (std::uint64_t k = 2000; k < 2010; ++k) {
    const SeenMotion seen = gliding(k).seen;
    SeenMotion turned = seen;
    turned.positions.col(0) = -seen.positions.col(1);
    turned.positions.col(1) = seen.positions.col(0);
    turned.views.real() = seen.views.imag();
    turned.views.imag() = seen.views.real();
    const Eigen::RowVectorXd said = trained.predict(seen, {}), again = trained.predict(turned, {});
    CHECK((again - Eigen::RowVector3d(-said[1], said[0], said[2])).norm() < 1e-9);
  }
}

TEST_CASE("a motion that shows no views is forecast without the prediction that looks at them") {
  const Autoregression trained = of_gliding(true);
  TrainingMoment one = gliding(3000);
  const Eigen::RowVectorXd seen = trained.predict(one.seen, {});
  one.seen.views.setConstant(kNotShown);
  CHECK_FALSE(trained.turning().is_shown_by(one.seen));
  const Eigen::RowVectorXd hidden = trained.predict(one.seen, {});
  CHECK(hidden.allFinite());
  CHECK((hidden - seen).norm() > 1e-6);
  one.seen.views.resize(0, 0);
  CHECK(trained.predict(one.seen, {}) == hidden);
}

TEST_CASE("views that not all training shows are not looked at") {
  std::vector<TrainingMoment> moments;
  for (std::uint64_t k = 0; k < 240; ++k) moments.push_back(gliding(k));
  moments[7].seen.views.resize(0, 0);
  CHECK_FALSE(Autoregression::fit(moments, kLevelOfGliding).turning().sees_views());
}

TEST_CASE("views that tell nothing are not looked at") {
  std::vector<TrainingMoment> moments;
  samara::Stream stream(72, 0);
  for (std::uint64_t k = 0; k < 240; ++k) {
    moments.push_back(gliding(k));
    SeenMotion& seen = moments.back().seen;
    for (int frame = 0; frame < kViewedFrames; ++frame) {
      const double along_x = stream.normal();
      seen.views(frame, 0) = {along_x, stream.normal()};
    }
  }
  CHECK_FALSE(Autoregression::fit(moments, kLevelOfGliding).turning().sees_views());
}
