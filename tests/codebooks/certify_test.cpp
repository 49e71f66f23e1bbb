#include "samara/codebooks/certify/certify.h"

#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../models/scalar_model.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/certify/measure.h"
#include "samara/codebooks/query/query.h"
#include "samara/models/laws/registry.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;
using samara::ArgumentError;
using samara::models::ParametricModel;
using samara::pgd::Axis;
using samara::pgd::AxisRole;
using samara::pgd::SeparatedField;

namespace {

// A body without drag, v(0) free: v = v0 + a t and x = v0 t + a t^2/2, which a codebook holds exactly.
constexpr double kEnd = 0.5;
constexpr double kLargestSpeed = 2.0;

ParametricModel free_fall() {
  return ParametricModel(
      samara::models::find_model("vertical_fall"),
      {{"C_D", 0.0}, {"density", 2000.0}, {"area", 1e-3}, {"thickness", 1e-3}, {"m_a", 1e-3}}, {"v(0)"});
}

double acceleration() {
  const ParametricModel model = free_fall();
  ParametricModel::Workspace workspace = model.make_workspace();
  std::vector<double> rate(2);
  model.rhs(0.0, std::vector{0.0, 0.0}, std::vector{0.0}, rate, workspace);
  return rate[0];
}

const Axis& time_axis() {
  static const Axis axis = Axis::radau({"t", "s", AxisRole::time}, 0.0, kEnd, 3, 3);
  return axis;
}
const Axis& speed_axis() {
  static const Axis axis = Axis::chebyshev({"v(0)", "m/s", AxisRole::initial}, 0.0, kLargestSpeed, 3);
  return axis;
}

/// The exact codebook, and what a test adds to v: size * in_time(t/end) * in_speed(v0/largest).
template <class InTime, class InSpeed>
Codebook perturbed(double size, const InTime& in_time, const InSpeed& in_speed) {
  const Eigen::VectorXd& t = time_axis().nodes();
  const Eigen::VectorXd& v0 = speed_axis().nodes();
  Eigen::MatrixXd time(t.size(), 5), speed(v0.size(), 5);
  time << Eigen::VectorXd::Ones(t.size()), t, t, 0.5 * t.cwiseAbs2(), (t / kEnd).unaryExpr(in_time);
  speed << v0, Eigen::VectorXd::Ones(v0.size()), v0, Eigen::VectorXd::Ones(v0.size()),
      (v0 / kLargestSpeed).unaryExpr(in_speed);
  Eigen::MatrixXd weights(2, 5);
  const double a = acceleration();
  weights << 1.0, a, 0.0, 0.0, size,  // v
      0.0, 0.0, 1.0, a, 0.0;          // x
  ModelDescription model = sample_model();
  model.name = "vertical_fall";
  model.fixed = free_fall().fixed();
  return Codebook(model, {Piece{{SeparatedField({time_axis(), speed_axis()}, {{"v", "m/s"}, {"x", "m"}},
                                                {time, speed}, weights)}}});
}

Codebook exact() {
  return perturbed(
      0.0, [](double) { return 0.0; }, [](double) { return 0.0; });
}

Certificate certificate_of(const Codebook& book, CertifyOptions options) {
  return certify(book, free_fall(), options);
}

}  // namespace

TEST_CASE("an exact codebook has no error but the integrator's") {
  const Certificate certificate = certificate_of(exact(), {.points = 300, .tolerance = 1e-8});
  CHECK(certificate.met);
  // Each of some hundred steps errs by 1e-10 of the scales.
  CHECK(certificate.max_error < 1e-8);
  CHECK(certificate.points == 300);
  CHECK(certificate.failed_points == 0);
  CHECK(certificate.tolerance == 1e-8);
  CHECK(certificate.seed == 2026);
  CHECK(certificate.integrator_tolerance == 1e-10);
  REQUIRE(certificate.outputs.size() == 2);
  // The range over points that come within 1/300 of both ends of v(0), and the whole time.
  const double range = kLargestSpeed + acceleration() * kEnd;
  CHECK_THAT(certificate.outputs[0].range, WithinRel(range, 2.0 / 300.0));
  CHECK(certificate.outputs[0].name == "v");
  CHECK(certificate.outputs[0].unit == "m/s");
  CHECK(certificate.outputs[1].name == "x");
}

