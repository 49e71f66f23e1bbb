/// Captures whose camera has another scale and other axes than the model.
#include "samara/identification/problem/camera.h"

#include <algorithm>
#include <array>

#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "plate_captures.h"
#include "residual_derivatives.h"
#include "samara/base/errors.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/fit/fitted_motion.h"
#include "samara/identification/problem/fit_config.h"
#include "samara/identification/problem/segment_residual.h"
#include "samara/models/integrators/integrate.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/step_trajectories.h"
#include "samara/pgd/tensors/random.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using samara::models::find_model;

namespace {

constexpr double kCameraNoise = 0.005;
constexpr double kScale = 1.03;
const double kTurn = 2.0 * M_PI / 180.0;

std::map<std::string, double> held() {
  return {{"inertia_ratio", 1.4}, {"beta", 1.0 / 14.0}, {"B", 1.0}, {"C_T", 1.2}};
}

const std::map<std::string, double>& camera_truth() {
  static const std::map<std::string, double> values = {{"C_R", 3.14159}, {"A", 1.4}, {"mu1", 0.2}};
  return values;
}

/// A tumbling plate from time `begin` of its motion on, seen by a camera.
Capture plate(double begin, double scale, double turn, std::uint64_t seed) {
  std::map<std::string, double> values = held();
  values.insert(camera_truth().begin(), camera_truth().end());
  const std::vector<double> times = plate_times(60, begin);
  Eigen::MatrixXd states = plate_states(values, times);
  const Eigen::VectorXd x = states.col(4).array() - states(0, 4) + 0.5;
  const Eigen::VectorXd y = states.col(5).array() - states(0, 5) - 0.2;
  states.col(3).array() += turn;
  states.col(4) = scale * (std::cos(turn) * x - std::sin(turn) * y);
  states.col(5) = scale * (std::sin(turn) * x + std::cos(turn) * y);
  Capture capture = seen_plate(times, states, kCameraNoise, seed);
  capture.id = fmt::format("plate at {}", begin);
  return capture;
}

std::unique_ptr<samara::models::TrajectoryFamily> plate_family(
    std::map<std::string, samara::models::Interval> box = {}) {
  for (const auto& [name, value] : camera_truth()) box[name] = {0.3 * value, 3.0 * value};
  for (const char* name : {"vx(0)", "vy(0)", "w(0)"}) box[name] = {-8.0, 8.0};
  box["theta(0)"] = {-60.0, 60.0};
  return step_trajectories(find_model("falling_plate_nd"), held(), box, 0.02);
}

FitOptions plate_options(bool with_camera) {
  FitOptions options;
  options.loss = {.kind = LossKind::none,
                  .scales = {{"x", kCameraNoise}, {"y", kCameraNoise}, {"theta", kCameraNoise}}};
  options.segments.length = 1.0;
  options.starts.count = 1;
  if (with_camera) options.camera = {.scale = 0.05, .rotation = 0.05, .angles = {{"theta"}}};
  return options;
}

const Nuisance& camera_nuisance(const CaptureFit& capture, const std::string& name) {
  return *std::ranges::find(capture.nuisances, name, &Nuisance::name);
}

/// A card in space of which place and attitude are seen.
std::map<std::string, double> card_held() {
  return {{"a", 0.035},   {"b", 0.02},     {"c", 1e-4},   {"density", 1200.0},
          {"C_D0", 0.05}, {"C_D90", 0.31}, {"C_T", 0.91}, {"C_w", 2.0}};
}

std::unique_ptr<samara::models::TrajectoryFamily> seen_card_family() {
  std::map<std::string, samara::models::Interval> box = {{"C_R", {0.3, 3.0}}};
  for (const char* name : {"x(0)", "y(0)", "z(0)"}) box[name] = {-50.0, 50.0};
  for (const char* name : {"qw(0)", "qx(0)", "qy(0)", "qz(0)"}) box[name] = {-1.1, 1.1};
  for (const char* name : {"ux(0)", "uy(0)", "uz(0)"}) box[name] = {-20.0, 20.0};
  for (const char* name : {"wx(0)", "wy(0)", "wz(0)"}) box[name] = {-300.0, 300.0};
  return step_trajectories(find_model("immersed_body"), card_held(), box, 1e-3);
}

/// A falling card, seen by a camera that is turned.
Capture card(const std::vector<double>& turn, double spin, std::uint64_t seed) {
  std::map<std::string, double> values = card_held();
  values.insert({{"C_R", 1.2}, {"qw(0)", 0.9}, {"qx(0)", std::sqrt(0.19)}, {"ux(0)", 0.4}, {"wx(0)", spin}});
  const samara::models::ParametricModel model(find_model("immersed_body"), values, {});
  const std::vector<double> times = even_times(60, 0.25);
  const Eigen::MatrixXd states = samara::models::integrate(model, {}, times).states;
  const auto& names = model.model().info().states;
  const auto column = [&](const char* name) {
    return std::ranges::find(names, name, &samara::models::StateInfo::name) - names.begin();
  };
  const CameraView view(3, 0.0, turn);
  samara::pgd::Random random(seed);
  Capture capture;
  capture.id = fmt::format("card at {} rad/s", spin);
  capture.times = Eigen::Map<const Eigen::VectorXd>(times.data(), 60);
  const Eigen::MatrixXd places = states.middleCols(column("x"), 3) * view.map.transpose();
  const Eigen::MatrixXd attitudes = states.middleCols(column("qw"), 4) * view.on_attitude().transpose();
  const std::array place_names = {"x", "y", "z"};
  for (Eigen::Index k = 0; k < 3; ++k)
    capture.channels.push_back({place_names[static_cast<std::size_t>(k)], "m", places.col(k)});
  const std::array attitude_names = {"qw", "qx", "qy", "qz"};
  for (Eigen::Index k = 0; k < 4; ++k)
    capture.channels.push_back({attitude_names[static_cast<std::size_t>(k)], "1", attitudes.col(k)});
  for (std::size_t k = 0; k < 7; ++k) {
    // 0.3 mm, and 0.5 degrees, which is twice the change of a quaternion.
    for (double& value : capture.channels[k].values) value += (k < 3 ? 3e-4 : 0.0044) * random.normal();
  }
  return capture;
}

}  // namespace

