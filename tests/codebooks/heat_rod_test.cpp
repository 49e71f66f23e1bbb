// The ready field "heat_rod", from a plan to a file, against CVODE.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "damaged_codebook.h"
#include "rod_reference.h"
#include "samara/base/errors.h"
#include "samara/codebooks/book/certificate_points.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/fields/ready_field.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/pgd/tensors/random.h"

using namespace samara::codebooks;
using namespace damaged_codebook;
using Catch::Matchers::Contains;

namespace {

/// A rod of steel.
constexpr const char* kRodPlan = R"(model = "heat_rod"
title = "a rod of steel"
[fixed]
capacity = 3.6e6
length = "20 cm"
[box]
conductivity = [15.0, 60.0]
left = [0.0, 100.0]
right = [0.0, 100.0]
amplitude = [-50.0, 50.0]
[time]
end = "10 min"
[tolerance]
relative = 1e-4
)";

/// With fewer points of the certificate than the plan asks for: they are nine tenths of the time.
constexpr int kFewPoints = 100;

const BuildResult& rod_build() {
  static const BuildResult result =
      build(parse_plan(kRodPlan, "rod.toml"), {.certificate_points = kFewPoints});
  return result;
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

std::string refusal_of_rod(const std::string& text) {
  try {
    parse_plan(text, "rod.toml");
  } catch (const samara::InputError& error) {
    return error.what();
  }
  return "no exception";
}

}  // namespace

TEST_CASE(
    "a plan of heat_rod becomes a codebook that agrees with CVODE at 100 points after a file, corners "
    "included") {
  const BuildResult& built = rod_build();
  CAPTURE(built.message, built.book.build().message);
  REQUIRE(built.met);
  const TemporaryDirectory directory;
  save(built.book, directory / "rod.h5");
  const Codebook book = load(directory / "rod.h5");
  REQUIRE(book.coordinate_count() == 6);
  CHECK(book.coordinates()[1].name == "x");
  CHECK(book.coordinates()[1].unit == "m");
  CHECK(book.coordinates()[1].upper == 0.2);
  CHECK(book.space() == 1);

  Query query(book);
  Eigen::VectorXd value(1);
  samara::pgd::Random random(2026);
  const Eigen::VectorXd places = Eigen::VectorXd::LinSpaced(23, 0.0, 0.2);
  const std::vector<double> times = {0.0, 0.01, 0.3, 2.0, 7.0, 30.0, 111.0, 333.0, 600.0};
  double worst = 0.0, lowest = 1e300, highest = -1e300;
  for (int p = 0; p < 100; ++p) {
    std::vector<double> q;
    for (int k = 0; k < 4; ++k) {
      const Coordinate& c = book.coordinates()[static_cast<std::size_t>(2 + k)];
      const double share = p < 16 ? (p >> k) % 2 : random.uniform();
      q.push_back(c.lower + share * (c.upper - c.lower));
    }
    const Eigen::MatrixXd exact = rod_by_cvode({q[0], 3.6e6, 0.2, q[1], q[2], q[3]}, times, places);
    for (std::size_t i = 0; i < times.size(); ++i) {
      for (Eigen::Index j = 0; j < places.size(); ++j) {
        query.values(std::vector{times[i], places[j], q[0], q[1], q[2], q[3]}, value);
        worst = std::max(worst, std::abs(value[0] - exact(j, static_cast<Eigen::Index>(i))));
      }
    }
    lowest = std::min(lowest, exact.minCoeff());
    highest = std::max(highest, exact.maxCoeff());
  }
  CAPTURE(worst / (highest - lowest), book.certificate()->max_error);
  CHECK(worst / (highest - lowest) < 1e-4);
}