TEST_CASE("the integrator is tighter than the tolerance it certifies") {
  for (const auto& [tolerance, expected] :
       {std::pair{0.0, 1e-10}, {1e-3, 1e-10}, {1e-9, 1e-11}, {1e-10, 1e-12}, {1e-12, 1e-13}}) {
    const Certificate certificate = certificate_of(exact(), {.points = 20, .tolerance = tolerance});
    CHECK_THAT(certificate.integrator_tolerance, WithinRel(expected, 1e-12));
    if (tolerance >= 1e-10) CHECK(certificate.met);
  }
  const Certificate asked = certificate_of(exact(), {.points = 1, .integrator_tolerance = 1e-7});
  CHECK(asked.integrator_tolerance == 1e-7);
}

TEST_CASE("a known perturbation is found in size and place") {
  // 0.02 sin-like in time with its maximum 1 at t = end/2, growing with v0: largest at v0 = 2.
  const double size = 0.02;
  const Codebook book = perturbed(
      size, [](double s) { return 4.0 * s * (1.0 - s); }, [](double u) { return u; });
  const Certificate certificate = certificate_of(book, {.points = 500, .tolerance = 1e-3});
  const OutputError& v = certificate.outputs[0];
  const double range = kLargestSpeed + acceleration() * kEnd;
  CHECK_THAT(v.max, WithinRel(size / range, 0.05));
  CHECK_THAT(v.max_si, WithinRel(size, 0.05));
  CHECK_THAT(v.max, WithinRel(v.max_si / v.range, 1e-14));
  REQUIRE(v.worst.size() == 2);
  CHECK_THAT(v.worst[0], WithinAbs(kEnd / 2.0, kEnd / 20.0));
  CHECK_THAT(v.worst[1], WithinRel(kLargestSpeed, 0.05));
  CHECK(certificate.max_error == v.max);
  CHECK_FALSE(certificate.met);
  // x was left alone.
  CHECK(certificate.outputs[1].max < 1e-8);
}

TEST_CASE("mean and quantile over points of a perturbation that grows with v0 are those of u in [0, 1]") {
  // Largest over times: size u, u uniform: mean 1/2, 95 % below 0.95. Root mean square over points and times:
  // size sqrt(1/3 1/3) over that of v, whose mean square is that of u V + s A.
  const double size = 0.02;
  const auto same = [](double s) { return s; };
  const Certificate certificate =
      certificate_of(perturbed(size, same, same), {.points = 1000, .tolerance = 1.0});
  const OutputError& v = certificate.outputs[0];
  CHECK(certificate.met);
  CHECK_THAT(v.max_si, WithinRel(size, 1e-3));
  CHECK_THAT(v.mean * v.range, WithinRel(size / 2.0, 1e-3));
  CHECK_THAT(v.p95 * v.range, WithinRel(0.95 * size, 2e-3));
  const double speed = kLargestSpeed, gain = acceleration() * kEnd;
  const double mean_square = (speed * speed + gain * gain) / 3.0 + speed * gain / 2.0;
  // Times are equidistant with both ends: sums are trapezoidal but for half a weight at each end, 1/count
  // each.
  CHECK_THAT(v.rms, WithinRel(size / 3.0 / std::sqrt(mean_square), 2.0 / certificate.times));
}

TEST_CASE("tolerance is compared with the worst output, and met on equality of sides") {
  const double size = 0.02;
  const Codebook book = perturbed(
      size, [](double) { return 1.0; }, [](double) { return 1.0; });
  const double error = certificate_of(book, {.points = 50, .tolerance = 1.0}).max_error;
  CHECK(certificate_of(book, {.points = 50, .tolerance = error}).met);
  CHECK_FALSE(certificate_of(book, {.points = 50, .tolerance = std::nextafter(error, 0.0)}).met);
}