TEST_CASE("a turn of the camera is the same for places and for attitudes") {
  for (const double size : {1e-9, 3e-3, 0.02, 1.5}) {
    const std::vector<double> turn = {0.3 * size, -0.7 * size, 0.5 * size};
    const CameraView view(3, 0.1, turn);
    const Eigen::Vector3d r(turn[0], turn[1], turn[2]);
    const Eigen::Matrix3d expected = Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix();
    CHECK((view.map - 1.1 * expected).norm() < 1e-14);
    const Eigen::Quaterniond q(view.turn[0], view.turn[1], view.turn[2], view.turn[3]);
    CHECK((q.toRotationMatrix() - expected).norm() < 1e-14);
    const Eigen::Vector4d p(0.5, 0.1, -0.7, 0.5);
    CHECK((view.on_attitude() * p - CameraView::on_turn(p) * view.turn).norm() < 1e-15);
    for (int k = 0; k < 3; ++k) {
      std::vector<double> up = turn, down = turn;
      constexpr double kStep = 1e-5;
      up[static_cast<std::size_t>(k)] += kStep;
      down[static_cast<std::size_t>(k)] -= kStep;
      const CameraView above(3, 0.1, up), below(3, 0.1, down);
      // Differences: rounding of 1e-11, truncation of 1e-10.
      CHECK((view.by_turn[static_cast<std::size_t>(k)] - (above.map - below.map) / (2.0 * kStep)).norm() <
            1e-9);
      CHECK((view.turn_by_turn.col(k) - (above.turn - below.turn) / (2.0 * kStep)).norm() < 1e-9);
    }
  }
}

