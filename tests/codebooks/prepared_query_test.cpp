// What a query may be told before the first point, and what it gives besides values at a point.
#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
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

/// Values of all outputs, and their gradient, one point at a time.
struct Answers {
  Eigen::MatrixXd values;
  std::vector<Eigen::MatrixXd> gradients;
};
Answers answers(const Codebook& book, const Eigen::MatrixXd& points) {
  Query query(book);
  Answers result{Eigen::MatrixXd(book.output_count(), points.cols()), {}};
  Eigen::VectorXd values(book.output_count());
  Eigen::MatrixXd gradient(book.output_count(), book.coordinate_count());
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    query.values(point(points, j), values, gradient);
    result.values.col(j) = values;
    result.gradients.push_back(gradient);
  }
  return result;
}

std::vector<Codebook> books() {
  return {four_pieces(), four_pieces_of_trains(), golden_trains(), all_kinds()};
}

/// The parameters of points of a codebook with time.
Eigen::MatrixXd parameters(const Codebook& book, int count, unsigned seed) {
  return random_points(book, count, seed).bottomRows(book.coordinate_count() - 1);
}

}  // namespace

TEST_CASE("a query that holds coordinates answers as one that is given them") {
  for (const Codebook& book : {four_pieces(), four_pieces_of_trains()}) {
    const Eigen::MatrixXd points = random_points(book, 50, 5);
    const Answers expected = answers(book, points);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      for (int held = 0; held < 3; ++held) {
        const auto& names = book.coordinates();
        const auto at = static_cast<std::size_t>(held);
        Query query(book, {.outputs = {"E", "x"}, .fixed = {{names[at].name, points(held, j)}}});
        REQUIRE(query.coordinates().size() == 2);
        std::vector<double> x;
        std::vector<int> free;
        for (int k = 0; k < 3; ++k) {
          if (k == held) continue;
          free.push_back(k);
          x.push_back(points(k, j));
        }
        Eigen::VectorXd values(2);
        Eigen::MatrixXd gradient(2, 2);
        query.values(x, values, gradient);
        const std::array<int, 2> outputs = {2, 0};  // x, v, E
        for (int o = 0; o < 2; ++o) {
          const int place = outputs[static_cast<std::size_t>(o)];
          CHECK(std::abs(values[o] - expected.values(place, j)) < 1e-12);
          for (int k = 0; k < 2; ++k)
            CHECK(std::abs(gradient(o, k) - expected.gradients[static_cast<std::size_t>(j)](
                                                place, free[static_cast<std::size_t>(k)])) < 1e-10);
        }
      }
    }
  }
}

TEST_CASE("what is held or chosen must be of the codebook, and leave something free") {
  const Codebook book = four_pieces();
  CHECK_THAT(error_text<ArgumentError>([&] {
               Query(book, {.fixed = {{"C_L", 1.0}}});
             }),
             Contains("no coordinate \"C_L\""));
  CHECK_THAT(error_text<OutsideBoxError>([&] {
               Query(book, {.fixed = {{"t", 0.7}}});
             }),
             Contains("t = 0.7 s is outside"));
  CHECK_THAT(error_text<ArgumentError>([&] {
               Query(book, {.outputs = {"x", "x"}});
             }),
             Contains("chosen twice"));
  CHECK_THAT(error_text<ArgumentError>([&] {
               Query(book, {.fixed = {{"t", 0.1}, {"C_D", 1.0}, {"v(0)", 0.0}}});
             }),
             Contains("expected one that is free"));
  CHECK_THAT(error_text<ArgumentError>([&] {
               TrajectoryQuery(book, {0.1}, QueryOptions{.fixed = {{"t", 0.1}}});
             }),
             Contains("cannot hold time"));
}