TEST_CASE("an absolute tolerance is the least range that errors are divided by") {
  const Codebook book = perturbed(
      0.02, [](double) { return 1.0; }, [](double) { return 1.0; });
  const Certificate plain = certificate_of(book, {.points = 50, .tolerance = 1.0});
  const Certificate small = certificate_of(book, {.points = 50, .tolerance = 1.0, .absolute = {{"v", 1e-3}}});
  const Certificate large =
      certificate_of(book, {.points = 50, .tolerance = 1.0, .absolute = {{"v", 100.0}}});
  CHECK(small.outputs[0].max == plain.outputs[0].max);
  CHECK(large.outputs[0].range == 100.0);
  CHECK_THAT(large.outputs[0].max, WithinRel(0.02 / 100.0, 1e-6));
  CHECK(large.outputs[1].range == plain.outputs[1].range);
}

TEST_CASE("what is nothing beside the characteristic size of a state is held to that size") {
  // A size is declared beside which all the speeds are rounding.
  const Codebook book = perturbed(
      0.02, [](double) { return 1.0; }, [](double) { return 1.0; });
  const Certificate plain = certificate_of(book, {.points = 50, .tolerance = 1.0});
  const double size = 1e13 * plain.outputs[0].range;
  const Certificate small = certificate_of(book, {.points = 50, .tolerance = 1.0, .sizes = {{"v", size}}});
  CHECK(small.outputs[0].range == size);
  CHECK_THAT(small.outputs[0].max, WithinRel(0.02 / size, 1e-6));
  CHECK(small.outputs[1].range == plain.outputs[1].range);
}

TEST_CASE("times are finer than the builder's, and hold both ends") {
  const Certificate certificate = certificate_of(exact(), {.points = 1});
  CHECK(certificate.times > 2 * time_axis().size());
  // A spike at the very end is seen.
  const Codebook spike = perturbed(
      0.1, [](double s) { return s == 1.0 ? 1.0 : 0.0; }, [](double) { return 1.0; });
  CHECK_THAT(certificate_of(spike, {.points = 10}).outputs[0].max_si, WithinRel(0.1, 1e-6));
}

TEST_CASE("a certificate does not depend on the number of threads") {
  const Codebook& book = coin_build().book;
  const ParametricModel model = model_of(book);
  const auto with = [&](int threads) {
    return certify(book, model, {.points = 333, .seed = 5, .tolerance = 1e-3, .threads = threads});
  };
  const Certificate one = with(1);
  for (const int threads : {2, 3, 0}) check_same_certificate(with(threads), one);
}

TEST_CASE("another seed takes other points, the same seed the same") {
  const Codebook& book = coin_build().book;
  const ParametricModel model = model_of(book);
  const Certificate a = certify(book, model, {.points = 100, .seed = 1});
  check_same_certificate(certify(book, model, {.points = 100, .seed = 1}), a);
  CHECK(certify(book, model, {.points = 100, .seed = 2}).max_error != a.max_error);
}

TEST_CASE("points where the integrator fails are counted, and the certificate is not met") {
  // x' = sqrt(p - t) ends at t = p: with p in [0.5, 1.5] and t up to 1, half of the points fail.
  const auto equation = std::make_shared<ScalarModel>(
      [](double t, double, double p) { return std::sqrt(p - t); }, [](double, double, double) { return 0.0; },
      [](double t, double, double p) { return 0.5 / std::sqrt(p - t); });
  const ParametricModel model(equation, {}, {"p"});
  const Axis time = Axis::radau({"t", "1", AxisRole::time}, 0.0, 1.0, 2, 2);
  const Axis p = Axis::chebyshev({"p", "1", AxisRole::parameter}, 0.5, 1.5, 3);
  const Codebook book(sample_model(),
                      {Piece{{SeparatedField({time, p}, {{"x", "1"}},
                                             {Eigen::MatrixXd::Ones(5, 1), Eigen::MatrixXd::Ones(3, 1)},
                                             Eigen::MatrixXd::Ones(1, 1))}}});
  const Certificate certificate = certify(book, model, {.points = 64, .tolerance = 1e6});
  // 64 points, one in each 64th of the interval; the integrator may also fail just beyond p = 1.
  CHECK(certificate.failed_points >= 32);
  CHECK(certificate.failed_points <= 34);
  CHECK(certificate.max_error < 1e6);
  CHECK_FALSE(certificate.met);

  // All of them.
  const Codebook short_lived(
      sample_model(),
      {Piece{{SeparatedField({time, Axis::chebyshev({"p", "1", AxisRole::parameter}, 0.1, 0.2, 3)},
                             {{"x", "1"}}, {Eigen::MatrixXd::Ones(5, 1), Eigen::MatrixXd::Ones(3, 1)},
                             Eigen::MatrixXd::Ones(1, 1))}}});
  const Certificate none = certify(short_lived, model, {.points = 10, .tolerance = 1e6});
  CHECK(none.failed_points == 10);
  CHECK_FALSE(none.met);
  CHECK(none.outputs[0].worst.empty());
  // Nothing was measured: there are no numbers that look as if something had been.
  CHECK(std::isnan(none.max_error));
  CHECK(std::isnan(none.outputs[0].max));
  CHECK(std::isnan(none.outputs[0].range));
  CHECK(none.failure != "");
  // And it is given up soon.
  int reports = 0;
  certify(short_lived, model,
          {.points = 1000, .progress = [&](const samara::Progress&) { return ++reports > 0; }});
  CHECK(reports == 1);
}

