#include "samara/codebooks/book/book_slice.h"

#include <catch2/catch.hpp>

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