TEST_CASE("second derivatives are those of the gradient") {
  for (const Codebook& book : {four_pieces(), four_pieces_of_trains()}) {
    Query query(book);
    const Eigen::MatrixXd points = random_points(book, 20, 9);
    Eigen::VectorXd values(3);
    Eigen::MatrixXd gradient(3, 3), hessian(3, 9), before(3, 3), behind(3, 3);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      query.values(point(points, j), values, gradient, hessian);
      for (int k = 0; k < 3; ++k) {
        const Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
        const double h = 1e-6 * (c.upper - c.lower);
        std::vector<double> x(point(points, j).begin(), point(points, j).end());
        const auto at = static_cast<std::size_t>(k);
        x[at] = points(k, j) + h;
        query.values(x, values, behind);
        x[at] = points(k, j) - h;
        query.values(x, values, before);
        const Eigen::MatrixXd expected = (behind - before) / (2.0 * h);
        // Central differences: round-off of slopes of 1e2 over h, and a third derivative of 1e6 times h^2.
        const double scale = 1.0 + hessian.cwiseAbs().maxCoeff();
        for (int i = 0; i < 3; ++i)
          CHECK((hessian.col(i + 3 * k) - expected.col(i)).cwiseAbs().maxCoeff() < 1e-6 * scale);
      }
    }
  }
}

TEST_CASE("second derivatives under transforms and on a period are those of the exact functions") {
  // u = v(0) sqrt(m) + t log(C_D) cos(2 angle) plies + k^2 / h
  const Codebook book = all_kinds();
  Query query(book);
  const int n = book.coordinate_count();
  Eigen::VectorXd values(1);
  Eigen::MatrixXd gradient(1, n), hessian(1, n * n);
  const Eigen::MatrixXd points = random_points(book, 30, 4);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const auto at = [&](const char* name) { return points(book.coordinate_index(name), j); };
    const auto second = [&](const char* a, const char* b) {
      return hessian(0, book.coordinate_index(a) + n * book.coordinate_index(b));
    };
    query.values(point(points, j), values, gradient, hessian);
    const double C = at("C_D"), h = at("h"), m = at("m"), angle = at("angle"), k = at("k");
    const double part = at("t") * at("plies");
    CHECK(second("C_D", "C_D") == Approx(-part * std::cos(2.0 * angle) / (C * C)).epsilon(1e-8).margin(1e-6));
    CHECK(second("angle", "angle") ==
          Approx(-4.0 * part * std::log(C) * std::cos(2.0 * angle)).epsilon(1e-8).margin(1e-8));
    CHECK(second("h", "h") == Approx(2.0 * k * k / (h * h * h)).epsilon(1e-8).margin(1e-8));
    CHECK(second("m", "m") == Approx(-0.25 * at("v(0)") / (m * std::sqrt(m))).epsilon(1e-6).margin(1e-6));
    CHECK(second("k", "h") == Approx(-2.0 * k / (h * h)).epsilon(1e-8).margin(1e-8));
    CHECK(second("h", "k") == second("k", "h"));
  }
}

TEST_CASE("a batch answers as point after point, on any number of threads") {
  for (const Codebook& book : books()) {
    // More than a chunk, and no multiple of a block.
    const Eigen::MatrixXd points = random_points(book, 1237, 8);
    const Eigen::MatrixXd expected = answers(book, points).values;
    for (const int threads : {1, 2, 0}) {
      Query query(book);
      Eigen::MatrixXd values = Eigen::MatrixXd::Constant(book.output_count(), points.cols(),
                                                         std::numeric_limits<double>::quiet_NaN());
      query.batch(points, values, threads);
      CHECK((values - expected).cwiseAbs().maxCoeff() < 1e-11 * (1.0 + expected.cwiseAbs().maxCoeff()));
    }
  }
}

TEST_CASE("a batch of trajectories answers as one after the other, on any number of threads") {
  for (const Codebook& book : {four_pieces(), four_pieces_of_trains(), golden_trains()}) {
    const Eigen::MatrixXd points = parameters(book, 700, 2);
    const std::vector<double> times = {0.0, 0.2, 0.45, 0.1};
    TrajectoryQuery query(book, times);
    const Eigen::Index rows = 4 * book.output_count();
    Eigen::MatrixXd one(4, book.output_count()), all(rows, points.cols());
    for (const int threads : {1, 2}) {
      query.batch(points, all, threads);
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        query.values(point(points, j), one);
        REQUIRE((all.col(j) - one.reshaped()).cwiseAbs().maxCoeff() < 1e-11);
      }
    }
  }
}