TEST_CASE(
    "the certificate of heat_rod is against the exact solution, at all places and times of every point") {
  const BuildResult built = build(parse_plan(kRodPlan, "rod.toml"));
  const Certificate& certificate = *built.book.certificate();
  CHECK(certificate.points == 2000);
  CHECK(certificate.places > 50);
  CHECK(certificate.times > 50);
  CHECK(certificate.max_error <= 1e-4);
  CHECK_THAT(certificate.integrator, Contains("exact solution"));
  REQUIRE(certificate.outputs.front().worst.size() == 6);
  // Measured again at other points, it is of the same size.
  CertifyOptions options;
  options.points = 300;
  options.seed = 99;
  options.tolerance = 1e-4;
  options.absolute = {{"u", certificate.outputs.front().range}};
  const Certificate again = certify(built.book, exact_reference(built.book), options);
  CHECK(again.met);
  CHECK(again.max_error > 0.05 * certificate.max_error);
  CHECK(again.max_error < 1.5 * certificate.max_error);
}

TEST_CASE(
    "the certificate of heat_rod holds in the layers at its ends, between the places that it looked at") {
  const Codebook& book = rod_build().book;
  const FieldReference exact = exact_reference(book);
  const std::vector<double> times = certificate_times(book);
  Eigen::VectorXd places(60);
  for (Eigen::Index j = 0; j < 30; ++j) {
    places[j] = 2e-5 * std::pow(500.0, static_cast<double>(j) / 29.0);  // up to 1 cm
    places[59 - j] = 0.2 - places[j];
  }
  const Eigen::MatrixXd points = certificate_points(book, 60, 7);
  Query query(book);
  Eigen::VectorXd value(1);
  double worst = 0.0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const std::vector<double> q(points.col(p).data() + 1, points.col(p).data() + 5);
    const Eigen::MatrixXd expected = exact.values(q, times, places);
    for (std::size_t i = 0; i < times.size(); ++i) {
      for (Eigen::Index j = 0; j < places.size(); ++j) {
        query.values(std::vector{times[i], places[j], q[0], q[1], q[2], q[3]}, value);
        worst = std::max(worst, std::abs(value[0] - expected(static_cast<Eigen::Index>(i), j)));
      }
    }
  }
  const Certificate& certificate = *book.certificate();
  CAPTURE(worst / certificate.outputs.front().range, certificate.max_error);
  CHECK(worst / certificate.outputs.front().range < 1.1 * certificate.max_error);
}

TEST_CASE("a rod that hardly changes, or not at all, is its straight line, solved at once") {
  // The ends are of the order of 100, what is left to solve for is nothing.
  std::string text = replaced(kRodPlan, "amplitude = [-50.0, 50.0]\n", "");
  text = replaced(text, "relative = 1e-4", "relative = 1e-6");
  BuildOptions options;
  options.certificate_points = 20;  // each of 50,000 places and times
  const BuildResult line = build(parse_plan(text, "rod.toml"), options);
  CAPTURE(line.message);
  CHECK(line.met);
  CHECK(line.book.certificate()->max_error < 1e-13);
  CHECK(line.book.pieces().front().groups().front().sum()->rank() == 2);
  Query query(line.book);
  Eigen::VectorXd value(1);
  query.values(std::vector{333.0, 0.05, 40.0, 100.0, 20.0}, value);
  CHECK(std::abs(value[0] - 80.0) < 1e-12);

  text = replaced(text, "left = [0.0, 100.0]\nright = [0.0, 100.0]\n", "");
  const BuildResult nothing = build(parse_plan(text, "rod.toml"), options);
  CAPTURE(nothing.message);
  CHECK(nothing.met);
  Query zero(nothing.book);
  zero.values(std::vector{333.0, 0.05, 40.0}, value);
  CHECK(value[0] == 0.0);
}