TEST_CASE("a codebook whose values overflow does not pass") {
  // Two terms of 1e308 and more: infinity, and infinity less infinity.
  for (const double second : {1.5e308, -1.5e308}) {
    const Eigen::MatrixXd time = Eigen::MatrixXd::Ones(time_axis().size(), 2);
    Eigen::MatrixXd speed(3, 2);
    speed << 0.0, 0.0, 1.0, 1.0, 2.0, 2.0;
    Eigen::MatrixXd weights(2, 2);
    weights << 1.5e308, second, 0.0, 0.0;
    ModelDescription model = sample_model();
    model.fixed = free_fall().fixed();
    const Codebook book(model, {Piece{{SeparatedField({time_axis(), speed_axis()}, {{"v", "m/s"}, {"x", "m"}},
                                                      {time, speed}, weights)}}});
    const Certificate certificate = certificate_of(book, {.points = 20, .tolerance = 1e-3});
    CHECK_FALSE(certificate.met);
    CHECK(certificate.max_error > 1e300);
    CHECK_FALSE(certificate.outputs[0].max <= 1e300);
  }
}

TEST_CASE("a certificate that is cancelled counts what it did not reach as failed") {
  int reports = 0;
  const Certificate certificate = certificate_of(
      exact(), {.points = 100, .tolerance = 1.0, .progress = [&](const samara::Progress& report) {
                  CHECK(report.stage == "certificate");
                  CHECK(report.fraction >= 0.0);
                  CHECK(report.fraction <= 1.0);
                  return ++reports < 3;
                }});
  CHECK(reports == 3);
  CHECK(certificate.failed_points > 0);
  CHECK(certificate.failed_points < 100);
  CHECK_FALSE(certificate.met);
}

TEST_CASE("a certificate without climbs asks at its points and nowhere else") {
  ModelDescription model = sample_model();
  model.name = kCommandModel;
  const Codebook book(
      model,
      {Piece{{SeparatedField({Axis::chebyshev({"q", "1", AxisRole::parameter}, 0.0, 1.0, 3)}, {{"y", "1"}},
                             {Eigen::MatrixXd::Constant(3, 1, 0.01)}, Eigen::MatrixXd::Ones(1, 1))}}});
  for (const int climbs : {0, 4}) {
    CertifyOptions options{.points = 21, .tolerance = 1e-3, .climbs = climbs};
    // Far above all others at one of the points.
    const double peak = certificate_points(book, options.points, options.seed)(0, 10);
    Eigen::Index asked = 0;
    SampledSource source;
    source.coordinates.push_back({"q", "1"});
    source.outputs.push_back({"y", "1"});
    source.answers = [&](const Eigen::MatrixXd& points, const std::vector<double>&) {
      asked += points.cols();
      SampledAnswers answers;
      answers.values = (-((points.array() - peak) / 1e-3).square()).exp();
      return answers;
    };
    CallMemory calls(source, {}, {});
    const Certificate certificate = measure(book, calls, options, Extent::all_points).certificate;
    CHECK_THAT(certificate.max_error, WithinRel(0.99, 1e-6));
    CHECK((asked == 21) == (climbs == 0));
    CHECK((certificate.climbed_points > 0) == (climbs > 0));
  }
  CHECK_THAT(error_text<ArgumentError>([&] { certificate_of(exact(), {.points = 1, .climbs = -1}); }),
             Contains("climbs is -1"));
}

