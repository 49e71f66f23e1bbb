#include <cmath>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/codebooks/query/query.h"
#include "same_codebook.h"
#include "sample_books.h"

// A codebook file of every format version that was ever written stays in golden/ and stays readable.
// They are written by `codebook_samples golden FILE`; never write one again for a version that exists.

using namespace samara::codebooks;
using Catch::Matchers::WithinAbs;

namespace {

/// That the codebook is v0 + C t and v0 t + C t^2/2.
void check_line_and_parabola(const Codebook& book) {
  Query query(book);
  Eigen::VectorXd values(2);
  Eigen::MatrixXd gradient(2, 3);
  const auto check = [&](double t, double C, double v0) {
    query.values(std::vector{t, C, v0}, values, gradient);
    // Sums of few products of numbers up to 10: a few tens of eps; derivatives by t are larger by the
    // differentiation matrices of elements of length 1 and degree 3, of norm 20.
    constexpr double kRoundOff = 1e-14;
    CHECK_THAT(values[book.output_index("v")], WithinAbs(v0 + C * t, kRoundOff));
    CHECK_THAT(values[book.output_index("x")], WithinAbs(v0 * t + C * t * t / 2.0, kRoundOff));
    const Eigen::RowVector3d v_gradient(C, t, 1.0);
    const Eigen::RowVector3d x_gradient(v0 + C * t, t * t / 2.0, t);
    CHECK((gradient.row(book.output_index("v")) - v_gradient).cwiseAbs().maxCoeff() < 20.0 * kRoundOff);
    CHECK((gradient.row(book.output_index("x")) - x_gradient).cwiseAbs().maxCoeff() < 20.0 * kRoundOff);
  };
  check(0.0, -1.0, 0.0);
  check(3.0, 2.0, 1.0);
  check(2.0, 0.0, 0.5);
  const Eigen::MatrixXd points = random_points(book, 100, 7);
  for (Eigen::Index j = 0; j < points.cols(); ++j) check(points(0, j), points(1, j), points(2, j));
}

}  // namespace

TEST_CASE("the golden file of format 0.1 loads and evaluates to v0 + C t and v0 t + C t^2/2") {
  check_line_and_parabola(load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.1.h5"));
}

TEST_CASE("the golden file of format 0.3, with a train, evaluates to v0 + C t and v0 t + C t^2/2") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.3.h5");
  REQUIRE(book.pieces().size() == 2);
  CHECK(book.pieces()[0].groups()[0].train() != nullptr);
  CHECK(book.pieces()[1].groups()[0].sum() != nullptr);
  check_same_model(book.model(), sample_model());
  check_same_certificate(*book.certificate(), sample_certificate(golden_book()));
  check_line_and_parabola(book);
}

TEST_CASE("the golden file of format 0.1 holds all texts, numbers and the certificate") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.1.h5");
  CHECK(book.title() == "the golden codebook");
  CHECK(book.pieces().size() == 2);
  CHECK(book.pieces()[0].groups().size() == 2);
  CHECK(book.outputs()[1].unit == "m");
  CHECK(book.coordinates()[2].unit == "m/s");
  check_same_model(book.model(), sample_model());
  check_same_build(book.build(), sample_build());
  CHECK(book.provenance().plan == sample_provenance().plan);
  REQUIRE(book.certificate());
  check_same_certificate(*book.certificate(), sample_certificate(golden_book()));
}