TEST_CASE("derivatives of a batch are those of point after point, on any number of threads") {
  for (const Codebook& book : {four_pieces(), all_kinds(), golden_command()}) {
    const Eigen::Index d = book.coordinate_count(), outputs = book.output_count();
    const Eigen::MatrixXd points = random_points(book, 1200, 5);
    for (const int threads : {1, 3, 0}) {
      Query query(book);
      Eigen::MatrixXd values(outputs, points.cols()), gradients(outputs * d, points.cols());
      Eigen::MatrixXd again = values, slopes = gradients, hessians(outputs * d * d, points.cols());
      query.batch(points, values, gradients, threads);
      query.batch(points, again, slopes, hessians, threads);
      Eigen::VectorXd one(outputs);
      Eigen::MatrixXd gradient(outputs, d), hessian(outputs, d * d);
      for (Eigen::Index j = 0; j < points.cols(); j += 7) {
        query.values(point(points, j), one, gradient);
        REQUIRE((values.col(j).array() == one.array()).all());
        // On lists there are no derivatives: both are NaN.
        const Eigen::VectorXd expected = gradient.reshaped();
        for (Eigen::Index i = 0; i < expected.size(); ++i)
          REQUIRE(
              (gradients(i, j) == expected[i] || (std::isnan(gradients(i, j)) && std::isnan(expected[i]))));
        query.values(point(points, j), one, gradient, hessian);
        REQUIRE((again.col(j).array() == one.array()).all());
        const Eigen::VectorXd second = hessian.reshaped();
        for (Eigen::Index i = 0; i < second.size(); ++i)
          REQUIRE((hessians(i, j) == second[i] || (std::isnan(hessians(i, j)) && std::isnan(second[i]))));
      }
    }
  }
}

TEST_CASE("derivatives of a batch of trajectories are those of one after the other") {
  const Codebook book = four_pieces();
  const std::vector<double> times = {0.0, 0.05, 0.2, 0.31, 0.5};
  const Eigen::MatrixXd points = random_points(book, 1100, 6).bottomRows(book.coordinate_count() - 1);
  for (const int threads : {1, 3, 0}) {
    TrajectoryQuery query(book, times, std::vector<std::string>{"E", "x"});
    const Eigen::Index rows = query.time_count() * query.output_count(), d = query.parameter_count();
    Eigen::MatrixXd values(rows, points.cols()), derivatives(rows * d, points.cols());
    query.batch(points, values, derivatives, threads);
    Eigen::MatrixXd one(query.time_count(), query.output_count());
    Eigen::MatrixXd slopes(query.time_count(), query.output_count() * d);
    for (Eigen::Index j = 0; j < points.cols(); j += 7) {
      query.values(point(points, j), one, slopes);
      REQUIRE((values.col(j).array() == one.reshaped().array()).all());
      REQUIRE((derivatives.col(j).array() == slopes.reshaped().array()).all());
    }
    Eigen::MatrixXd short_of_rows(rows, points.cols());
    CHECK_THROWS_AS(query.batch(points, values, short_of_rows, threads), ArgumentError);
  }
}

TEST_CASE("a batch refuses what a single query refuses") {
  const Codebook book = four_pieces();
  Query query(book);
  Eigen::MatrixXd points = random_points(book, 20, 1), values(3, 20), narrow(3, 19);
  CHECK_THROWS_AS(query.batch(points, narrow), ArgumentError);
  CHECK_THROWS_AS(query.batch(points, values, -1), ArgumentError);
  points(1, 13) = 7.0;
  CHECK_THAT(error_text<OutsideBoxError>([&] { query.batch(points, values); }), Contains("C_D = 7"));
  CHECK_THAT(error_text<OutsideBoxError>([&] { query.batch(points, values, 2); }), Contains("C_D = 7"));
  points(1, 13) = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(query.batch(points, values), ArgumentError);
}