TEST_CASE("residuals seen by a camera have the derivatives of differences") {
  // A plate, and a body with its attitude.
  const auto check = [](const samara::models::TrajectoryFamily& family, const std::vector<Capture>& captures,
                        const FitOptions& options, const Eigen::VectorXd& shared) {
    const FitProblem problem = make_problem(family.info(), captures, options);
    REQUIRE(problem.segments.size() > 1);
    SegmentResidual residual(family, problem, problem.segments[0]);
    samara::pgd::Random random(5);
    Eigen::VectorXd own(problem.own_count()), next(problem.own_count());
    for (double& value : own) value = 0.3 + 0.1 * random.normal();
    for (double& value : next) value = 0.3 + 0.1 * random.normal();
    check_derivatives(residual, shared, own, next);
  };
  check(*plate_family(), {plate(20.0, 1.0, 0.0, 1)}, plate_options(true), Eigen::Vector3d(1.3, 3.0, 0.25));

  const auto body = seen_card_family();
  Capture capture;
  capture.id = "card";
  capture.times = Eigen::VectorXd::LinSpaced(13, 0.0, 0.05);
  for (const char* name : {"x", "y", "z"}) capture.channels.push_back({name, "m", 0.1 * capture.times});
  for (const char* name : {"qw", "qx", "qy", "qz"})
    capture.channels.push_back({name, "1", Eigen::VectorXd::Constant(13, 0.5)});
  FitOptions options;
  options.segments.length = 0.025;
  options.loss.length_scale = 0.01;
  options.camera = {.scale = 0.1, .rotation = 0.1};
  check(*body, {capture}, options, Eigen::VectorXd::Constant(1, 1.3));
}

TEST_CASE("segments seen by a camera join by the way from where the motion starts, whoever says where") {
  // Where the plate starts changes nothing else: offsets join alike with x(0) = 0.7, shared or known.
  Capture capture = plate(20.0, 1.0, 0.0, 1);
  capture.labels["x0"] = "0.7";
  FitOptions options = plate_options(true);
  options.unknowns.offsets = {{"x", "y"}};
  samara::pgd::Random random(5);
  const auto somewhere = [&](int count) {
    Eigen::VectorXd values(count);
    for (double& value : values) value = 0.3 + 0.1 * random.normal();
    return values;
  };
  const auto plain_family = plate_family();
  const FitProblem plain = make_problem(plain_family->info(), std::span(&capture, 1), options);
  SegmentResidual expected(*plain_family, plain, plain.segments[0]);
  const Eigen::VectorXd own = somewhere(plain.own_count()), next = somewhere(plain.own_count());
  const Eigen::Vector3d shared(1.3, 3.0, 0.25);
  REQUIRE(expected.evaluate(shared.data(), own.data(), next.data(), false));

  const auto family = plate_family({{"x(0)", {-2.0, 2.0}}});
  for (const bool is_known : {false, true}) {
    FitOptions with_start = options;
    if (is_known) {
      with_start.unknowns.known["x(0)"] = "x0";
    } else {
      with_start.unknowns.shared = {"x(0)"};
    }
    const FitProblem problem = make_problem(family->info(), std::span(&capture, 1), with_start);
    Eigen::VectorXd values(problem.shared_count());
    values.head<3>() = shared;
    if (!is_known) {
      REQUIRE(problem.shared.at(3).name == "x(0)");
      values[3] = 0.7;
    }
    SegmentResidual residual(*family, problem, problem.segments[0]);
    REQUIRE(residual.evaluate(values.data(), own.data(), next.data(), false));
    REQUIRE(residual.join_size() > 0);
    // Rounding of steps from another place.
    CHECK((residual.residual().tail(residual.join_size()) - expected.residual().tail(residual.join_size()))
              .cwiseAbs()
              .maxCoeff() < 1e-9);
    check_derivatives(residual, values, own, next);
  }
}