TEST_CASE("a model that does not fit the codebook is refused") {
  const Codebook book = exact();
  const auto refusal = [&](const ParametricModel& model) {
    return error_text<ArgumentError>([&] { certify(book, model, {.points = 1}); });
  };
  const auto vertical = samara::models::find_model("vertical_fall");
  std::map<std::string, double> fixed = free_fall().fixed();
  CHECK_THAT(refusal(ParametricModel(vertical, fixed, {})), Contains("0 free coordinates, the codebook 1"));
  CHECK_THAT(refusal(ParametricModel(vertical, fixed, {"x(0)"})),
             Contains("\"x(0)\"") && Contains("\"v(0)\""));
  // Outputs that are no states of it.
  CHECK_THAT(error_text<ArgumentError>([&] {
               certify(four_pieces(),
                       ParametricModel(vertical, {{"density", 1.0}, {"area", 1.0}, {"thickness", 1.0}},
                                       {"C_D", "v(0)"}),
                       {.points = 1});
             }),
             Contains("output \"E\" of the codebook is not a state"));
  CHECK_THAT(error_text<ArgumentError>([&] { certificate_of(book, {.points = 0}); }),
             Contains("points is 0"));
}

TEST_CASE("the free coordinates of a model must come in the order of the codebook") {
  const Codebook& book = coin_build().book;
  const ParametricModel swapped(samara::models::find_model("vertical_fall"), book.model().fixed,
                                {"v(0)", "C_D"});
  CHECK_THAT(error_text<ArgumentError>([&] { certify(book, swapped, {.points = 1}); }),
             Contains("\"v(0)\"") && Contains("\"C_D\""));
}

TEST_CASE("the model of a codebook has its fixed values, and its coordinates free in their order") {
  const Codebook& book = coin_build().book;
  const ParametricModel model = model_of(book);
  CHECK(model.model().info().name == "vertical_fall");
  REQUIRE(model.free_count() == 2);
  CHECK(model.free()[0].name == "C_D");
  CHECK(model.free()[1].name == "v(0)");
  CHECK(model.fixed().at("density") == 6339.0);
  ModelDescription unknown = sample_model();
  unknown.name = "vertical_fal";
  const Codebook foreign(unknown, four_pieces().pieces());
  CHECK_THAT(error_text<ArgumentError>([&] { model_of(foreign); }),
             Contains("did you mean \"vertical_fall\"?"));
}

TEST_CASE("a codebook over listed values and a time that is polynomial in its root is certified") {
  // u(t) = (10/k - 1) t of (6.18), for the rate of the model; k is 1, 2 or 4 only.
  const ParametricModel model(samara::models::find_model("constant_rate"), {}, {"k"});
  const Axis time =
      Axis::legendre({"t", "s", AxisRole::time, samara::pgd::Transform::square_root}, 0.0, 1.0, 5);
  const Axis k = Axis::discrete({"k"}, Eigen::Vector3d(1.0, 2.0, 4.0));
  ParametricModel::Workspace workspace = model.make_workspace();
  Eigen::VectorXd rates(3);
  for (Eigen::Index i = 0; i < 3; ++i) {
    std::vector<double> rate(1);
    model.rhs(0.0, std::vector{0.0}, std::vector{k.nodes()[i]}, rate, workspace);
    rates[i] = rate[0];
  }
  ModelDescription description = sample_model();
  description.name = "constant_rate";
  description.fixed = model.fixed();
  const samara::models::StateInfo& state = model.model().info().states.front();
  const Codebook book(description,
                      {Piece{{SeparatedField({time, k}, {{state.name, state.unit}}, {time.nodes(), rates},
                                             Eigen::MatrixXd::Ones(1, 1))}}});
  const Certificate certificate = certify(book, model, {.points = 50});
  CHECK(certificate.failed_points == 0);
  CHECK(certificate.max_error < 1e-9);
  CHECK(k.contains(certificate.outputs[0].worst[1]));
  samara::codebooks::Query query(book);
  Eigen::VectorXd value(1);
  CHECK_THROWS_WITH(query.values(std::vector{0.5, 3.0}, value), Contains("the values of a discrete axis"));
}