TEST_CASE("single floats change answers by their round-off, and are taken where a certificate bears it") {
  for (const Codebook& book : {four_pieces(), four_pieces_of_trains()}) {
    Query query(book, {.precision = Precision::single_precision});
    CHECK(query.precision() == Precision::single_precision);
    const Eigen::MatrixXd points = random_points(book, 300, 6);
    const Eigen::MatrixXd expected = answers(book, points).values;
    Eigen::MatrixXd values(3, 300);
    query.batch(points, values);
    // Sums of some tens of products, each rounded to 6e-8.
    CHECK((values - expected).cwiseAbs().maxCoeff() < 1e-5 * (1.0 + expected.cwiseAbs().maxCoeff()));
    CHECK(Query(book, {.precision = Precision::automatic}).precision() == Precision::double_precision);
    Certificate certificate = sample_certificate(book);
    for (const double error : {1e-2, 1e-9}) {
      for (OutputError& output : certificate.outputs) output.max_si = error;
      const Codebook certified = book.with_certificate(certificate);
      CHECK(Query(certified, {.precision = Precision::automatic}).precision() ==
            (error > 1e-5 ? Precision::single_precision : Precision::double_precision));
    }
  }
}

TEST_CASE("of a codebook over time alone, too, single floats are taken where its certificate bears it") {
  using samara::pgd::Axis;
  const Axis time = Axis::radau({"t", "s", samara::pgd::AxisRole::time}, 0.0, 1.0, 3, 2);
  const Codebook book(
      sample_model(),
      {Piece{{samara::pgd::SeparatedField({time}, {{"x", "m"}}, {Eigen::MatrixXd::Random(7, 2)},
                                          Eigen::MatrixXd::Random(1, 2))}}});
  Certificate certificate = sample_certificate(book);
  for (const double error : {1e-2, 1e-9}) {
    for (OutputError& output : certificate.outputs) output.max_si = error;
    const Codebook certified = book.with_certificate(certificate);
    const Precision expected = error > 1e-5 ? Precision::single_precision : Precision::double_precision;
    CHECK(Query(certified, {.precision = Precision::automatic}).precision() == expected);
  }
}

TEST_CASE("residuals and their Jacobian are values and derivatives, scaled, row by row") {
  const Codebook book = four_pieces_of_trains();
  const std::vector<double> times = {0.1, 0.3, 0.5};
  TrajectoryQuery query(book, times, {"v", "x"});
  const std::array q = {0.8, 0.1};
  Eigen::MatrixXd values(3, 2), slopes(3, 4);
  query.values(q, values, slopes);
  const std::vector<double> observed = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
                            scales = {1.0, 2.0, 3.0, 4.0, 5.0, 6.0};
  std::vector<double> residuals(6), jacobian(12);
  query.residuals(q, observed, scales, residuals, jacobian);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto time = static_cast<Eigen::Index>(i % 3), output = static_cast<Eigen::Index>(i / 3);
    CHECK(residuals[i] == Approx((values(time, output) - observed[i]) / scales[i]).epsilon(1e-13));
    for (std::size_t k = 0; k < 2; ++k)
      CHECK(jacobian[2 * i + k] ==
            Approx(slopes(time, output + 2 * static_cast<Eigen::Index>(k)) / scales[i]).epsilon(1e-12));
  }
  std::vector<double> alone(6);
  query.residuals(q, observed, scales, alone);
  for (std::size_t i = 0; i < 6; ++i) CHECK(alone[i] == Approx(residuals[i]).epsilon(1e-12));
  CHECK_THROWS_AS(query.residuals(q, observed, scales, alone, std::span(jacobian).first(5)), ArgumentError);
}

