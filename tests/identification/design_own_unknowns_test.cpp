/// What a capture's own unknowns cost a design: start, offset, camera, attitude.
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "closed_form_family.h"
#include "samara/identification/design/design.h"
#include "samara/identification/fit/fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::WithinRel;

namespace {

/// A body that turns about its z axis: q(t) = q(0) (cos(w t/2), 0, 0, sin(w t/2)).
class SpinFamily final : public ClosedFormFamily {
 public:
  SpinFamily() : ClosedFormFamily(quaternions(), motion) {}

 private:
  static samara::models::FamilyInfo quaternions() {
    samara::models::FamilyInfo info{.model = "spin", .coordinates = {{"w", "rad/s", false, 0.1, 20.0}}};
    for (const char* name : {"qw", "qx", "qy", "qz"}) {
      info.coordinates.push_back({std::string(name) + "(0)", "1", true, -1.0, 1.0});
      info.outputs.push_back({name, "1"});
      info.attitude.emplace_back(name);
    }
    return info;
  }

  static void motion(std::span<const double> q, double t, Eigen::RowVectorXd& values,
                     Eigen::RowVectorXd* derivatives) {
    const Eigen::Vector4d start(q[1], q[2], q[3], q[4]);
    const double c = std::cos(0.5 * q[0] * t), s = std::sin(0.5 * q[0] * t);
    Eigen::Matrix4d turn;  // q(0) -> q(t)
    turn << c, 0, 0, -s, 0, c, s, 0, 0, -s, c, 0, s, 0, 0, c;
    Eigen::Matrix4d rate;
    rate << -s, 0, 0, -c, 0, -s, c, 0, 0, -c, -s, 0, c, 0, 0, -s;
    values = (turn * start).transpose();
    if (!derivatives) return;
    derivatives->head<4>() = 0.5 * t * (rate * start).transpose();
    for (Eigen::Index k = 0; k < 4; ++k) derivatives->segment<4>(4 * (k + 1)) = turn.col(k).transpose();
  }
};

/// A body of SpinFamily that turns by 5 rad/s, seen with normal noise about each axis.
Capture spinning(const std::string& id, double noise, std::mt19937_64& random) {
  const std::vector<double> times = even_times(200, 2.0);
  std::normal_distribution<double> normal(0.0, noise);
  Eigen::MatrixX4d seen(200, 4);
  for (Eigen::Index k = 0; k < 200; ++k) {
    const Eigen::Vector3d turn(normal(random), normal(random), normal(random));
    const Eigen::Quaterniond q =
        Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(5.0 * times[static_cast<std::size_t>(k)], Eigen::Vector3d::UnitZ()) *
        Eigen::AngleAxisd(turn.norm(), turn.normalized());
    seen.row(k) << q.w(), q.x(), q.y(), q.z();
  }
  Capture capture = make_capture(id, times, seen.col(0));
  capture.channels = {
      {"qw", "1", seen.col(0)}, {"qx", "1", seen.col(1)}, {"qy", "1", seen.col(2)}, {"qz", "1", seen.col(3)}};
  return capture;
}

}  // namespace

TEST_CASE("a design eliminates speed, offset and camera of a capture as the next fit does") {
  // Two routes. Noise levels of 1000 frames and 1200 are known to 2.5 % and less.
  const BrakedFamily family;
  const std::vector<double> times = even_times(200, 2.0);
  FitOptions options{.loss = {.kind = LossKind::none, .length_scale = 1e-3}};
  SECTION("with an unknown scale of lengths") {
    options.camera.scale = 0.02;
  }
  SECTION("with speeds that are known beforehand") {
    options.priors.coordinates["v(0)"] = {.mean = 1.0, .deviation = 2e-3};
  }
  std::mt19937_64 random(6);
  const auto seen = [&](double v0) {
    Capture capture = make_capture(fmt::format("{}", v0), times, BrakedFamily::depths(1.1, v0, times));
    add_noise(capture, 1e-3, random);
    return capture;
  };
  std::vector<Capture> captures;
  for (const double v0 : {0.998, 0.999, 1.0, 1.001, 1.002}) captures.push_back(seen(v0));
  const FitResult before = fit(family, captures, options);
  captures.push_back(seen(1.0005));
  const FitResult after = fit(family, captures, options);
  const std::vector<std::vector<double>> release = {{1.0}};
  const Design design = assess_releases(family, before, release);
  CHECK_FALSE(design.errors_are_clustered);
  CHECK_THAT(design.coefficients[0].expected, WithinRel(*after.coefficients[0].naive_standard_error, 0.08));
}

