#include "samara/codebooks/query/query.h"

#include <array>
#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;
using samara::ArgumentError;
using samara::OutsideBoxError;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// All outputs of a piece, group after group, from the fields themselves.
Eigen::VectorXd values_of(const Piece& piece, std::span<const double> x) {
  std::vector<double> all;
  for (const FieldGroup& group : piece.groups()) {
    for (const double value : group.train() != nullptr ? (*group.train())(x) : (*group.sum())(x))
      all.push_back(value);
  }
  return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
}

Eigen::MatrixXd gradient_of(const Piece& piece, std::span<const double> x) {
  Eigen::MatrixXd all(0, static_cast<Eigen::Index>(x.size()));
  for (const FieldGroup& group : piece.groups()) {
    FieldGroup::Workspace workspace = group.make_workspace();
    Eigen::VectorXd values(group.output_count());
    Eigen::MatrixXd gradient(group.output_count(), group.axis_count());
    group.evaluate(x, values, gradient, workspace);
    const Eigen::Index before = all.rows();
    all.conservativeResize(before + gradient.rows(), Eigen::NoChange);
    all.bottomRows(gradient.rows()) = gradient;
  }
  return all;
}

/// Index of the piece of four_pieces() that answers for a point: the lower one at a border.
std::size_t piece_of(double t, double C_D) {
  return (t <= kSlabBorder ? 0u : 2u) + (C_D <= kCellBorder ? 0u : 1u);
}

}  // namespace

TEST_CASE("values and gradients are those of the fields of the piece that holds the point") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3), again(3);
  Eigen::MatrixXd gradient(3, 3);
  const Eigen::MatrixXd points = random_points(book, 200, 3);
  std::array<int, 4> visits = {};
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const auto x = point(points, j);
    const std::size_t p = piece_of(x[0], x[1]);
    ++visits[p];
    query.values(x, values);
    query.values(x, again, gradient);
    // The same products in another order: a few eps per term, of fields of size 1 and slopes of size 100.
    CHECK((values - values_of(book.pieces()[p], x)).norm() < 1e-13);
    CHECK((again - values).norm() < 1e-13);
    CHECK((gradient - gradient_of(book.pieces()[p], x)).norm() < 1e-11);
  }
  for (const int count : visits) CHECK(count > 10);
}

TEST_CASE("a border belongs to the lower piece, with its one-sided derivatives") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3);
  Eigen::MatrixXd gradient(3, 3);
  const auto check = [&](double t, double C_D, std::size_t piece) {
    const std::array x = {t, C_D, 0.2};
    query.values(x, values, gradient);
    CHECK((values - values_of(book.pieces()[piece], x)).norm() < 1e-13);
    CHECK((gradient - gradient_of(book.pieces()[piece], x)).norm() < 1e-11);
    // The pieces do differ here.
    for (std::size_t other = 0; other < 4; ++other) {
      const auto& axes = book.pieces()[other].groups().front().axes();
      if (other == piece || !axes[0].contains(t) || !axes[1].contains(C_D)) continue;
      CHECK((values - values_of(book.pieces()[other], x)).norm() > 0.01);
    }
  };
  check(kSlabBorder, 0.7, 0);
  check(kSlabBorder, 1.7, 1);
  check(0.1, kCellBorder, 0);
  check(0.4, kCellBorder, 2);
  check(kSlabBorder, kCellBorder, 0);
  // One step of doubles beyond, it is the upper one.
  check(std::nextafter(kSlabBorder, 1.0), kCellBorder, 2);
  check(kSlabBorder, std::nextafter(kCellBorder, 2.0), 1);
}

TEST_CASE("the lower piece answers at a border also if pieces were given in another order") {
  std::vector<Piece> pieces = four_pieces().pieces();
  std::reverse(pieces.begin(), pieces.end());
  const Codebook reversed(sample_model(), pieces);
  const Codebook book = four_pieces();
  Eigen::VectorXd a(3), b(3);
  for (const std::array<double, 3>& x :
       {std::array{kSlabBorder, 0.7, 0.0}, {kSlabBorder, kCellBorder, 0.1}}) {
    Query(book).values(x, a);
    Query(reversed).values(x, b);
    CHECK(a == b);
  }
}

TEST_CASE("corners of the box are inside") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3);
  for (const double t : {0.0, 0.5}) {
    for (const double C_D : {0.5, 2.0}) {
      for (const double v0 : {-0.3, 0.6}) CHECK_NOTHROW(query.values(std::array{t, C_D, v0}, values));
    }
  }
}

