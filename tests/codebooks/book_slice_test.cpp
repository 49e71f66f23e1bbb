#include "samara/codebooks/book/book_slice.h"

#include <random>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/base/errors.h"
#include "samara/codebooks/query/query.h"
#include "sample_books.h"

using namespace samara::codebooks;

namespace {

/// The largest difference between a slice and the whole with the coordinates held.
double difference(const Codebook& book, const std::map<std::string, double>& held) {
  const Codebook part = slice(book, held);
  Query query(part), whole(book, {.fixed = held});
  Eigen::VectorXd values(book.output_count()), expected(book.output_count());
  const Eigen::MatrixXd points = random_points(part, 200, 3);
  double largest = 0.0;
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), values);
    whole.values(point(points, j), expected);
    largest =
        std::max(largest, (values - expected).cwiseAbs().maxCoeff() / (1.0 + expected.cwiseAbs().maxCoeff()));
  }
  return largest;
}

/// One output over these axes. Nothing makes pieces of different seeds agree where they meet.
Piece random_over(const std::vector<samara::pgd::Axis>& axes, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<Eigen::MatrixXd> factors;
  for (const samara::pgd::Axis& axis : axes)
    factors.push_back(Eigen::MatrixXd::NullaryExpr(axis.size(), 2, [&] { return uniform(random); }).eval());
  const Eigen::RowVector2d weights = Eigen::RowVector2d::Ones();
  return Piece::Groups{samara::pgd::SeparatedField(axes, {{"x", "m"}}, factors, weights)};
}

/// A random piece over intervals of t, C_D and v(0).
Piece random_cell(const Eigen::Vector2d& t, const Eigen::Vector2d& C_D, const Eigen::Vector2d& v,
                  unsigned seed) {
  using samara::pgd::Axis;
  using samara::pgd::AxisRole;
  return random_over({Axis::radau({"t", "s", AxisRole::time}, t[0], t[1], 2, 3),
                      Axis::chebyshev({"C_D", "1", AxisRole::parameter}, C_D[0], C_D[1], 4),
                      Axis::p2({"v(0)", "m/s", AxisRole::initial}, v[0], v[1], 3)},
                     seed);
}

/// The pieces, and the same as trains.
std::vector<Codebook> of_both_kinds(const std::vector<Piece>& pieces) {
  std::vector<Piece> trains;
  for (const Piece& piece : pieces) trains.push_back(as_trains(piece));
  return {Codebook(sample_model(), pieces), Codebook(sample_model(), trains)};
}

}  // namespace

TEST_CASE("a slice answers as the codebook with its coordinates held") {
  for (const Codebook& book : {four_pieces(), four_pieces_of_trains()}) {
    CHECK(difference(book, {{"C_D", 0.7}}) < 1e-12);
    CHECK(difference(book, {{"C_D", 1.9}}) < 1e-12);
    CHECK(difference(book, {{"v(0)", 0.2}}) < 1e-12);
  }
  CHECK(difference(golden_command(), {{"a", 1.5}}) < 1e-12);
  CHECK(difference(golden_front(), {{"k", 0.3}}) < 1e-12);
  CHECK(difference(golden_front(), {{"h", -1.7}}) < 1e-12);
  CHECK(difference(golden_front(), {{"C", 1.7}, {"k", 0.9}, {"h", 0.2}}) < 1e-12);
  CHECK(difference(all_kinds(), {{"plies", 2.0}, {"angle", 0.4}, {"h", 0.5}}) < 1e-12);
}

TEST_CASE("at a border of pieces the lower one is sliced, and at the lower end of the box the lowest") {
  const Codebook book = four_pieces();
  const Codebook at_border = slice(book, {{"C_D", kCellBorder}});
  CHECK(at_border.pieces().size() == 2);
  CHECK(difference(book, {{"C_D", kCellBorder}}) < 1e-12);
  CHECK(difference(book, {{"C_D", 0.5}}) < 1e-12);
}

TEST_CASE("where no lower piece reaches a border, the upper one is sliced") {
  const Codebook all = four_pieces();
  const Codebook book(sample_model(), {all.pieces()[0], all.pieces()[1], all.pieces()[3]});
  CHECK(slice(book, {{"C_D", kCellBorder}}).pieces().size() == 2);
  CHECK(difference(book, {{"C_D", kCellBorder}}) < 1e-12);
}

