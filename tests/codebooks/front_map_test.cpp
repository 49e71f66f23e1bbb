// Coordinates that are counted from a front, by the answers of codebooks that have one
// (golden_front, whose formula is known).
#include "samara/codebooks/book/front_map.h"

#include <array>
#include <cmath>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/book/book_slice.h"
#include "samara/codebooks/file/flat_file.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/codebooks/statistics/book_statistics.h"
#include "same_codebook.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::ArgumentError;

namespace {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// Its values u and w with two derivatives by each of t, C, k, m and h, by rules of its own.
struct Jet {
  double value = 0.0;
  Vector5d slope = Vector5d::Zero();
  Matrix5d curvature = Matrix5d::Zero();

  static Jet variable(double value, int k) {
    Jet jet{value};
    jet.slope[k] = 1.0;
    return jet;
  }
  static Jet number(double value) { return {value}; }
  friend Jet operator+(const Jet& a, const Jet& b) {
    return {a.value + b.value, a.slope + b.slope, a.curvature + b.curvature};
  }
  friend Jet operator*(const Jet& a, const Jet& b) {
    return {a.value * b.value, a.value * b.slope + b.value * a.slope,
            a.value * b.curvature + b.value * a.curvature + a.slope * b.slope.transpose() +
                b.slope * a.slope.transpose()};
  }
  friend Jet inverse(const Jet& a) {
    const double v = 1.0 / a.value;
    return {v, -v * v * a.slope, 2.0 * v * v * v * a.slope * a.slope.transpose() - v * v * a.curvature};
  }
};

std::array<Jet, 2> exact(std::span<const double> x) {
  const auto n = [](double value) { return Jet::number(value); };
  const Jet t = Jet::variable(x[0], 0), C = Jet::variable(x[1], 1) + n(-2.0), k = Jet::variable(x[2], 2),
            m = Jet::variable(x[3], 3), h = Jet::variable(x[4], 4);
  const Jet K = n(2.0) * k + n(-1.0), H = n(0.5) * h;
  const Jet front = n(0.1) + n(0.2) * K + n(-0.3) * H + n(0.15) * K * (n(2.0) * H * H + n(-1.0));
  const Jet s = n(2.0) + (C + n(-1.0) * front) * inverse(n(1.0) + n(-1.0) * front * C);
  return {(n(1.0) + t) * s + k * k + m, s * s * h};
}

/// The largest error of values, slopes and curvatures at random points, with some coordinates held.
Eigen::Vector3d errors_of(const std::map<std::string, double>& held) {
  const Codebook book = golden_front();
  Query query(book, {.fixed = held});
  const auto d = static_cast<Eigen::Index>(query.coordinates().size());
  std::vector<int> free;
  for (const Coordinate& c : query.coordinates()) free.push_back(book.coordinate_index(c.name));
  Eigen::MatrixXd points = random_points(book, 100, 11);
  for (const auto& [name, value] : held) points.row(book.coordinate_index(name)).setConstant(value);
  Eigen::VectorXd values(2), x(d);
  Eigen::MatrixXd gradient(2, d), hessian(2, d * d);
  Eigen::Vector3d errors = Eigen::Vector3d::Zero();
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const std::array<Jet, 2> expected = exact(point(points, j));
    x = points.col(j)(free);
    query.values(std::span(x.data(), static_cast<std::size_t>(d)), values, gradient, hessian);
    for (Eigen::Index o = 0; o < 2; ++o) {
      const Jet& one = expected[static_cast<std::size_t>(o)];
      const Eigen::VectorXd slope = one.slope(free);
      const Eigen::MatrixXd curvature = one.curvature(free, free);
      errors[0] = std::max(errors[0], std::abs(values[o] - one.value));
      errors[1] = std::max(errors[1], (gradient.row(o).transpose() - slope).cwiseAbs().maxCoeff());
      errors[2] = std::max(errors[2], (hessian.row(o).reshaped(d, d) - curvature).cwiseAbs().maxCoeff());
    }
  }
  return errors;
}

const FrontMap& golden_map() {
  static const Codebook book = golden_front();
  return *book.front();
}

}  // namespace

TEST_CASE("a codebook with a front gives values and two derivatives of its formula, whatever is held") {
  const std::map<std::string, double> helds[] = {{},           {{"k", 0.4}},
                                                 {{"C", 1.7}}, {{"C", 2.9}, {"h", -1.1}},
                                                 {{"t", 0.3}}, {{"C", 1.2}, {"k", 0.1}, {"h", 0.6}}};
  for (const auto& held : helds) {
    const Eigen::Vector3d errors = errors_of(held);
    CAPTURE(held.size(), errors.transpose());
    CHECK(errors[0] < 1e-12);
    CHECK(errors[1] < 1e-10);
    CHECK(errors[2] < 1e-8);
  }
}