TEST_CASE("gradients are the limits of central differences") {
  const Codebook& book = coin_build().book;
  Query query(book);
  Eigen::VectorXd values(2), above(2), below(2);
  Eigen::MatrixXd gradient(2, 3);
  const Eigen::MatrixXd points = random_points(book, 100, 5);
  const auto& axes = book.pieces().front().groups().front().axes();
  int compared = 0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), values, gradient);
    for (Eigen::Index k = 0; k < 3; ++k) {
      // The third derivative of a polynomial of degree n through values of size 1 on an interval of length 1
      // is below n^6: with n = 10 and h = 1e-5, h^2/6 of that is 2e-5; round-off is eps/h.
      const samara::pgd::Axis& axis = axes[static_cast<std::size_t>(k)];
      const int element = axis.element_of(points(k, j));
      const double length = axis.borders()[element + 1] - axis.borders()[element];
      const double h = 1e-5 * length;
      Eigen::VectorXd x = points.col(j);
      x[k] += h;
      if (!axis.contains(x[k]) || axis.element_of(x[k]) != element) continue;
      query.values(point(x, 0), above);
      x[k] = points(k, j) - h;
      if (!axis.contains(x[k]) || axis.element_of(x[k]) != element) continue;
      query.values(point(x, 0), below);
      for (Eigen::Index o = 0; o < 2; ++o) {
        const double range = book.certificate()->outputs[static_cast<std::size_t>(o)].range;
        CHECK_THAT((above[o] - below[o]) / (2.0 * h), WithinAbs(gradient(o, k), 3e-5 * range / length));
      }
      ++compared;
    }
  }
  CHECK(compared > 250);
}

TEST_CASE("a point outside the box is refused, naming coordinate, unit and interval") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3);
  Eigen::MatrixXd gradient(3, 3);
  const auto refusal = [&](double t, double C_D, double v0) {
    const std::array x = {t, C_D, v0};
    const std::string text = error_text<OutsideBoxError>([&] { query.values(x, values); });
    CHECK(error_text<OutsideBoxError>([&] { query.values(x, values, gradient); }) == text);
    return text;
  };
  CHECK(refusal(0.6, 1.0, 0.0) == "t = 0.6 s is outside the codebook's box [0, 0.5]");
  CHECK(refusal(-1e-9, 1.0, 0.0) == "t = -1e-09 s is outside the codebook's box [0, 0.5]");
  CHECK(refusal(0.1, 2.5, 0.0) == "C_D = 2.5 is outside the codebook's box [0.5, 2]");
  CHECK(refusal(0.1, 1.0, -0.31) == "v(0) = -0.31 m/s is outside the codebook's box [-0.3, 0.6]");
  CHECK_THAT(refusal(std::nextafter(0.5, 1.0), 1.0, 0.0), Contains("is outside"));
}

TEST_CASE("a batch on several threads names the first point that is refused") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::MatrixXd points = random_points(book, 4096, 5), values(3, points.cols());
  points(1, 511) = 7.0;
  points(1, 2048) = 9.0;
  for (int k = 0; k < 20; ++k) {
    CHECK_THAT(error_text<OutsideBoxError>([&] { query.batch(points, values, 2); }), Contains("C_D = 7 "));
  }
}

TEST_CASE("a point that is not finite or of another size is refused") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::VectorXd values(3);
  const auto refusal = [&](const std::vector<double>& x) {
    return error_text<ArgumentError>([&] { query.values(x, values); });
  };
  CHECK(refusal({0.1, kNaN, 0.0}) == "C_D is nan, expected a finite number");
  CHECK(refusal({0.1, 1.0, -std::numeric_limits<double>::infinity()}) ==
        "v(0) is -inf, expected a finite number");
  CHECK(refusal({0.1, 1.0}) == "the point has 2 coordinates, expected 3");
  CHECK(refusal({0.1, 1.0, 0.0, 0.0}) == "the point has 4 coordinates, expected 3");
  CHECK(refusal({}) == "the point has 0 coordinates, expected 3");
}

TEST_CASE("answers of another size than the codebook's are refused, not written beyond") {
  const Codebook book = four_pieces();
  Query query(book);
  const std::array x = {0.1, 1.0, 0.0};
  Eigen::VectorXd values(3), few(2), many(4);
  Eigen::MatrixXd wrong(3, 2);
  CHECK_THAT(error_text<ArgumentError>([&] { query.values(x, few); }),
             Contains("have 2 rows and 1 columns, expected 3 and 1"));
  CHECK_THROWS_AS(query.values(x, many), ArgumentError);
  CHECK_THAT(error_text<ArgumentError>([&] { query.values(x, values, wrong); }),
             Contains("have 3 rows and 2 columns, expected 3 and 3"));
}

TEST_CASE("a point in a gap between pieces is outside") {
  const Codebook book(sample_model(),
                      {random_piece({0.0, 0.2, 0.5, 1.0}, 1), random_piece({0.3, 0.5, 0.5, 1.0}, 2)});
  Query query(book);
  Eigen::VectorXd values(3);
  CHECK_NOTHROW(query.values(std::array{0.2, 0.7, 0.0}, values));
  CHECK_NOTHROW(query.values(std::array{0.3, 0.7, 0.0}, values));
  CHECK_THAT(error_text<OutsideBoxError>([&] {
               query.values(std::array{0.25, 0.7, 0.0}, values);
             }),
             Contains("gap between the pieces"));
}

TEST_CASE("an answer does not depend on what was asked before") {
  const Codebook book = four_pieces();
  Query used(book);
  Eigen::VectorXd a(3), b(3);
  const Eigen::MatrixXd points = random_points(book, 20, 9);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    used.values(point(points, j), a);
    CHECK_THROWS(used.values(std::array{0.1, 9.0, 0.0}, b));
    Query(book).values(point(points, j), b);
    CHECK(a == b);
  }
}
