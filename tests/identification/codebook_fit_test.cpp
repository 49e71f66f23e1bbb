#include <Eigen/QR>
#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/identification/files/fit_files.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/problem/fit_config.h"
#include "synthetic.h"

using namespace samara::identification;
using namespace samara;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

constexpr double kEnd = 2.0;

/// Uniform acceleration, x = v0 t + a t^2/2 and v = v0 + a t: exact in rank 2, on three nodes of time and two
/// of each parameter.
codebooks::Codebook uniform_acceleration(const std::string& name) {
  const pgd::Axis time = pgd::Axis::chebyshev({"t", "s", pgd::AxisRole::time}, 0.0, kEnd, 3);
  const pgd::Axis a = pgd::Axis::p1({"a", "m/s^2", pgd::AxisRole::parameter}, -1.0, 5.0, 2);
  const pgd::Axis v0 = pgd::Axis::p1({"v(0)", "m/s", pgd::AxisRole::initial}, -1.0, 1.0, 2);
  const Eigen::VectorXd one = Eigen::VectorXd::Ones(2);
  const auto field = [&](const std::string& output, const std::string& unit, const Eigen::VectorXd& by_v0,
                         const Eigen::VectorXd& by_a) {
    Eigen::MatrixXd in_time(3, 2);
    in_time << by_v0, by_a;
    Eigen::MatrixXd in_a(2, 2);
    in_a << one, a.nodes();
    Eigen::MatrixXd in_v0(2, 2);
    in_v0 << v0.nodes(), one;
    return pgd::SeparatedField({time, a, v0}, {{output, unit}}, {in_time, in_a, in_v0},
                               Eigen::RowVector2d(1.0, 1.0));
  };
  const Eigen::VectorXd t = time.nodes();
  const codebooks::Piece piece(
      {field("x", "m", t, t.cwiseAbs2() / 2.0), field("v", "m/s", Eigen::VectorXd::Ones(3), t)});
  codebooks::ModelDescription model;
  model.name = name;
  return codebooks::Codebook(model, {piece});
}

std::vector<Capture> noisy_captures() {
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal;
  const std::vector<double> times = even_times(15, kEnd);
  const Eigen::ArrayXd t = Eigen::Map<const Eigen::ArrayXd>(times.data(), 15);
  std::vector<Capture> captures;
  for (int c = 0; c < 4; ++c) {
    captures.push_back(
        make_capture(fmt::format("{}", c), times, (0.1 * c * t + 0.5 * 1.7 * t * t + 0.2 * c).matrix()));
    add_noise(captures.back(), 1e-2, random);
  }
  return captures;
}

}  // namespace

TEST_CASE("a fit through a codebook equals linear least squares where the model is linear") {
  const codebooks::Codebook book = uniform_acceleration("uniform acceleration");
  const auto family = codebook_trajectories(book);
  CHECK(family->info().source == "codebook");
  CHECK(family->info().end_time == kEnd);
  CHECK(family->info().translations.empty());  // no model of Samara has that name

  const std::vector<Capture> captures = noisy_captures();
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.unknowns.offsets = {"x"};
  options.compared.span = kEnd;
  const FitResult result = fit(*family, captures, options);
  REQUIRE(result.status == Termination::converged);

  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(60, 9);
  Eigen::VectorXd measured(60);
  for (Eigen::Index c = 0; c < 4; ++c) {
    const Capture& capture = captures[static_cast<std::size_t>(c)];
    J.block(15 * c, 0, 15, 1) = capture.times.cwiseAbs2() / 2.0;
    J.block(15 * c, 1 + 2 * c, 15, 1) = capture.times;
    J.block(15 * c, 2 + 2 * c, 15, 1).setOnes();
    measured.segment(15 * c, 15) = capture.channels[0].values;
  }
  const Eigen::VectorXd solution = J.colPivHouseholderQr().solve(measured);
  CHECK_THAT(result.coefficients[0].value, WithinRel(solution[0], 1e-8));
  for (Eigen::Index c = 0; c < 4; ++c) {
    const auto& nuisances = result.captures[static_cast<std::size_t>(c)].nuisances;
    CHECK_THAT(nuisances[0].value, WithinAbs(solution[1 + 2 * c], 1e-8));
    CHECK_THAT(nuisances[1].value, WithinAbs(solution[2 + 2 * c], 1e-8));
  }
}

TEST_CASE("a codebook answers with the values and derivatives of its outputs, in the order asked for") {
  const codebooks::Codebook book = uniform_acceleration("uniform acceleration");
  const auto source = codebook_trajectories(book)->at({0.0, 0.5, 2.0}, {"v", "x"});
  Eigen::MatrixXd values(3, 2);
  Eigen::MatrixXd derivatives(3, 4);
  REQUIRE(source->evaluate(std::vector{3.0, -0.5}, values, &derivatives));
  for (Eigen::Index row = 0; row < 3; ++row) {
    const double t = std::vector{0.0, 0.5, 2.0}[static_cast<std::size_t>(row)];
    CHECK_THAT(values(row, 0), WithinAbs(-0.5 + 3.0 * t, 1e-13));
    CHECK_THAT(values(row, 1), WithinAbs(-0.5 * t + 1.5 * t * t, 1e-13));
    CHECK_THAT(derivatives(row, 0), WithinAbs(t, 1e-13));            // dv/da
    CHECK_THAT(derivatives(row, 1), WithinAbs(t * t / 2.0, 1e-13));  // dx/da
    CHECK_THAT(derivatives(row, 2), WithinAbs(1.0, 1e-13));          // dv/dv0
    CHECK_THAT(derivatives(row, 3), WithinAbs(t, 1e-13));            // dx/dv0
  }
  Eigen::MatrixXd plain(3, 2);
  REQUIRE(source->evaluate(std::vector{3.0, -0.5}, plain, nullptr));
  CHECK((plain - values).cwiseAbs().maxCoeff() < 1e-13);
}

TEST_CASE("symmetries come from the model of the codebook's name") {
  const auto book = uniform_acceleration("vertical_fall");
  CHECK(codebook_trajectories(book)->info().translations == std::vector<std::string>{"x"});
  const ConfigNames names = config_names(book);
  CHECK(names.coordinates == std::map<std::string, std::string>{{"a", "m/s^2"}, {"v(0)", "m/s"}});
  CHECK(names.outputs == std::map<std::string, std::string>{{"v", "m/s"}, {"x", "m"}});
}

TEST_CASE("captures longer than the codebook are refused") {
  const auto book = uniform_acceleration("vertical_fall");
  std::vector<Capture> captures = noisy_captures();
  captures[2].times *= 1.1;
  CHECK_THROWS_AS(fit(*codebook_trajectories(book), captures), ArgumentError);
}

TEST_CASE("steps of an integrator are refused where a codebook has the trajectories") {
  const auto book = std::make_shared<const codebooks::Codebook>(uniform_acceleration("vertical_fall"));
  const FitRequest request{.book = book, .measured = noisy_captures(), .config_text = "step = 1e59\n"};
  CHECK_THROWS_WITH(fit_files(request), Catch::Matchers::Contains("step: ") &&
                                            Catch::Matchers::Contains("\"vertical_fall\", was expected"));
}