TEST_CASE("batches of a codebook with a front answer as single points do, over all its elements") {
  const Codebook book = golden_front();
  for (const std::map<std::string, double>& held :
       {std::map<std::string, double>{}, {{"C", 1.7}}, {{"k", 0.2}}}) {
    Query query(book, {.fixed = held});
    Eigen::MatrixXd all = random_points(book, 1500, 5);
    const auto d = static_cast<Eigen::Index>(query.coordinates().size());
    Eigen::MatrixXd points(d, all.cols());
    for (Eigen::Index k = 0; k < d; ++k)
      points.row(k) = all.row(book.coordinate_index(query.coordinates()[static_cast<std::size_t>(k)].name));
    Eigen::MatrixXd together(2, points.cols());
    query.batch(points, together, 2);
    Eigen::VectorXd values(2);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      query.values(point(points, j), values);
      REQUIRE((together.col(j) - values).cwiseAbs().maxCoeff() < 1e-13);
    }
  }
}

TEST_CASE("trajectories of a codebook with a front, and their derivatives, are those of its formula") {
  const Codebook book = golden_front();
  const std::vector<double> times = {0.0, 0.7, 2.0};
  for (const std::map<std::string, double>& held : {std::map<std::string, double>{}, {{"C", 2.2}}}) {
    TrajectoryQuery query(book, times, QueryOptions{.fixed = held});
    const int d = query.parameter_count();
    Eigen::MatrixXd points = random_points(book, 40, 8).bottomRows(4), values(3, 2), slopes(3, 2 * d);
    if (d == 3) points.row(0).setConstant(2.2);
    const Eigen::MatrixXd free = points.bottomRows(d);
    Eigen::MatrixXd together(6, free.cols());
    query.batch(free, together);
    for (Eigen::Index j = 0; j < free.cols(); ++j) {
      query.values(point(free, j), values, slopes);
      for (Eigen::Index i = 0; i < 3; ++i) {
        const double x[] = {times[static_cast<std::size_t>(i)], points(0, j), points(1, j), points(2, j),
                            points(3, j)};
        const std::array<Jet, 2> expected = exact(x);
        for (Eigen::Index o = 0; o < 2; ++o) {
          const Jet& one = expected[static_cast<std::size_t>(o)];
          REQUIRE_THAT(values(i, o), WithinAbs(one.value, 1e-12));
          REQUIRE_THAT(together(i + 3 * o, j), WithinAbs(one.value, 1e-12));
          for (int k = 0; k < d; ++k)
            REQUIRE_THAT(slopes(i, o + 2 * k), WithinAbs(one.slope[5 - d + k], 1e-10));
        }
      }
    }
  }
}

TEST_CASE("a coordinate counted from a front comes back, and the front and the ends of the box are fixed") {
  const FrontMap& map = golden_map();
  const Eigen::MatrixXd points = random_points(golden_front(), 200, 3);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    Vector5d x = points.col(j);
    const double there = x[1];
    x[1] = map.to_axis(x.data());
    CHECK_THAT(map.from_axis(x.data()), WithinAbs(there, 1e-14 * 30.0));
    x[1] = map.front_at(x.data());
    CHECK_THAT(map.to_axis(x.data()), WithinAbs(2.0, 1e-15 * 30.0));
    for (const double end : {1.0, 3.0}) {
      x[1] = end;
      CHECK(map.to_axis(x.data()) == end);
      CHECK(map.from_axis(x.data()) == end);
    }
  }
}