TEST_CASE("the golden file of format 0.2 loads with axes of every kind and evaluates to its formula") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.2.h5");
  check_same_model(book.model(), sample_model());
  Query query(book);
  Eigen::VectorXd value(1);
  Eigen::MatrixXd gradient(1, 8);
  const Eigen::MatrixXd points = random_points(book, 200, 7);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const auto x = points.col(j);
    const double t = x[0], C = x[1], angle = x[2], plies = x[3], v0 = x[4], m = x[5], k = x[6], h = x[7];
    query.values(point(points, j), value, gradient);
    // Sums of products of numbers up to 40; the derivative by C_D goes up to 2 * 4 / 0.01.
    CHECK_THAT(
        value[0],
        WithinAbs(v0 * std::sqrt(m) + t * std::log(C) * std::cos(2.0 * angle) * plies + k * k / h, 1e-12));
    CHECK_THAT(gradient(0, 1), WithinAbs(t / C * std::cos(2.0 * angle) * plies, 1e-10));
    CHECK_THAT(gradient(0, 2), WithinAbs(-2.0 * t * std::log(C) * std::sin(2.0 * angle) * plies, 1e-11));
    CHECK_THAT(gradient(0, 7), WithinAbs(-k * k / h / h, 1e-12));
  }
}

TEST_CASE("the golden file of format 0.4, of a command without time, evaluates to a b and 1 + a") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.4.h5");
  check_same_codebook(book, golden_command());
  CHECK(book.is_of_command());
  CHECK_FALSE(book.has_time());
  Query query(book);
  Eigen::VectorXd values(2);
  Eigen::MatrixXd gradient(2, 2);
  const Eigen::MatrixXd points = random_points(book, 50, 3);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const double a = points(0, j), b = points(1, j);
    query.values(point(points, j), values, gradient);
    // A few products of numbers up to 3.
    CHECK_THAT(values[0], WithinAbs(a * b, 1e-14));
    CHECK_THAT(values[1], WithinAbs(1.0 + a, 1e-14));
    CHECK((gradient - (Eigen::Matrix2d() << b, a, 1.0, 0.0).finished()).cwiseAbs().maxCoeff() < 1e-13);
  }
}

TEST_CASE("the golden file of format 0.5 holds what its certificate tells of climbs and refutations") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.5.h5");
  check_same_codebook(book, golden_climbs());
  CHECK(book.certificate()->climbed_points == 17);
  CHECK(book.certificate()->refuted_before == 2);
}

TEST_CASE(
    "the golden file of format 0.6, over the nodes of a mesh, evaluates to k + x + 2 y at nodes and "
    "between") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.6.h5");
  check_same_codebook(book, golden_mesh());
  CHECK(book.certificate()->places == 4);
  REQUIRE(book.mesh() != nullptr);
  Query at_nodes(book);
  Eigen::VectorXd value(1);
  for (int node = 0; node < 4; ++node) {
    const Eigen::Vector2d place = book.mesh()->points().col(node);
    at_nodes.values(std::vector<double>{static_cast<double>(node), 0.3}, value);
    CHECK_THAT(value[0], WithinAbs(0.3 + place[0] + 2.0 * place[1], 1e-14));
  }
  PlaceQuery between(book);
  between.values(std::vector{0.8, 0.7, 0.3}, value);
  CHECK_THAT(value[0], WithinAbs(0.3 + 0.8 + 1.4, 1e-14));
}

TEST_CASE("the golden file of format 0.7, with a coordinate counted from a front, evaluates to its formula") {
  const Codebook book = load(std::filesystem::path(GOLDEN_DIRECTORY) / "codebook_0.7.h5");
  check_same_codebook(book, golden_front());
  Query query(book);
  Eigen::VectorXd values(2);
  const Eigen::MatrixXd points = random_points(book, 200, 7);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const double t = points(0, j), C = points(1, j) - 2.0, k = points(2, j), m = points(3, j),
                 h = points(4, j);
    const double K = 2.0 * k - 1.0, H = 0.5 * h;
    const double front = 0.1 + 0.2 * K - 0.3 * H + 0.15 * K * (2.0 * H * H - 1.0);
    const double s = 2.0 + (C - front) / (1.0 - front * C);
    query.values(point(points, j), values);
    CHECK_THAT(values[0], WithinAbs((1.0 + t) * s + k * k + m, 1e-13));
    CHECK_THAT(values[1], WithinAbs(s * s * h, 1e-13));
  }
}