TEST_CASE("a conductivity over three decades is met, against the series of sines") {
  std::string text = replaced(kRodPlan, "conductivity = [15.0, 60.0]", "conductivity = [0.01, 10.0]");
  text = replaced(text, "end = \"10 min\"", "end = \"4 h\"");
  text = replaced(text, "relative = 1e-4", "relative = 1e-3");
  const BuildResult built = build(parse_plan(text, "rod.toml"), {.certificate_points = kFewPoints});
  CAPTURE(built.message, built.book.build().message);
  REQUIRE(built.met);
  CHECK(built.book.pieces().front().groups().front().axes()[2].transform() ==
        samara::pgd::Transform::logarithm);
  Query query(built.book);
  Eigen::VectorXd value(1);
  samara::pgd::Random random(11);
  double worst = 0.0;
  for (int p = 0; p < 300; ++p) {
    const double k = p < 2 ? (p == 0 ? 0.01 : 10.0) : 0.01 * std::pow(1000.0, random.uniform());
    const double t = 4.0 * 3600.0 * std::pow(random.uniform(), 3), s = random.uniform();
    const double left = 100.0 * random.uniform(), right = 100.0 * random.uniform();
    const double amplitude = 100.0 * random.uniform() - 50.0;
    double exact = left + (right - left) * s;
    for (int n = 1; n < 2000; n += 2) {
      const double wave = n * std::numbers::pi;
      exact += amplitude * 32.0 / std::pow(wave, 3) * std::sin(wave * s) *
               std::exp(-wave * wave * k * t / (3.6e6 * 0.04));
    }
    query.values(std::vector{t, 0.2 * s, k, left, right, amplitude}, value);
    worst = std::max(worst, std::abs(value[0] - exact));
  }
  // The series is cut off at 32/pi^3/(4 2000^2) of the amplitude; the range is that of the certificate.
  CHECK(worst < 1e-3 * built.book.certificate()->outputs.front().range);
}

TEST_CASE("an end that is given on an axis of roots from zero takes as many nodes as digits") {
  std::string text = replaced(kRodPlan, "left = [0.0, 100.0]",
                              "left = { range = [0.0, 100.0], transform = \"square_root\" }");
  text = replaced(text, "relative = 1e-4", "relative = 1e-3");
  const BuildResult built = build(parse_plan(text, "rod.toml"), {.certificate_points = kFewPoints});
  CAPTURE(built.message);
  CHECK(built.met);
  CHECK(built.book.pieces().front().groups().front().axes()[3].size() < 12);
}

TEST_CASE("a file of a rod in other units, or without a number that its exact solution needs, is refused") {
  const Codebook& book = rod_build().book;
  const auto with_unit = [&](const std::string& object) {
    return error_after([&](Patient& file) { file.set_text(object, "units", "kg"); }, book);
  };
  CHECK_THAT(with_unit("/pieces/0/axes/conductivity"), Contains("those of the model \"W/(m K)\""));
  CHECK_THAT(with_unit("/pieces/0/axes/x"), Contains("those of the model \"m\""));
  CHECK_THAT(with_unit("/pieces/0/axes/t"), Contains("those of the model \"s\""));
  CHECK_THAT(with_unit("/model/fixed/capacity"), Contains("those of the model \"J/(m^3 K)\""));
  ModelDescription without = book.model();
  without.fixed.erase("capacity");
  without.fixed_units.erase("capacity");
  const Codebook lost(without, book.pieces(), book.build(), book.provenance());
  CHECK_THROWS_AS(exact_reference(lost), samara::ArgumentError);
  CHECK_THROWS_WITH(exact_reference(lost),
                    Contains("\"capacity\"") && Contains("neither fixed nor a coordinate"));
}

TEST_CASE("a certificate finds a field that is wrong at one place") {
  const Codebook& book = rod_build().book;
  const FieldReference exact = exact_reference(book);
  FieldReference dented = exact;
  dented.values = [&](std::span<const double> q, const std::vector<double>& times,
                      const Eigen::VectorXd& places) {
    Eigen::MatrixXd values = exact.values(q, times, places);
    values(3, 7) += 30.0;
    return values;
  };
  CertifyOptions options;
  options.points = 20;
  options.tolerance = 1e-4;
  const Certificate certificate = certify(book, dented, options);
  CHECK_FALSE(certificate.met);
  CHECK(certificate.wrong_points == 20);
  const std::vector<double>& worst = certificate.outputs.front().worst;
  CHECK(worst[0] == certificate_times(book)[3]);
  CHECK(worst[1] == certificate_places(book)[7]);
}