TEST_CASE("copies of a query answer side by side") {
  const Codebook book = four_pieces_of_trains();
  const Query query(book);
  const Eigen::MatrixXd points = random_points(book, 500, 3);
  const Eigen::MatrixXd expected = answers(book, points).values;
  std::vector<Eigen::MatrixXd> found(4, Eigen::MatrixXd(3, 500));
  std::vector<std::thread> threads;
  for (Eigen::MatrixXd& mine : found) {
    threads.emplace_back([&] {
      Query own = query;
      Eigen::VectorXd values(3);
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        own.values(point(points, j), values);
        mine.col(j) = values;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  for (const Eigen::MatrixXd& mine : found) CHECK((mine - expected).cwiseAbs().maxCoeff() < 1e-12);
}

namespace {

/// Eight slabs of trains of random numbers: more than is read at once.
Codebook large_book() {
  std::vector<Piece> pieces;
  for (int k = 0; k < 8; ++k)
    pieces.push_back(
        random_train_piece({0.1 * k, 0.1 * (k + 1), 0.5, 1.0}, 20u + static_cast<unsigned>(k), 60));
  return Codebook(sample_model(), std::move(pieces));
}

}  // namespace

TEST_CASE("a large file is read as far as it is asked") {
  const TemporaryDirectory directory;
  const Codebook book = large_book();
  save(book, directory / "large.h5");
  REQUIRE(std::filesystem::file_size(directory / "large.h5") > (1u << 20));
  const Codebook read = load(directory / "large.h5");
  const auto is_read = [&] {
    return std::ranges::count_if(read.pieces(), [](const Piece& piece) { return piece.is_read(); });
  };
  CHECK(is_read() == 0);
  for (std::size_t p = 0; p < book.pieces().size(); ++p) {
    const PieceOutline outline = read.pieces()[p].outline(), expected = book.pieces()[p].outline();
    REQUIRE(outline.axes.size() == expected.axes.size());
    for (std::size_t k = 0; k < expected.axes.size(); ++k)
      CHECK(outline.axes[k].nodes() == expected.axes[k].nodes());
    REQUIRE(outline.groups.size() == expected.groups.size());
    for (std::size_t g = 0; g < expected.groups.size(); ++g) {
      CHECK(outline.groups[g].ranks == expected.groups[g].ranks);
      CHECK(outline.groups[g].entries == expected.groups[g].entries);
      CHECK(outline.groups[g].is_train == expected.groups[g].is_train);
    }
  }
  CHECK(is_read() == 0);
  Query query(read), original(book);
  Eigen::VectorXd values(3), expected(3);
  const std::array late = {0.75, 0.7, 0.1};
  query.values(late, values);
  original.values(late, expected);
  CHECK(values == expected);
  CHECK(is_read() == 1);
  // Several threads may be the first to ask.
  std::vector<std::thread> threads;
  std::atomic<int> same = 0;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&] {
      Query own = query;
      Eigen::VectorXd mine(3);
      own.values(std::array{0.35, 0.7, 0.1}, mine);
      Query other(book);
      Eigen::VectorXd theirs(3);
      other.values(std::array{0.35, 0.7, 0.1}, theirs);
      same += mine == theirs ? 1 : 0;
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(same == 4);
  CHECK(is_read() == 2);
  save(read, directory / "again.h5");
  CHECK(content(directory / "again.h5") == content(directory / "large.h5"));
}

TEST_CASE("damage in a part of a large file that was not read is found when it is") {
  const TemporaryDirectory directory;
  save(large_book(), directory / "large.h5");
  std::string bytes = content(directory / "large.h5");
  for (std::size_t at = bytes.size() * 9 / 10; at < bytes.size() * 19 / 20; at += 997)
    bytes[at] = static_cast<char>(bytes[at] ^ 0x5a);
  put_content(directory / "large.h5", bytes);
  const Codebook book = load(directory / "large.h5");
  Query query(book);
  Eigen::VectorXd values(3);
  int refused = 0;
  for (int k = 0; k < 8; ++k) {
    const std::array x = {0.1 * k + 0.05, 0.7, 0.1};
    const std::string error = error_text<InputError>([&] { query.values(x, values); });
    if (error == "no exception") continue;
    CHECK_THAT(error, Contains("large.h5") && Contains("/pieces/"));
    ++refused;
  }
  CHECK(refused > 0);
  CHECK(refused < 8);
}
