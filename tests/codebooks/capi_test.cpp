#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/codebooks/capi/samara.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "sample_books.h"

using Catch::Matchers::Contains;

namespace {

struct Close {
  void operator()(samara_codebook* book) const { samara_close(book); }
  void operator()(samara_query* query) const { samara_query_close(query); }
};
using Book = std::unique_ptr<samara_codebook, Close>;
using Asked = std::unique_ptr<samara_query, Close>;

/// A codebook of exact values: v = v(0) + C_D t, x = v(0) t + C_D t^2 / 2; t in [0, 3], C_D in [-1, 2], v(0)
/// in [0, 1].
struct Opened {
  TemporaryDirectory directory;
  Book book;
  Asked query;
  Opened() {
    const std::string path = (directory / "book.h5").string();
    samara::codebooks::save(golden_book(), path);
    book.reset(samara_open(path.c_str()));
    REQUIRE(book);
    query.reset(samara_query_open(book.get()));
    REQUIRE(query);
  }
};

}  // namespace

TEST_CASE("the interface in C tells what a codebook holds") {
  const Opened opened;
  const samara_codebook* const book = opened.book.get();
  REQUIRE(samara_coordinate_count(book) == 3);
  REQUIRE(samara_output_count(book) == 2);
  CHECK(samara_coordinate_name(book, 0) == std::string("t"));
  CHECK(samara_coordinate_unit(book, 0) == std::string("s"));
  CHECK(samara_coordinate_name(book, 2) == std::string("v(0)"));
  CHECK(samara_output_name(book, 1) != nullptr);
  CHECK(samara_output_unit(book, 1) != nullptr);
  double lower = 0.0, upper = 0.0;
  REQUIRE(samara_bounds(book, 1, &lower, &upper) == SAMARA_DONE);
  CHECK(lower == -1.0);
  CHECK(upper == 2.0);
  CHECK(samara_is_certified(book) == (golden_book().certificate()->met ? 1 : 0));
}

TEST_CASE("answers through the interface in C are those of a query") {
  const Opened opened;
  const samara::codebooks::Codebook same = golden_book();
  samara::codebooks::Query query(same);
  const std::vector<double> points = {0.3, 1.5, 0.25, 2.7, -0.5, 1.0, 2.0, 2.0, 0.0};
  std::vector<double> all(6);
  REQUIRE(samara_batch(opened.query.get(), 3, points.data(), all.data(), 2) == SAMARA_DONE);
  for (std::size_t p = 0; p < 3; ++p) {
    const double* const x = points.data() + 3 * p;
    Eigen::VectorXd values(2);
    Eigen::MatrixXd gradient(2, 3);
    query.values({x, 3}, values, gradient);
    double answer[2], again[2], slopes[6];
    REQUIRE(samara_values(opened.query.get(), x, answer) == SAMARA_DONE);
    REQUIRE(samara_gradient(opened.query.get(), x, again, slopes) == SAMARA_DONE);
    for (int o = 0; o < 2; ++o) {
      // Sums of a few terms of the order of ten, in another order.
      CHECK(answer[o] == Approx(values[o]).margin(1e-13));
      CHECK(again[o] == Approx(values[o]).margin(1e-13));
      CHECK(all[2 * p + static_cast<std::size_t>(o)] == Approx(values[o]).margin(1e-13));
      for (int k = 0; k < 3; ++k) CHECK(slopes[3 * o + k] == Approx(gradient(o, k)).margin(1e-12));
    }
  }
  CHECK(samara_batch(opened.query.get(), 0, nullptr, nullptr, 1) == SAMARA_DONE);
}

TEST_CASE("what goes wrong behind the interface in C is a status and a sentence, never an exception") {
  const Opened opened;
  samara_query* const query = opened.query.get();
  double values[2] = {}, gradient[6] = {};
  const double outside[] = {0.3, 2.5, 0.25};
  CHECK(samara_values(query, outside, values) == SAMARA_OUTSIDE);
  CHECK_THAT(samara_error(), Contains("C_D") && Contains("2.5"));
  const double not_finite[] = {0.3, std::numeric_limits<double>::quiet_NaN(), 0.25};
  CHECK(samara_gradient(query, not_finite, values, gradient) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("nan"));
  const double inside[] = {0.3, 1.5, 0.25};
  CHECK(samara_batch(query, 1, inside, values, -1) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("-1 threads"));
  CHECK(samara_batch(query, std::numeric_limits<std::size_t>::max() / 4, inside, values, 1) ==
        SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("points"));
  // A call that succeeds leaves the sentence.
  CHECK(samara_values(query, inside, values) == SAMARA_DONE);
  CHECK_THAT(samara_error(), Contains("points"));
}