TEST_CASE("at a border those pieces are sliced that queries come to, also beside slabs of other lengths") {
  const Codebook ends_early(sample_model(), {random_piece({0.0, 0.3, 0.5, kCellBorder}, 1),
                                             random_piece({0.0, kSlabBorder, kCellBorder, 2.0}, 2),
                                             random_piece({kSlabBorder, 0.5, kCellBorder, 2.0}, 3)});
  const Codebook part = slice(ends_early, {{"C_D", kCellBorder}});
  CHECK(part.pieces().size() == 2);
  CHECK(part.coordinates().front().upper == 0.5);
  CHECK(difference(ends_early, {{"C_D", kCellBorder}}) < 1e-12);
  const Codebook begins_late(sample_model(), {random_piece({0.0, kSlabBorder, 0.5, kCellBorder}, 1),
                                              random_piece({kSlabBorder, 0.5, 0.5, kCellBorder}, 2),
                                              random_piece({0.0, 0.5, kCellBorder, 2.0}, 3)});
  CHECK(slice(begins_late, {{"C_D", kCellBorder}}).pieces().size() == 2);
  CHECK(difference(begins_late, {{"C_D", kCellBorder}}) < 1e-12);
}

TEST_CASE("where pieces overlap, a slice answers by the piece that queries come to") {
  // Without C_D the second piece has the lower corner.
  const std::vector<Piece> pieces = {random_cell({0.0, 1.0}, {0.5, 1.0}, {0.2, 0.6}, 1),
                                     random_cell({0.0, 1.0}, {0.8, 2.0}, {-0.3, 0.6}, 2)};
  for (const Codebook& book : of_both_kinds(pieces)) {
    CHECK(difference(book, {{"C_D", 0.9}}) < 1e-12);
    CHECK(difference(book, {{"C_D", 1.0}}) < 1e-12);
    CHECK(slice(book, {{"C_D", 0.7}}).pieces().size() == 1);
    CHECK(slice(book, {{"C_D", 1.1}}).pieces().size() == 1);
  }
}

TEST_CASE(
    "where cells with slabs of their own meet, a slice answers as queries do, by each part of its box once") {
  const std::vector<Piece> pieces = {random_cell({0.0, 0.3}, {0.5, 1.0}, {-0.3, 0.1}, 1),
                                     random_cell({0.3, 1.0}, {0.5, 1.0}, {-0.3, 0.1}, 2),
                                     random_cell({0.0, 0.4}, {0.5, 1.0}, {0.1, 0.6}, 3),
                                     random_cell({0.4, 1.0}, {0.5, 1.0}, {0.1, 0.6}, 4),
                                     random_cell({0.0, 1.0}, {1.0, 2.0}, {-0.3, 0.6}, 5)};
  for (const Codebook& book : of_both_kinds(pieces)) {
    CHECK(difference(book, {{"C_D", 1.0}}) < 1e-12);
    double area = 0.0;
    const Codebook part = slice(book, {{"C_D", 1.0}});
    for (const Piece& piece : part.pieces())
      area += (piece.upper()[0] - piece.lower()[0]) * (piece.upper()[1] - piece.lower()[1]);
    CHECK(area == Approx(1.0 * 0.9).epsilon(1e-14));
  }
}

TEST_CASE("a value of a list is sliced from the piece that has it") {
  using samara::pgd::Axis;
  using samara::pgd::AxisRole;
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3);
  const Axis v = Axis::p1({"v(0)", "m/s", AxisRole::initial}, 0.0, 1.0, 4);
  const Axis::Label plies{"plies", "1", AxisRole::parameter};
  const Codebook book(sample_model(),
                      {random_over({t, Axis::discrete(plies, Eigen::Vector2d(1.0, 4.0)), v}, 1),
                       random_over({t, Axis::discrete(plies, Eigen::Vector2d(2.0, 3.0)), v}, 2)});
  for (const double value : {1.0, 2.0, 3.0, 4.0}) CHECK(difference(book, {{"plies", value}}) < 1e-12);
  CHECK_THROWS_AS(slice(book, {{"plies", 2.5}}), samara::OutsideBoxError);
}

