#include "samara/codebooks/query/trajectory_query.h"

#include <array>
#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/codebooks/query/query.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::OutsideBoxError;

namespace {

/// Times of all kinds: both ends, borders of pieces and of elements, twice the same, not ascending.
std::vector<double> sample_times(const Codebook& book) {
  std::vector<double> times = {0.123, 0.011, 0.123};
  for (const Piece& piece : book.pieces()) {
    for (const double border : piece.groups().front().axes().front().borders()) times.push_back(border);
  }
  const Coordinate& time = book.coordinates().front();
  for (int i = 0; i <= 50; ++i) times.push_back(time.lower + (time.upper - time.lower) * i / 50.0);
  return times;
}

/// Compares a trajectory query for `outputs` with Query at every time.
void check_against_query(const Codebook& book, const std::vector<std::string>& outputs,
                         const std::vector<double>& q) {
  const std::vector<double> times = sample_times(book);
  TrajectoryQuery trajectory(book, times, outputs);
  Query query(book);
  const auto count = static_cast<Eigen::Index>(times.size());
  const int chosen = outputs.empty() ? book.output_count() : static_cast<int>(outputs.size());
  const int parameters = book.coordinate_count() - 1;
  REQUIRE(trajectory.time_count() == count);
  REQUIRE(trajectory.output_count() == chosen);
  REQUIRE(trajectory.parameter_count() == parameters);
  const double unset = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd values = Eigen::MatrixXd::Constant(count, chosen, unset);
  Eigen::MatrixXd again = values;
  Eigen::MatrixXd derivatives = Eigen::MatrixXd::Constant(count, chosen * parameters, unset);
  trajectory.values(q, values);
  trajectory.values(q, again, derivatives);
  CHECK((values - again).norm() < 1e-13 * 10.0 * std::sqrt(static_cast<double>(values.size())));
  Eigen::VectorXd expected(book.output_count());
  Eigen::MatrixXd gradient(book.output_count(), book.coordinate_count());
  for (Eigen::Index i = 0; i < count; ++i) {
    std::vector<double> x = q;
    x.insert(x.begin(), times[static_cast<std::size_t>(i)]);
    query.values(x, expected, gradient);
    for (int o = 0; o < chosen; ++o) {
      const int place = outputs.empty() ? o : book.output_index(outputs[static_cast<std::size_t>(o)]);
      // The same products in another order: a few eps per term, of fields and derivatives of size 1 and 100.
      REQUIRE(std::abs(values(i, o) - expected[place]) < 1e-13 * 10.0);
      for (int k = 0; k < parameters; ++k)
        REQUIRE(std::abs(derivatives(i, o + chosen * k) - gradient(place, k + 1)) < 1e-13 * 1000.0);
    }
  }
}

const std::vector<std::vector<double>> kParameters = {
    {0.7, 0.2}, {1.7, -0.25}, {kCellBorder, 0.05}, {0.5, -0.3}, {2.0, 0.6}};

}  // namespace

TEST_CASE("a trajectory query answers as a query does, at every time of every piece") {
  for (const auto& q : kParameters) check_against_query(four_pieces(), {}, q);
}

TEST_CASE("a trajectory query of trains answers as a query does") {
  for (const auto& q : kParameters) {
    check_against_query(four_pieces_of_trains(), {}, q);
    check_against_query(four_pieces_of_trains(), {"E", "x"}, q);
  }
}

TEST_CASE("chosen outputs come in the order in which they were chosen") {
  for (const auto& q : kParameters) {
    check_against_query(four_pieces(), {"E", "x"}, q);
    check_against_query(four_pieces(), {"v"}, q);
    check_against_query(four_pieces(), {"v", "E", "x"}, q);
  }
}

TEST_CASE("a trajectory query answers as a query does for a codebook that was built") {
  const Codebook& book = coin_build().book;
  for (const std::vector<double>& q : {std::vector{0.8, 0.0}, {1.234, 0.111}, {1.6, 0.3}}) {
    check_against_query(book, {}, q);
    check_against_query(book, {"x"}, q);
  }
}

