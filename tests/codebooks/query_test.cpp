#include "samara/codebooks/query.h"

#include <limits>
#include <vector>

#include <catch2/catch.hpp>

#include "coin_book.h"
#include "samara/base/errors.h"
#include "samara/codebooks/sobol_points.h"
#include "samara/pgd/random.h"

using namespace samara;
using Catch::Matchers::Contains;
using codebooks::Codebook;
using codebooks::Piece;
using codebooks::Query;
using codebooks::TrajectoryQuery;

namespace {

/// u = slope t q on [begin, end] x [0, 2], one product; exact on two nodes an axis.
pgd::SeparatedField ramp(double begin, double end, double slope, double lower = 0.0, double upper = 2.0) {
  const pgd::Axis t = pgd::Axis::p1({"t", "s", pgd::AxisRole::time}, begin, end, 3);
  const pgd::Axis q = pgd::Axis::chebyshev({"q"}, lower, upper, 4);
  return pgd::SeparatedField({t, q}, {{"u", "m"}}, {t.nodes(), q.nodes()},
                             Eigen::MatrixXd::Constant(1, 1, slope));
}

Codebook of(std::vector<Piece> pieces) {
  return Codebook({}, std::move(pieces));
}

}  // namespace

TEST_CASE("a query is answered by the piece that holds the point, at a border by the lower one") {
  const Codebook book = of({Piece{{ramp(0, 1, 1)}}, Piece{{ramp(1, 2, 3)}}});
  Query query(book);
  Eigen::VectorXd u(1);
  Eigen::MatrixXd gradient(1, 2);
  query.values(std::vector<double>{0.5, 2.0}, u, gradient);
  CHECK(u[0] == Approx(1.0));
  CHECK(gradient(0, 0) == Approx(2.0));
  CHECK(gradient(0, 1) == Approx(0.5));
  query.values(std::vector<double>{1.5, 2.0}, u);
  CHECK(u[0] == Approx(9.0));
  query.values(std::vector<double>{1.0, 2.0}, u, gradient);
  CHECK(u[0] == Approx(2.0));
  CHECK(gradient(0, 0) == Approx(2.0));

  TrajectoryQuery trajectory(book, {0.5, 1.0, 1.5});
  Eigen::MatrixXd values(3, 1);
  Eigen::MatrixXd derivatives(3, 1);
  trajectory.values(std::vector<double>{2.0}, values, derivatives);
  CHECK(values(1, 0) == Approx(2.0));
  CHECK(values(2, 0) == Approx(9.0));
  CHECK(derivatives(2, 0) == Approx(4.5));
}

TEST_CASE("cells of the parameter box are found by their parameters") {
  const Codebook book = of({Piece{{ramp(0, 1, 1, 0, 1)}}, Piece{{ramp(0, 1, 5, 1, 2)}}});
  TrajectoryQuery trajectory(book, {0.5});
  Eigen::MatrixXd values(1, 1);
  trajectory.values(std::vector<double>{0.5}, values);
  CHECK(values(0, 0) == Approx(0.25));
  trajectory.values(std::vector<double>{1.0}, values);
  CHECK(values(0, 0) == Approx(0.5));
  trajectory.values(std::vector<double>{2.0}, values);
  CHECK(values(0, 0) == Approx(5.0));
}

TEST_CASE("gradients are those of the values") {
  const Codebook& book = test::coin_build().book;
  Query query(book);
  pgd::Random random(8);
  Eigen::VectorXd values(2), above(2), below(2);
  Eigen::MatrixXd gradient(2, 3);
  for (int i = 0; i < 50; ++i) {
    std::vector<double> x;
    for (const auto& c : book.coordinates())
      x.push_back(c.lower + (0.01 + 0.98 * random.uniform()) * (c.upper - c.lower));
    query.values(x, values, gradient);
    for (std::size_t k = 0; k < 3; ++k) {
      const double length = book.coordinates()[k].upper - book.coordinates()[k].lower;
      const double step = 1e-6 * length;
      std::vector<double> shifted = x;
      shifted[k] += step;
      query.values(shifted, above);
      shifted[k] = x[k] - step;
      query.values(shifted, below);
      // Central differences over 1e-6 of the axis: round-off 1e-16 / 1e-6, truncation far below.
      for (int o = 0; o < 2; ++o) {
        CHECK(gradient(o, static_cast<Eigen::Index>(k)) * length ==
              Approx((above[o] - below[o]) / (2e-6)).margin(1e-7));
      }
    }
  }
}

TEST_CASE("a prepared trajectory gives what single queries give") {
  const Codebook& book = test::coin_build().book;
  const std::vector<double> times = {0.0, 0.1, 0.123, 0.4};
  TrajectoryQuery trajectory(book, times, {"x", "v"});
  Query query(book);
  Eigen::MatrixXd values(4, 2), derivatives(4, 4);
  trajectory.values(std::vector<double>{1.1, 0.2}, values, derivatives);
  Eigen::VectorXd single(2);
  Eigen::MatrixXd gradient(2, 3);
  for (std::size_t i = 0; i < times.size(); ++i) {
    query.values(std::vector<double>{times[i], 1.1, 0.2}, single, gradient);
    const auto row = static_cast<Eigen::Index>(i);
    // The codebook's outputs are v, x; those of the trajectory were asked for as x, v.
    for (int o = 0; o < 2; ++o) {
      CHECK(values(row, o) == Approx(single[1 - o]).margin(1e-14));
      for (int k = 0; k < 2; ++k)
        CHECK(derivatives(row, o + 2 * k) == Approx(gradient(1 - o, k + 1)).margin(1e-13));
    }
  }
}

TEST_CASE("points outside the box, and points that are none, are refused by name") {
  const Codebook& book = test::coin_build().book;
  Query query(book);
  Eigen::VectorXd values(2);
  CHECK_THROWS_AS(query.values(std::vector<double>{0.1, 3.0, 0.0}, values), OutsideBoxError);
  CHECK_THROWS_WITH(query.values(std::vector<double>{0.1, 3.0, 0.0}, values),
                    Contains("C_D = 3") && Contains("[0.8, 1.6]"));
  CHECK_THROWS_AS(
      query.values(std::vector<double>{0.1, std::numeric_limits<double>::quiet_NaN(), 0.0}, values),
      ArgumentError);
  CHECK_THROWS_AS(query.values(std::vector<double>{0.1, 1.0}, values), ArgumentError);
  CHECK_THROWS_AS(TrajectoryQuery(book, {0.5}), OutsideBoxError);
  CHECK_THROWS_WITH(TrajectoryQuery(book, {0.1}, {"w"}), Contains("\"w\""));
}

TEST_CASE("scrambled Sobol' points stratify every coordinate") {
  const int count = 256;
  const Eigen::MatrixXd points = codebooks::sobol_points(5, count, 3);
  for (int k = 0; k < 5; ++k) {
    std::vector<int> hits(count, 0);
    for (int j = 0; j < count; ++j) ++hits[static_cast<std::size_t>(points(k, j) * count)];
    CHECK(std::all_of(hits.begin(), hits.end(), [](int h) { return h == 1; }));
  }
  CHECK(points == codebooks::sobol_points(5, count, 3));
  CHECK(points != codebooks::sobol_points(5, count, 4));
}