TEST_CASE("derivatives of the rod by place and parameters are those of its answers") {
  const Codebook& book = rod_build().book;
  Query query(book);
  Eigen::VectorXd value(1), above(1), below(1);
  Eigen::MatrixXd gradient(1, 6);
  const std::vector<double> point = {100.0, 0.07, 31.0, 20.0, 65.0, 33.0};
  query.values(point, value, gradient);
  for (std::size_t k = 0; k < 6; ++k) {
    const Coordinate& c = book.coordinates()[k];
    const double step = 1e-5 * (c.upper - c.lower);
    std::vector<double> moved = point;
    moved[k] += step;
    query.values(moved, above);
    moved[k] -= 2.0 * step;
    query.values(moved, below);
    // Steps of 1e-5 of the range: cut off by 1e-10 of third derivatives, rounded by 1e-16/1e-5.
    const double slope = (above[0] - below[0]) / (2.0 * step);
    CHECK(std::abs(gradient(0, static_cast<Eigen::Index>(k)) - slope) < 1e-5 * 100.0 / (c.upper - c.lower));
  }
}

TEST_CASE("capacity may be free, and what is left out has its default") {
  std::string text = replaced(kRodPlan, "capacity = 3.6e6\n", "");
  text = replaced(text, "left = [0.0, 100.0]\nright = [0.0, 100.0]\n",
                  "capacity = { range = [2e6, 4e6], nodes = 14 }\n");
  text = replaced(text, "amplitude = [-50.0, 50.0]\n", "amplitude = [10.0, 50.0]\n");
  text = replaced(text, "relative = 1e-4", "relative = 1e-3");
  const BuildResult built = build(parse_plan(text, "rod.toml"), {.certificate_points = kFewPoints});
  CAPTURE(built.message);
  CHECK(built.met);
  CHECK(built.book.pieces().front().groups().front().axes()[3].size() == 14);
  Query query(built.book);
  Eigen::VectorXd value(1);
  query.values(std::vector{200.0, 0.1, 40.0, 3e6, 50.0}, value);
  const Eigen::MatrixXd exact =
      rod_by_cvode({40.0, 3e6, 0.2, 0.0, 0.0, 50.0}, {0.0, 200.0}, Eigen::VectorXd::Constant(1, 0.1));
  CHECK(std::abs(value[0] - exact(0, 1)) < 1e-3 * 50.0);
}

TEST_CASE("plans of heat_rod that cannot be are refused with line and word") {
  CHECK_THAT(refusal_of_rod(replaced(kRodPlan, "length = \"20 cm\"\n", "")),
             Contains("needs \"length\" (m)"));
  CHECK_THAT(refusal_of_rod(replaced(kRodPlan, "left = [0.0", "length = [0.1")),
             Contains("rod.toml:8") && Contains("it is how far x goes"));
  CHECK_THAT(refusal_of_rod(replaced(kRodPlan, "conductivity = [15.0", "conductivity = [-1.0")),
             Contains("expected more than 0"));
  CHECK_THAT(refusal_of_rod(replaced(kRodPlan, "left =", "lft =")), Contains("did you mean \"left\"?"));
  for (const auto& [key, word] :
       std::vector<std::pair<std::string, std::string>>{{"kind = 'sampling'", "no trajectories to sample"},
                                                        {"strategy = 'slabs'", "solved by enrichment"},
                                                        {"max_cells = 3", "never split"},
                                                        {"max_calls = 3", "without evaluations"}})
    CHECK_THAT(refusal_of_rod(std::string(kRodPlan) + "[builder]\n" + key), Contains(word));
  CHECK_THROWS_WITH(parse_plan(kRodPlan, "rod.toml").parametric_model(), Contains("no trajectories"));
  const std::string wide = replaced(kRodPlan, "conductivity = [15.0, 60.0]",
                                    "conductivity = { range = [1e-5, 1e5], basis = \"legendre\" }");
  CHECK_THROWS_WITH(
      build(parse_plan(wide, "rod.toml")),
      Contains("conductivity goes from 1e-05 to 100000 in [box]") && Contains("more than 2000 nodes"));
}

TEST_CASE("what needs trajectories says that the rod has none") {
  CHECK_THROWS_WITH(model_of(rod_build().book), Contains("a field of space, the heat_rod"));
}