TEST_CASE("null arguments of the interface in C are refused by name, or let pass where that is promised") {
  const Opened opened;
  samara_query* const query = opened.query.get();
  const double x[] = {0.3, 1.5, 0.25};
  double values[2] = {}, gradient[6] = {}, bound = 0.0;
  CHECK(samara_open(nullptr) == nullptr);
  CHECK_THAT(samara_error(), Contains("samara_open"));
  CHECK(samara_query_open(nullptr) == nullptr);
  CHECK_THAT(samara_error(), Contains("samara_query_open"));
  CHECK(samara_values(nullptr, x, values) == SAMARA_WRONG_CALL);
  CHECK(samara_values(query, nullptr, values) == SAMARA_WRONG_CALL);
  CHECK(samara_values(query, x, nullptr) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("samara_values"));
  CHECK(samara_gradient(nullptr, x, values, gradient) == SAMARA_WRONG_CALL);
  CHECK(samara_gradient(query, nullptr, values, gradient) == SAMARA_WRONG_CALL);
  CHECK(samara_gradient(query, x, nullptr, gradient) == SAMARA_WRONG_CALL);
  CHECK(samara_gradient(query, x, values, nullptr) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("samara_gradient"));
  CHECK(samara_batch(nullptr, 1, x, values, 1) == SAMARA_WRONG_CALL);
  CHECK(samara_batch(query, 1, nullptr, values, 1) == SAMARA_WRONG_CALL);
  CHECK(samara_batch(query, 1, x, nullptr, 1) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("samara_batch"));
  CHECK(samara_bounds(nullptr, 0, &bound, &bound) == SAMARA_WRONG_CALL);
  CHECK(samara_bounds(opened.book.get(), 3, &bound, &bound) == SAMARA_WRONG_CALL);
  CHECK(samara_bounds(opened.book.get(), 0, nullptr, &bound) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("samara_bounds"));
  for (const int k : {-1, 3}) {
    CHECK(samara_coordinate_name(opened.book.get(), k) == nullptr);
    CHECK_THAT(samara_error(), Contains("a coordinate that it does not have"));
    CHECK(samara_coordinate_unit(opened.book.get(), k) == nullptr);
    CHECK(samara_output_name(opened.book.get(), k) == nullptr);
    CHECK_THAT(samara_error(), Contains("an output that it does not have"));
    CHECK(samara_output_unit(opened.book.get(), k) == nullptr);
  }
  CHECK(samara_coordinate_count(nullptr) == 0);
  CHECK(samara_output_count(nullptr) == 0);
  CHECK(samara_is_certified(nullptr) == 0);
  samara_close(nullptr);
  samara_query_close(nullptr);
}

TEST_CASE("the interface in C refuses files that are none, by their names") {
  const TemporaryDirectory directory;
  const std::string path = (directory / "none.h5").string();
  CHECK(samara_open(path.c_str()) == nullptr);
  CHECK_THAT(samara_error(), Contains("none.h5"));
  put_content(path, "not a codebook");
  CHECK(samara_open(path.c_str()) == nullptr);
  CHECK_THAT(samara_error(), Contains("none.h5") && Contains("not an HDF5 file"));
}

TEST_CASE("every thread has its own sentence, and a book is shared by queries of several threads") {
  const Opened opened;
  const double outside[] = {9.0, 1.5, 0.25}, inside[] = {0.3, 1.5, 0.25};
  double values[2] = {};
  CHECK(samara_values(opened.query.get(), outside, values) == SAMARA_OUTSIDE);
  std::string before, after;
  double answer[2] = {};
  std::thread([&] {
    before = samara_error();
    const Asked own(samara_query_open(opened.book.get()));
    samara_values(own.get(), inside, answer);
    samara_open("/no/such/book.h5");
    after = samara_error();
  }).join();
  CHECK(before.empty());
  CHECK_THAT(after, Contains("/no/such/book.h5"));
  CHECK_THAT(samara_error(), Contains("t = 9"));
  CHECK(samara_values(opened.query.get(), inside, values) == SAMARA_DONE);
  CHECK(answer[0] == values[0]);
  CHECK(answer[1] == values[1]);
}