TEST_CASE("where lists overlap, the later piece keeps the values that no earlier one has") {
  using samara::pgd::Axis;
  using samara::pgd::AxisRole;
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3);
  const Axis C_D = Axis::chebyshev({"C_D", "1", AxisRole::parameter}, 0.0, 1.0, 4);
  const Axis v = Axis::p1({"v(0)", "m/s", AxisRole::initial}, 0.0, 1.0, 4);
  const Axis::Label plies{"plies", "1", AxisRole::parameter};
  const std::vector<Piece> pieces = {
      random_over({t, C_D, Axis::discrete(plies, Eigen::Vector2d(1.0, 2.0)), v}, 1),
      random_over({t, C_D, Axis::discrete(plies, Eigen::Vector3d(2.0, 3.0, 4.0)), v}, 2)};
  for (const Codebook& book : of_both_kinds(pieces)) {
    const std::map<std::string, double> held = {{"C_D", 0.5}};
    const Codebook part = slice(book, held);
    REQUIRE(part.pieces().size() == 2);
    CHECK(part.pieces()[1].groups().front().axes()[1].nodes() == Eigen::Vector2d(3.0, 4.0));
    Query query(part), whole(book, {.fixed = held});
    Eigen::VectorXd value(1), expected(1);
    for (const double listed : {1.0, 2.0, 3.0, 4.0}) {
      query.values({{0.7, listed, 0.3}}, value);
      whole.values({{0.7, listed, 0.3}}, expected);
      CHECK(value[0] == Approx(expected[0]).margin(1e-12));
    }
  }
}

TEST_CASE("pieces apart hold each part of the box once, and answer as queries do where they overlapped") {
  const std::vector<Piece> pieces = {random_cell({0.0, 1.0}, {0.5, 1.2}, {-0.3, 0.6}, 1),
                                     random_cell({0.0, 1.0}, {1.0, 2.0}, {-0.3, 0.6}, 2),
                                     random_cell({0.5, 1.5}, {0.5, 2.0}, {-0.3, 0.6}, 3)};
  for (const Codebook& book : of_both_kinds(pieces)) {
    CHECK(pieces_overlap(book.pieces()));
    const Codebook apart = with_pieces_apart(book);
    CHECK_FALSE(pieces_overlap(apart.pieces()));
    double volume = 0.0;
    for (const Piece& piece : apart.pieces()) {
      double part = 1.0;
      for (std::size_t k = 0; k < 3; ++k) part *= piece.upper()[k] - piece.lower()[k];
      volume += part;
    }
    CHECK(volume == Approx(1.5 * 1.5 * 0.9).epsilon(1e-14));
    Query query(apart), whole(book);
    Eigen::VectorXd value(1), expected(1);
    const Eigen::MatrixXd points = random_points(book, 200, 3);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      query.values(point(points, j), value);
      whole.values(point(points, j), expected);
      CHECK(value[0] == Approx(expected[0]).margin(1e-12));
    }
  }
}

TEST_CASE("pieces that do not overlap are apart as they are") {
  for (const Codebook& book : {four_pieces(), golden_front(), all_kinds()}) {
    const Codebook apart = with_pieces_apart(book);
    REQUIRE(apart.pieces().size() == book.pieces().size());
    for (std::size_t p = 0; p < book.pieces().size(); ++p)
      CHECK(&apart.pieces()[p].groups() == &book.pieces()[p].groups());
  }
}

TEST_CASE("at a time, pieces hold each part of the box once, also where slabs meet") {
  const Codebook book(sample_model(), {random_cell({0.0, 1.0}, {0.5, 1.0}, {-0.3, 0.6}, 1),
                                       random_cell({0.0, 1.0}, {1.0, 2.0}, {-0.3, 0.6}, 2),
                                       random_cell({1.0, 2.0}, {0.5, 1.3}, {-0.3, 0.6}, 3),
                                       random_cell({1.0, 2.0}, {1.3, 2.5}, {-0.3, 0.6}, 4)});
  const auto lengths_at = [&](double time) {
    std::vector<double> lengths;
    for (const Piece& piece : pieces_at(book, time))
      lengths.push_back(piece.upper().front() - piece.lower().front());
    return lengths;
  };
  CHECK(lengths_at(0.5) == std::vector<double>{0.5, 1.0});
  CHECK(lengths_at(1.0) == std::vector<double>{0.5, 1.0, 0.5});
  CHECK(lengths_at(1.5) == std::vector<double>{1.3 - 0.5, 2.5 - 1.3});
}