TEST_CASE("a camera of another scale and other axes biases coefficients unless it is an unknown") {
  std::vector<Capture> captures;
  for (int c = 0; c < 3; ++c)
    captures.push_back(plate(20.0 + 2.3 * c, kScale, kTurn, static_cast<std::uint64_t>(c + 1)));
  const auto family = plate_family();
  const FitResult without = fit(*family, captures, plate_options(false));
  const FitOptions options = plate_options(true);
  const FitResult with = fit(*family, captures, options);
  INFO(with.message);
  CHECK(with.status == samara::Termination::converged);
  double worst_without = 0.0;
  for (std::size_t k = 0; k < with.coefficients.size(); ++k) {
    const Coefficient& c = with.coefficients[k];
    const double error = c.naive_standard_error.value();
    INFO(c.name << " = " << c.value << " +- " << error << ", without " << without.coefficients[k].value);
    // Normal errors: beyond four of them once in 16,000.
    CHECK(std::abs(c.value - camera_truth().at(c.name)) < 4.0 * error);
    worst_without =
        std::max(worst_without, std::abs(without.coefficients[k].value - camera_truth().at(c.name)) / error);
  }
  CHECK(worst_without > 5.0);
  for (const CaptureFit& capture : with.captures) {
    const Nuisance& scale = camera_nuisance(capture, "scale");
    const Nuisance& turn = camera_nuisance(capture, "turn");
    INFO(capture.id << ": " << scale.value << " +- " << scale.standard_error.value_or(0.0) << ", "
                    << turn.value << " +- " << turn.standard_error.value_or(0.0));
    CHECK(scale.unit == "1");
    CHECK(turn.unit == "rad");
    CHECK(std::abs(scale.value - kScale) < 4.0 * scale.standard_error.value());
    CHECK(std::abs(turn.value - kTurn) < 4.0 * turn.standard_error.value());
    CHECK(scale.standard_error.value() < 0.03);
    CHECK(turn.standard_error.value() < 0.03);
  }
  CHECK(with.join_defect.value() < 0.01);

  // What lies between frames looks the same to the camera.
  const CaptureFit& first = with.captures[0];
  const std::vector<double> times(first.times.begin(), first.times.end());
  const auto motion = fitted_motion(*family, options, with, 0, times, {"x", "theta"});
  REQUIRE(motion);
  // The penalty of the joins leaves that much.
  CHECK((motion->col(0) - first.model.col(1)).cwiseAbs().maxCoeff() < 0.1 * kCameraNoise);
  CHECK((motion->col(1) - first.model.col(0)).cwiseAbs().maxCoeff() < 0.1 * kCameraNoise);
}

TEST_CASE(
    "a camera that is not level is found from the way bodies fall, but not its turn about the vertical") {
  const std::vector<double> turn = {0.03, -0.02, 0.0};
  const std::vector captures = {card(turn, 12.0, 1), card(turn, -9.0, 2)};
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 3e-4};
  options.loss.attitude_scale = 0.0088;
  options.segments.length = 0.06;
  options.starts.count = 1;
  options.camera.rotation = 0.05;
  const FitResult result = fit(*seen_card_family(), captures, options);
  INFO(result.message);
  CHECK(result.status == samara::Termination::converged);
  CHECK(std::abs(result.coefficients.at(0).value - 1.2) <
        4.0 * result.coefficients[0].naive_standard_error.value());
  const std::array axes = {"x", "y", "z"};
  for (const CaptureFit& capture : result.captures) {
    for (std::size_t k = 0; k < 3; ++k) {
      const Nuisance& found = camera_nuisance(capture, fmt::format("turn about {}", axes[k]));
      INFO(capture.id << ": " << found.name << " = " << found.value << " +- "
                      << found.standard_error.value());
      CHECK(std::abs(found.value - turn[k]) < 4.0 * found.standard_error.value());
      if (k < 2) CHECK(found.standard_error.value() < 0.03);
    }
  }
  CHECK_THAT(text_of(result.warnings), Contains("say nothing of the turn about z of their cameras"));
}

TEST_CASE("what captures say nothing of is known as well as beforehand, and said so") {
  // In a closed form without gravity, a scale of lengths is a faster start.
  const BrakedFamily family;
  std::mt19937_64 random(3);
  std::vector<Capture> captures;
  const std::vector<double> times = even_times(25, 1.5);
  for (int c = 0; c < 3; ++c) {
    captures.push_back(
        make_capture(fmt::format("{}", c), times, BrakedFamily::depths(1.4, 1.0 + 0.1 * c, times)));
    add_noise(captures.back(), 2e-3, random);
  }
  FitOptions options;
  options.loss = {.kind = LossKind::none, .length_scale = 2e-3};
  const double k = fit(family, captures, options).coefficients.at(0).value;
  options.camera.scale = 0.03;
  const FitResult result = fit(family, captures, options);
  CHECK(result.coefficients.at(0).value == Approx(k).epsilon(1e-4));
  CHECK(camera_nuisance(result.captures[0], "scale").value == Approx(1.0).margin(1e-3));
  // In units of the noise as it turned out: 75 values.
  CHECK(camera_nuisance(result.captures[0], "scale").standard_error.value() == Approx(0.03).epsilon(0.3));
  CHECK_THAT(text_of(result.warnings),
             Contains("say nothing of the scale of their cameras that was not known beforehand"));
}