TEST_CASE("a design counts an attitude by the turn about each axis") {
  constexpr double kSpinError = 0.5, kTurnNoise = 0.02;
  constexpr int kFrames = 21;
  const FitOptions setup{.compared = {.outputs = {"qw", "qx", "qy", "qz"}},
                         .unknowns = {.shared = {"w"}, .per_capture = {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}}};
  FitResult fitted{.status = samara::Termination::converged, .message = "converged", .model = "spin"};
  fitted.setup = setup;
  fitted.coefficients = {{"w", "rad/s", 5.0, 0.1, 20.0, {}, kSpinError}};
  fitted.residuals = {{"attitude", "rad", std::sqrt(3.0) * kTurnNoise}};  // of the whole turn
  const Design design =
      design_experiment(SpinFamily(), fitted, {.duration = 2.0, .frames = kFrames, .draws = 1});
  // The start is free, so what tells the rate is how far times lie from their mean: var = sigma^2/sum (t -
  // mean)^2.
  double spread = 0.0;
  for (int k = 0; k < kFrames; ++k) spread += std::pow(0.1 * k - 1.0, 2);
  const double information = 1.0 / (kSpinError * kSpinError) + spread / (kTurnNoise * kTurnNoise);
  CHECK_THAT(design.coefficients[0].expected, WithinRel(1.0 / std::sqrt(information), 1e-6));
  REQUIRE(design.outputs.size() == 1);
  CHECK(design.outputs[0].output == "attitude");
  CHECK_THAT(design.outputs[0].without, WithinRel(1.0, 1e-9));
}

TEST_CASE("a design takes the noise of attitudes about each axis from the turns that a fit left") {
  constexpr double kTurnNoise = 0.02;
  std::mt19937_64 random(8);
  const std::vector captures = {spinning("a", kTurnNoise, random), spinning("b", kTurnNoise, random)};
  FitOptions options;
  options.loss = {.kind = LossKind::none, .attitude_scale = kTurnNoise};
  options.starts.initial["w"] = 5.0;
  options.starts.count = 1;
  const FitResult fitted = fit(SpinFamily(), captures, options);
  REQUIRE(fitted.is_usable());
  const std::vector<std::vector<double>> release = {{1.0, 0.0, 0.0, 0.0}};
  const Design design = assess_releases(SpinFamily(), fitted, release);
  REQUIRE(design.outputs.size() == 1);
  // Of 1200 values a level is known to 2 %.
  CHECK_THAT(design.outputs[0].noise, WithinRel(kTurnNoise, 0.08));
}

TEST_CASE("attitudes that cannot be chosen are held at the mean of turns, of which q and -q are one") {
  FitResult fitted{.status = samara::Termination::converged, .message = "converged", .model = "spin"};
  fitted.setup.compared.outputs = {"qw", "qx", "qy", "qz"};
  fitted.setup.unknowns = {.shared = {"w"}, .per_capture = {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}};
  fitted.coefficients = {{"w", "rad/s", 5.0, 0.1, 20.0, {}, 0.5}};
  fitted.noise = {{.outputs = {"attitude"}, .unit = "rad", .value = 0.02, .estimated = true}};
  // Turns by 0.8 and 1.2 rad about x.
  for (const auto& [half, sign] : {std::pair{0.4, 1.0}, std::pair{0.6, -1.0}}) {
    CaptureFit capture;
    capture.nuisances = {{"qw(0)", "1", sign * std::cos(half)},
                         {"qx(0)", "1", sign * std::sin(half)},
                         {"qy(0)", "1", 0.0},
                         {"qz(0)", "1", 0.0}};
    fitted.captures.push_back(capture);
  }
  const Design design = design_experiment(SpinFamily(), fitted,
                                          {.duration = 2.0, .frames = 21, .release = {"qz(0)"}, .draws = 1});
  REQUIRE(design.coordinates.size() == 4);
  CHECK(design.coordinates[0].lower == design.coordinates[0].upper);
  CHECK_THAT(design.coordinates[0].lower, WithinRel(std::cos(0.5), 1e-12));
  CHECK_THAT(design.coordinates[1].lower, WithinRel(std::sin(0.5), 1e-12));
}