TEST_CASE("pieces that meet only in a corner each answer for their own times") {
  std::vector<Piece> pieces = {four_pieces().pieces()[0], four_pieces().pieces()[3]};
  const Codebook book(sample_model(), pieces);
  TrajectoryQuery early(book, {0.0, 0.1, kSlabBorder});
  TrajectoryQuery all(book, {0.0, 0.1, 0.3});
  Eigen::MatrixXd values(3, 3);
  CHECK_NOTHROW(early.values(std::array{0.7, 0.0}, values));
  // Where no piece answers, no number is left from before.
  CHECK_THAT(error_text<OutsideBoxError>([&] {
               all.values(std::array{0.7, 0.0}, values);
             }),
             Contains("t = 0.3") && Contains("gap between the pieces"));
  CHECK_THAT(error_text<OutsideBoxError>([&] {
               early.values(std::array{1.7, 0.0}, values);
             }),
             Contains("gap between the pieces"));
  CHECK_NOTHROW(all.values(std::array{kCellBorder, 0.0}, values));
}

TEST_CASE("no times give no rows") {
  const Codebook book = four_pieces();
  TrajectoryQuery query(book, {});
  Eigen::MatrixXd values(0, 3), derivatives(0, 6);
  CHECK_NOTHROW(query.values(std::array{0.7, 0.0}, values, derivatives));
}

TEST_CASE("an output that is unknown or chosen twice is refused") {
  const Codebook book = four_pieces();
  CHECK_THAT(error_text<ArgumentError>([&] {
               TrajectoryQuery(book, {0.1}, {"x", "w"});
             }),
             Contains("no output \"w\"; known: x, v, E"));
  CHECK_THAT(error_text<ArgumentError>([&] { TrajectoryQuery(coin_build().book, {0.1}, {"xx"}); }),
             Contains("did you mean \"x\"?"));
  CHECK_THAT(error_text<ArgumentError>([&] {
               TrajectoryQuery(book, {0.1}, {"x", "v", "x"});
             }),
             Contains("\"x\" is chosen twice"));
}

TEST_CASE("times and parameters outside the box or not finite are refused") {
  const Codebook book = four_pieces();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(error_text<OutsideBoxError>([&] {
          TrajectoryQuery(book, {0.1, 0.51});
        }) == "t = 0.51 s is outside the codebook's box [0, 0.5]");
  CHECK_THROWS_AS(TrajectoryQuery(book, {nan}), ArgumentError);
  TrajectoryQuery query(book, {0.1, 0.4});
  Eigen::MatrixXd values(2, 3), derivatives(2, 6);
  const auto refused = [&](auto kind, const std::vector<double>& q) {
    using Kind = decltype(kind);
    const std::string text = error_text<Kind>([&] { query.values(q, values); });
    CHECK(error_text<Kind>([&] { query.values(q, values, derivatives); }) == text);
    return text;
  };
  CHECK(refused(OutsideBoxError(""), {2.1, 0.0}) == "C_D = 2.1 is outside the codebook's box [0.5, 2]");
  CHECK(refused(ArgumentError(""), {nan, 0.0}) == "C_D is nan, expected a finite number");
  CHECK(refused(ArgumentError(""), {1.0}) == "the point has 1 coordinates, expected 2");
  CHECK(refused(ArgumentError(""), {0.1, 1.0, 0.0}) == "the point has 3 coordinates, expected 2");
}

TEST_CASE("answers of another size than asked for are refused, not written beyond") {
  const Codebook book = four_pieces();
  TrajectoryQuery query(book, {0.1, 0.4}, {"v"});
  const std::array q = {0.7, 0.0};
  Eigen::MatrixXd values(2, 1), derivatives(2, 2), wide(2, 3), tall(3, 1);
  CHECK_NOTHROW(query.values(q, values, derivatives));
  CHECK_THAT(error_text<ArgumentError>([&] { query.values(q, wide); }),
             Contains("have 2 rows and 3 columns, expected 2 and 1"));
  CHECK_THROWS_AS(query.values(q, tall), ArgumentError);
  CHECK_THAT(error_text<ArgumentError>([&] { query.values(q, values, wide); }),
             Contains("derivatives") && Contains("expected 2 and 2"));
}