TEST_CASE("pieces that cross so often that their parts would fill the memory are refused") {
  using samara::pgd::Axis;
  std::vector<Piece> pieces;
  for (std::size_t thin = 1; thin <= 5; ++thin) {
    for (int j = 0; j < 20; ++j) {
      std::vector<Axis> axes;
      for (std::size_t k = 0; k <= 5; ++k) {
        const double lower = k == thin ? 0.05 * (j + 0.2) : 0.0, upper = k == thin ? 0.05 * (j + 0.6) : 1.0;
        axes.push_back(Axis::p1({std::string(1, static_cast<char>('a' + k))}, lower, upper, 2));
      }
      pieces.push_back(random_over(axes, static_cast<unsigned>(j)));
    }
  }
  ModelDescription model;
  model.name = "crossing";
  const Codebook book(model, pieces);
  const auto refusal = [](const auto& call) { return error_text<samara::ArgumentError>(call); };
  CHECK_THAT(refusal([&] { slice(book, {{"a", 0.5}}); }), Catch::Contains("more than 10000 further"));
  CHECK_THAT(refusal([&] { with_pieces_apart(book); }), Catch::Contains("more than 10000 further"));
}

TEST_CASE("a piece that would have to be cut along a period stays whole") {
  using samara::pgd::Axis;
  using samara::pgd::AxisRole;
  const Axis t = Axis::radau({"t", "s", AxisRole::time}, 0.0, 1.0, 2, 3);
  const auto over = [&](double C_lower, double C_upper, double period, unsigned seed) {
    return random_over({t, Axis::chebyshev({"C_D", "1", AxisRole::parameter}, C_lower, C_upper, 4),
                        Axis::fourier({"angle", "rad", AxisRole::parameter}, 0.0, period, 5)},
                       seed);
  };
  const Codebook book(sample_model(), {over(0.5, 1.0, 1.0, 1), over(1.0, 2.0, 2.0, 2)});
  const Codebook part = slice(book, {{"C_D", 1.0}});
  REQUIRE(part.pieces().size() == 2);
  CHECK(part.pieces()[1].upper()[1] == 2.0);
  CHECK(difference(book, {{"C_D", 1.0}}) < 1e-12);
}

TEST_CASE("a slice says what was held, and has no certificate") {
  const Codebook book = golden_climbs();
  REQUIRE(book.certificate());
  const Codebook part = slice(book, {{"b", 0.25}});
  CHECK_FALSE(part.certificate());
  CHECK(part.coordinate_count() == 1);
  CHECK(part.model().fixed.at("b") == 0.25);
  CHECK(slice(book, {}).certificate());
}

TEST_CASE("a slice outside the box, of time, or of everything is refused") {
  const Codebook book = four_pieces();
  CHECK_THROWS_AS(slice(book, {{"C_D", 7.0}}), samara::OutsideBoxError);
  CHECK_THROWS_AS(slice(book, {{"t", 0.1}}), samara::ArgumentError);
  CHECK_THROWS_AS(slice(book, {{"C_X", 1.0}}), samara::ArgumentError);
  CHECK_THROWS_AS(slice(book, {{"C_D", std::nan("")}}), samara::ArgumentError);
  CHECK_THROWS_AS(slice(book, {{"C_D", 1.0}, {"v(0)", 0.0}}), samara::ArgumentError);
}

TEST_CASE("a slice of a field over a mesh keeps the mesh, and a steady field may hold its place") {
  const Codebook book = golden_mesh();
  const Codebook over_mesh = slice(book, {{"k", 0.75}});
  REQUIRE(over_mesh.mesh() != nullptr);
  CHECK(over_mesh.mesh()->points() == book.mesh()->points());
  const Codebook at_node = slice(book, {{"node", 1.0}});
  CHECK(at_node.mesh() == nullptr);
  Eigen::VectorXd value(1);
  Query(at_node).values({{0.25}}, value);
  CHECK(value[0] == Approx(0.25 + 1.0));  // u = k + x + 2 y
}