TEST_CASE("statistics of a codebook with a front are those of draws, and say so") {
  // Of (1 + t) s + k^2 + m at t = 0, s by its formula, over the box; m has the variance 1/12.
  const Codebook book = golden_front();
  const BookStatistics s = take_statistics(book, {.draws = 1 << 16});
  CHECK(s.inputs.empty());
  REQUIRE(s.notes.size() == 1);
  CHECK_THAT(s.notes[0], Contains("counted from a front") && Contains("draws"));
  double sum = 0.0, squares = 0.0;
  constexpr int kSteps = 60;
  for (int a = 0; a < kSteps; ++a) {
    for (int b = 0; b < kSteps; ++b) {
      for (int c = 0; c < kSteps; ++c) {
        const double x[] = {0.0, 1.0 + 2.0 * (a + 0.5) / kSteps, (b + 0.5) / kSteps, 0.5,
                            -2.0 + 4.0 * (c + 0.5) / kSteps};
        const double u = exact(x)[0].value;
        sum += u;
        squares += u * u;
      }
    }
  }
  const double count = std::pow(kSteps, 3), mean = sum / count;
  CHECK_THAT(s.outputs[0].mean[0], WithinAbs(mean, 1e-3));
  CHECK_THAT(s.outputs[0].deviation[0],
             WithinAbs(std::sqrt(squares / count - mean * mean + 1.0 / 12.0), 1e-3));
  CHECK_THROWS_WITH(take_statistics(book, {.groups = {{"C", "k"}}}), Contains("no indices of groups"));
}

TEST_CASE("what a front cannot be is refused in a sentence") {
  const auto made = [](std::vector<FrontMap::Other> others, Eigen::VectorXd place) {
    return FrontMap(1, 1.0, 3.0, std::move(others), std::move(place));
  };
  CHECK_THROWS_WITH(made({}, Eigen::VectorXd::Constant(1, 1.0)), Contains("leaves its interval"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 2}}, Eigen::Vector2d(0.5, 0.6)), Contains("leaves its interval"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 2}}, Eigen::VectorXd::Zero(3)), Contains("by 3 coefficients; 2"));
  CHECK_THROWS_WITH(made({{1, 0.0, 1.0, 2}}, Eigen::Vector2d::Zero()), Contains("the coordinate itself"));
  CHECK_THROWS_WITH(made({{2, 1.0, 1.0, 2}}, Eigen::Vector2d::Zero()), Contains("no interval"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 1}, {2, 0.0, 1.0, 2}}, Eigen::Vector2d::Zero()), Contains("twice"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 17}}, Eigen::VectorXd::Zero(17)),
                    Contains("17 coefficients along an other; 1 to 16"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 0}}, Eigen::VectorXd::Zero(0)),
                    Contains("0 coefficients along an other"));
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 2}}, Eigen::Vector2d(0.0, std::nan(""))), Contains("coefficients"));
  // Inside at 17 equal steps, far outside near an end.
  const Eigen::VectorXd between{{0.23588477, 0.35297143, 0.47766988, 0.264, 0.34581857, 0.19748571,
                                 0.01733012, 0.17554286, -1.07670334}};
  CHECK_THROWS_WITH(made({{2, 0.0, 1.0, 9}}, between), Contains("leaves its interval"));
  // Coefficients of 2.3 (x - x^3), which are more than 1 together, while it stays within 0.89; along one of two others.
  Eigen::VectorXd within = Eigen::VectorXd::Zero(8);
  within[1] = 0.575;
  within[3] = -0.575;
  const FrontMap map = made({{2, 0.0, 1.0, 4}, {0, 0.0, 1.0, 2}}, within);
  for (const double value : {0.0, 0.21, 0.95}) CHECK(std::abs(map.restricted(2, value).place()[0]) < 0.89);

  const Piece piece = golden_front().pieces().front();
  const auto with = [&](FrontMap front) { return Piece(piece.groups(), std::move(front)); };
  CHECK_THROWS_WITH(with(FrontMap(0, 0.0, 2.0, {}, Eigen::VectorXd::Zero(1))), Contains("axis \"t\""));
  CHECK_THROWS_WITH(with(FrontMap(1, 1.0, 2.5, {}, Eigen::VectorXd::Zero(1))),
                    Contains("from 1 to 2.5, expected 1 to 3"));
  CHECK_THROWS_WITH(with(FrontMap(7, 1.0, 2.5, {}, Eigen::VectorXd::Zero(1))), Contains("axis 7"));
  CHECK_THROWS_AS(Codebook(sample_model(), {piece, piece}), ArgumentError);
}

TEST_CASE("a front that moves with nothing any more is kept in files") {
  const Codebook part = slice(golden_front(), {{"k", 0.3}, {"h", 0.2}});
  REQUIRE(part.front() != nullptr);
  CHECK(part.front()->others().empty());
  const TemporaryDirectory directory;
  save(part, directory / "part.h5");
  check_same_codebook(load(directory / "part.h5"), part);
}

TEST_CASE("flat files refuse a codebook with a front") {
  CHECK_THROWS_WITH(format_flat(golden_front()), Contains("\"C\" is counted from a front"));
}