TEST_CASE("cameras are refused that have no place to look at") {
  const std::vector captures = {plate(20.0, 1.0, 0.0, 1)};
  FitOptions options = plate_options(true);
  options.camera.axes = {"x"};
  CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains("there are 1 (x); 2 or 3 outputs"));
  options.camera.axes = {"x", "Y"};
  CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains("\"Y\" is no output"));
  options = plate_options(true);
  options.camera.angles = {{"phi"}};
  CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains("\"phi\" is not among the compared"));
  options = plate_options(true);
  options.compared.outputs = {"theta"};
  CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains("none of its axes (x, y) is compared"));
  options = plate_options(true);
  options.camera.scale = -0.1;
  CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains("camera.scale is -0.1"));
}

TEST_CASE("cameras are refused whose axes are no place, whose angles are none, or of which all is known") {
  const std::vector captures = {plate(20.0, 1.0, 0.0, 1)};
  const auto refused = [&](const CameraOptions& camera, const std::string& words) {
    FitOptions options = plate_options(false);
    options.camera = camera;
    CHECK_THROWS_WITH(fit(*plate_family(), captures, options), Contains(words));
  };
  refused({.rotation = 0.1, .axes = {"x", "x"}}, "camera.axes: \"x\" stands there twice");
  refused({.rotation = 0.1, .axes = {"x", "theta"}}, "camera.axes: \"theta\" is in 1; coordinates");
  refused({.rotation = 0.1, .angles = {{"theta", "theta"}}}, "camera.angles: \"theta\" stands there twice");
  refused({.rotation = 0.1, .angles = {{"x"}}}, "camera.angles: \"x\" is one of camera.axes");
  refused({.axes = {"x", "y"}}, "camera: neither scale nor rotation");
  refused({.angles = {{"theta"}}}, "camera: neither scale nor rotation");

  // Where outputs have units, those tell.
  samara::models::FamilyInfo family{
      .model = "plate",
      .outputs = {{"x", "m"}, {"y", "m"}, {"theta", "rad"}, {"vx", "m/s"}, {"C", "1"}},
      .translations = {"x", "y"}};
  const auto of_units = [&](const std::vector<std::string>& axes, const std::string& words) {
    CHECK_THROWS_WITH(camera_axes(family, {.rotation = 0.1, .axes = axes}), Contains(words));
  };
  of_units({"x", "theta"}, "camera.axes: \"theta\" is in rad");
  of_units({"x", "vx"}, "camera.axes: \"vx\" is in m/s");
  of_units({"x", "C"}, "camera.axes: \"C\" is in 1");
  CHECK(camera_axes(family, {.rotation = 0.1, .axes = {"y", "x"}}) == std::vector<std::string>{"y", "x"});
  FitProblem problem;
  for (const samara::models::FamilyOutput& output : family.outputs)
    problem.outputs.push_back({output.name, output.unit});
  FitOptions options;
  options.camera = {.rotation = 0.1, .angles = {{"vx"}}};
  CHECK_THROWS_WITH(add_camera(family, options, problem), Contains("camera.angles: \"vx\" is in m/s"));
}

TEST_CASE("a config names what is not known of the camera") {
  const ConfigNames names = config_names(find_model("falling_plate")->info());
  const CameraOptions camera =
      parse_fit_config(
          "camera = { scale = 0.02, rotation = \"1 deg\", axes = [\"x\", \"y\"], angles = [\"theta\"] }",
          "fit.toml", names)
          .camera;
  CHECK(camera.scale.value() == 0.02);
  CHECK(camera.rotation.value() == Approx(M_PI / 180.0));
  CHECK(camera.axes == std::vector<std::string>{"x", "y"});
  CHECK(camera.angles.value() == std::vector<std::string>{"theta"});
  CHECK_THROWS_WITH(parse_fit_config("camera = { scale = 0 }", "fit.toml", names), Contains("more than 0"));
  for (const char* empty : {"", "axes = [\"x\", \"y\"]"}) {
    CHECK_THROWS_WITH(parse_fit_config(fmt::format("camera = {{ {} }}", empty), "fit.toml", names),
                      Contains("camera: neither `scale` nor `rotation`"));
  }
}
