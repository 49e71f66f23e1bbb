// Questions without an answer, and files that change while they are asked.
#include <array>
#include <atomic>
#include <filesystem>
#include <limits>
#include <thread>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "sample_books.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using samara::ArgumentError;
using samara::InputError;
using samara::OutsideBoxError;

namespace {

constexpr int kSlabs = 24;

/// Slabs of a second each, in a file of more than 1 MiB: pieces are read as they are asked for.
Codebook long_book() {
  std::vector<Piece> pieces;
  for (unsigned k = 0; k < kSlabs; ++k) pieces.push_back(random_piece({1.0 * k, 1.0 + k, 0.5, 2.0}, k, 150));
  return Codebook(sample_model(), pieces);
}

std::array<double, 3> in_slab(int k) {
  return {k + 0.5, 0.7, 0.1};
}

/// Two slabs with nothing between 1 s and 2 s.
Codebook torn_book() {
  return Codebook(sample_model(),
                  {random_piece({0.0, 1.0, 0.5, 2.0}, 1), random_piece({2.0, 3.0, 0.5, 2.0}, 2)});
}

}  // namespace

TEST_CASE("trajectories of no times have no answers, in batches and residuals too") {
  for (const Precision precision : {Precision::double_precision, Precision::automatic}) {
    const Codebook bare = four_pieces();
    const Codebook book = bare.with_certificate(sample_certificate(bare));
    TrajectoryQuery query(book, {}, QueryOptions{.precision = precision});
    CHECK(query.time_count() == 0);
    CHECK_NOTHROW(query.inner_size());
    Eigen::MatrixXd values(0, 40);
    const Eigen::MatrixXd points = random_points(book, 40, 3).bottomRows(2);
    CHECK_NOTHROW(query.batch(points, values));
    CHECK_NOTHROW(query.batch(points, values, 2));
    CHECK_NOTHROW(query.residuals(std::array{0.7, 0.0}, {}, {}, {}));
    TrajectoryQuery copy = query;
    Eigen::MatrixXd none(0, 3);
    CHECK_THROWS_AS(copy.values(std::array{9.0, 0.0}, none), OutsideBoxError);
  }
}

TEST_CASE("a time held in a gap between pieces leaves every point outside") {
  const Codebook book = torn_book();
  Query query(book, {.fixed = {{"t", 1.5}}});
  Eigen::VectorXd values(3);
  Eigen::MatrixXd gradient(3, 2), all(3, 50), none(3, 0);
  CHECK_THROWS_AS(query.values(std::array{0.7, 0.1}, values), OutsideBoxError);
  CHECK_THROWS_AS(query.values(std::array{0.7, 0.1}, values, gradient), OutsideBoxError);
  const Eigen::MatrixXd points = random_points(book, 50, 3).bottomRows(2);
  CHECK_THROWS_AS(query.batch(points, all), OutsideBoxError);
  CHECK_NOTHROW(query.batch(points.leftCols(0), none));
  TrajectoryQuery frames(book, {0.5, 1.5, 2.5});
  Eigen::MatrixXd path(3, 3), paths(9, 50);
  CHECK_THAT(error_text<OutsideBoxError>([&] {
               frames.values(std::array{0.7, 0.1}, path);
             }),
             Contains("t = 1.5") && Contains("gap"));
  CHECK_THROWS_AS(frames.batch(points, paths, 2), OutsideBoxError);
}

TEST_CASE("one bad point among very many is found, whoever meets it") {
  constexpr int kMany = 50'000;
  const Codebook book = golden_book();
  Query query(book);
  Eigen::MatrixXd points = random_points(book, kMany, 5), values(2, kMany);
  CHECK_NOTHROW(query.batch(points, values, 0));
  CHECK(values.allFinite());
  for (const Eigen::Index place : {0, kMany / 2, kMany - 1}) {
    Eigen::MatrixXd spoilt = points;
    spoilt(1, place) = std::numeric_limits<double>::quiet_NaN();
    for (const int threads : {1, 2})
      CHECK_THAT(error_text<ArgumentError>([&] { query.batch(spoilt, values, threads); }),
                 Contains("C_D is nan"));
    spoilt(1, place) = 2.5;
    for (const int threads : {1, 2}) CHECK_THROWS_AS(query.batch(spoilt, values, threads), OutsideBoxError);
  }
  // And the query is as good as before.
  Eigen::MatrixXd again(2, kMany);
  query.batch(points, again, 2);
  query.batch(points, values, 1);
  CHECK(again == values);
}

TEST_CASE("a file that is deleted or replaced while it is open answers as before") {
  const TemporaryDirectory directory;
  const Codebook book = long_book();
  save(book, directory / "book.h5");
  REQUIRE(std::filesystem::file_size(directory / "book.h5") > (1u << 20));
  Query original(book);
  Eigen::VectorXd values(3), expected(3);
  const auto check = [&](Query& query, int slab) {
    original.values(in_slab(slab), expected);
    query.values(in_slab(slab), values);
    CHECK(values == expected);
  };
  const Codebook read = load(directory / "book.h5");
  Query query(read);
  check(query, 3);
  save(four_pieces(), directory / "book.h5");  // another one in its place
  check(query, 5);
  std::filesystem::remove(directory / "book.h5");
  for (int slab = 0; slab < kSlabs; ++slab) check(query, slab);
}

TEST_CASE("a file that is cut short while it is open is refused, again and again") {
  const TemporaryDirectory directory;
  const std::filesystem::path path = directory / "book.h5";
  save(long_book(), path);
  const Codebook book = load(path);
  Query query(book);
  Eigen::VectorXd values(3);
  query.values(in_slab(0), values);
  std::filesystem::resize_file(path, std::filesystem::file_size(path) / 20);
  for (int i = 0; i < 2; ++i) {
    CHECK_THAT(error_text<InputError>([&] { query.values(in_slab(kSlabs - 1), values); }),
               Contains(path.string()));
    CHECK_THROWS_AS(Query(query).values(in_slab(kSlabs - 1), values), InputError);
  }
  CHECK_THROWS_AS(TrajectoryQuery(book, {kSlabs - 0.5}), InputError);
  CHECK_NOTHROW(query.values(in_slab(0), values));
  CHECK_THROWS_AS(load(path), InputError);
}

TEST_CASE("several threads open one file, and save others, side by side") {
  const TemporaryDirectory directory;
  const Codebook book = long_book();
  save(book, directory / "book.h5");
  Query original(book);
  Eigen::VectorXd expected(3);
  original.values(in_slab(7), expected);
  std::atomic<int> same = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] {
      for (int round = 0; round < 3; ++round) {
        const Codebook own = load(directory / "book.h5");
        Eigen::VectorXd mine(3);
        Query(own).values(in_slab(7), mine);
        same += mine == expected ? 1 : 0;
        save(four_pieces(), directory / (std::to_string(i) + ".h5"));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(same == 12);
}
