#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/capi/samara.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/codebooks/query/derived_query.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "samara/io/text_file.h"
#include "sample_books.h"

using Catch::Matchers::Contains;

namespace {

struct Close {
  void operator()(samara_codebook* book) const { samara_close(book); }
  void operator()(samara_query* query) const { samara_query_close(query); }
  void operator()(samara_trajectory* trajectory) const { samara_trajectory_close(trajectory); }
};
using Book = std::unique_ptr<samara_codebook, Close>;
using Asked = std::unique_ptr<samara_query, Close>;
using Frames = std::unique_ptr<samara_trajectory, Close>;

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

TEST_CASE("the interface in C names its versions, roles, and what the plan fixed") {
  CHECK_THAT(samara_version(), Catch::Matchers::Matches("[0-9]+\\.[0-9]+\\.[0-9]+"));
  CHECK_THAT(samara_format_version(), Catch::Matchers::Matches("[0-9]+\\.[0-9]+"));
  const Opened opened;
  const samara_codebook* const book = opened.book.get();
  const samara::codebooks::Codebook same = golden_book();
  CHECK(samara_coordinate_role(book, 0) == std::string("time"));
  CHECK(samara_coordinate_role(book, 2) == std::string("initial"));
  CHECK(samara_coordinate_role(book, 3) == nullptr);
  CHECK(samara_model(book) == same.model().name);
  CHECK(samara_model(nullptr) == nullptr);
  REQUIRE(samara_fixed_count(book) == std::ssize(same.model().fixed));
  int place = 0;
  for (const auto& [name, value] : same.model().fixed) {
    double answer = 0.0;
    CHECK(samara_fixed_name(book, place) == name);
    CHECK(samara_fixed_unit(book, place) == same.model().fixed_units.at(name));
    REQUIRE(samara_fixed_value(book, place++, &answer) == SAMARA_DONE);
    CHECK(answer == value);
  }
  CHECK(samara_fixed_name(book, place) == nullptr);
  CHECK(samara_fixed_value(book, -1, nullptr) == SAMARA_WRONG_CALL);
}

TEST_CASE("the interface in C hands out the numbers of a certificate, and says where there is none") {
  const Opened opened;
  const samara::codebooks::Certificate wanted = *golden_book().certificate();
  samara_certificate certificate;
  REQUIRE(samara_certificate_of(opened.book.get(), &certificate) == SAMARA_DONE);
  CHECK(certificate.met == (wanted.met ? 1 : 0));
  CHECK(certificate.points == wanted.points);
  CHECK(certificate.times == wanted.times);
  CHECK(certificate.tolerance == wanted.tolerance);
  CHECK(certificate.max_error == wanted.max_error);
  CHECK(certificate.wrong_points == wanted.wrong_points.value_or(-1));
  samara_output_error error;
  REQUIRE(samara_output_error_of(opened.book.get(), 1, &error) == SAMARA_DONE);
  CHECK(error.range == wanted.outputs[1].range);
  CHECK(error.max_si == wanted.outputs[1].max_si);
  CHECK(error.rms == wanted.outputs[1].rms);
  CHECK(samara_output_error_of(opened.book.get(), 2, &error) == SAMARA_WRONG_CALL);
  const TemporaryDirectory directory;
  const std::string path = (directory / "book.h5").string();
  samara::codebooks::save(four_pieces(), path);
  const Book without(samara_open(path.c_str()));
  CHECK(samara_certificate_of(without.get(), &certificate) == SAMARA_WRONG_CALL);
  CHECK_THAT(samara_error(), Contains("no certificate"));
  CHECK(samara_output_error_of(without.get(), 0, &error) == SAMARA_WRONG_CALL);
  CHECK(samara_certificate_of(nullptr, &certificate) == SAMARA_WRONG_CALL);
}

TEST_CASE("a codebook opens from memory as from its file, and answers after the bytes are gone") {
  const Opened opened;
  std::string bytes = samara::io::read_text_file(opened.directory / "book.h5");
  const Book book(samara_open_memory(bytes.data(), bytes.size()));
  REQUIRE(book);
  std::string().swap(bytes);
  const Asked query(samara_query_open(book.get()));
  const double x[] = {0.3, 1.5, 0.25};
  double answer[2] = {}, again[2] = {};
  REQUIRE(samara_values(query.get(), x, answer) == SAMARA_DONE);
  REQUIRE(samara_values(opened.query.get(), x, again) == SAMARA_DONE);
  CHECK(answer[0] == again[0]);
  CHECK(answer[1] == again[1]);
  CHECK(samara_open_memory("no codebook", 11) == nullptr);
  CHECK_THAT(samara_error(), Contains("bytes in memory: is not an HDF5 file but a text"));
  CHECK(samara_open_memory("", 0) == nullptr);
  CHECK(samara_open_memory(nullptr, 5) == nullptr);
}

TEST_CASE("options of the interface in C choose outputs, hold coordinates and set the precision") {
  const Opened opened;
  const char* const outputs[] = {"x"};
  const char* const held[] = {"C_D"};
  const double at[] = {1.5};
  samara_options options = {};
  options.outputs = outputs;
  options.output_count = 1;
  options.held = held;
  options.held_at = at;
  options.held_count = 1;
  options.precision = SAMARA_SINGLE;
  const Asked query(samara_query_open_with(opened.book.get(), &options));
  REQUIRE(query);
  REQUIRE(samara_query_coordinate_count(query.get()) == 2);
  REQUIRE(samara_query_output_count(query.get()) == 1);
  CHECK(samara_query_coordinate_name(query.get(), 1) == std::string("v(0)"));
  CHECK(samara_query_output_name(query.get(), 0) == std::string("x"));
  CHECK(samara_query_output_unit(query.get(), 0) == std::string("m"));
  CHECK(samara_query_output_name(query.get(), 1) == nullptr);
  CHECK(samara_query_precision(query.get()) == SAMARA_SINGLE);
  CHECK(samara_query_precision(opened.query.get()) == SAMARA_DOUBLE);
  const double point[] = {2.0, 0.5};
  double x = 0.0, slopes[2] = {};
  REQUIRE(samara_gradient(query.get(), point, &x, slopes) == SAMARA_DONE);
  // x = v(0) t + C_D t^2 / 2, in factors of single floats.
  CHECK(x == Approx(0.5 * 2.0 + 1.5 * 2.0).epsilon(1e-5));
  CHECK(slopes[0] == Approx(0.5 + 1.5 * 2.0).epsilon(1e-5));
  CHECK(slopes[1] == Approx(2.0).epsilon(1e-5));
  const auto refused = [&](const char* sentence) {
    CHECK(samara_query_open_with(opened.book.get(), &options) == nullptr);
    CHECK_THAT(samara_error(), Contains(sentence));
  };
  options.precision = static_cast<samara_precision>(3);
  refused("precision 3");
  options.precision = SAMARA_DOUBLE;
  const double outside[] = {9.0};
  options.held_at = outside;
  refused("C_D");
  options.held_at = nullptr;
  refused("without a value");
  options.held_at = at;
  const char* const unknown[] = {"z"};
  options.outputs = unknown;
  refused("\"z\"");
  options.outputs = nullptr;
  refused("output number 0 has no name");
  options.output_count = -1;
  refused("negative");
}

TEST_CASE("batches with derivatives through the interface in C are those of single points, on any threads") {
  const Opened opened;
  const Eigen::MatrixXd points = random_points(golden_book(), 500, 2);
  std::vector<double> values(1000), gradients(3000), single(2), slopes(6);
  for (const int threads : {1, 2, 0}) {
    REQUIRE(samara_batch_gradient(opened.query.get(), 500, points.data(), values.data(), gradients.data(),
                                  threads) == SAMARA_DONE);
    for (std::size_t j = 0; j < 500; ++j) {
      REQUIRE(samara_gradient(opened.query.get(), points.data() + 3 * j, single.data(), slopes.data()) ==
              SAMARA_DONE);
      CHECK(std::equal(single.begin(), single.end(), values.begin() + static_cast<std::ptrdiff_t>(2 * j)));
      CHECK(std::equal(slopes.begin(), slopes.end(), gradients.begin() + static_cast<std::ptrdiff_t>(6 * j)));
    }
  }
  CHECK(samara_batch_gradient(opened.query.get(), 0, nullptr, nullptr, nullptr, 1) == SAMARA_DONE);
  CHECK(samara_batch_gradient(opened.query.get(), 1, points.data(), values.data(), nullptr, 1) ==
        SAMARA_WRONG_CALL);
  CHECK(samara_batch_gradient(opened.query.get(), 5, points.data(), values.data(), gradients.data(), -1) ==
        SAMARA_WRONG_CALL);
}

TEST_CASE("trajectories through the interface in C are those of a query of trajectories") {
  const Opened opened;
  const double times[] = {0.0, 0.7, 2.0, 2.9};
  const Frames frames(samara_trajectory_open(opened.book.get(), 4, times, nullptr));
  REQUIRE(frames);
  REQUIRE(samara_trajectory_parameter_count(frames.get()) == 2);
  REQUIRE(samara_trajectory_output_count(frames.get()) == 2);
  REQUIRE(samara_trajectory_time_count(frames.get()) == 4);
  const samara::codebooks::Codebook same = golden_book();
  samara::codebooks::TrajectoryQuery wanted(same, {0.0, 0.7, 2.0, 2.9});
  const double points[] = {1.5, 0.25, -0.5, 1.0};
  std::vector<double> values(8), slopes(16), all(16), all_slopes(32);
  REQUIRE(samara_trajectory_batch(frames.get(), 2, points, all.data(), all_slopes.data(), 2) == SAMARA_DONE);
  for (std::size_t j = 0; j < 2; ++j) {
    Eigen::MatrixXd answer(4, 2), derivatives(4, 4);
    wanted.values({points + 2 * j, 2}, answer, derivatives);
    REQUIRE(samara_trajectory_values(frames.get(), points + 2 * j, values.data(), slopes.data()) ==
            SAMARA_DONE);
    for (std::size_t i = 0; i < 8; ++i) {
      CHECK(values[i] == answer.data()[i]);
      CHECK(all[8 * j + i] == Approx(answer.data()[i]).margin(1e-13));
    }
    for (std::size_t i = 0; i < 16; ++i) {
      CHECK(slopes[i] == derivatives.data()[i]);
      CHECK(all_slopes[16 * j + i] == derivatives.data()[i]);
    }
    REQUIRE(samara_trajectory_values(frames.get(), points + 2 * j, values.data(), nullptr) == SAMARA_DONE);
    CHECK(values[5] == Approx(answer.data()[5]).margin(1e-13));
  }
  const double outside[] = {5.0, 0.25};
  CHECK(samara_trajectory_values(frames.get(), outside, values.data(), nullptr) == SAMARA_OUTSIDE);
  CHECK(samara_trajectory_values(frames.get(), nullptr, values.data(), nullptr) == SAMARA_WRONG_CALL);
  CHECK(samara_trajectory_batch(frames.get(), 0, nullptr, nullptr, nullptr, 1) == SAMARA_DONE);
  const double late[] = {4.0};
  CHECK(samara_trajectory_open(opened.book.get(), 1, late, nullptr) == nullptr);
  CHECK_THAT(samara_error(), Contains("t = 4"));
  CHECK(samara_trajectory_open(opened.book.get(), 1, nullptr, nullptr) == nullptr);
  samara_trajectory_close(nullptr);
}

TEST_CASE("what a model derives is asked for through the interface in C as what is stored") {
  const std::string plan = R"([equations]
name = "decay"
states.v = { initial = 2 }
parameters.rate = { unit = "1/s", above = 0 }
rates.v = "-rate*v"
outputs.square = "v^2"
[box]
rate = [0.5, 1.5]
[time]
end = 2
[tolerance]
relative = 1e-6
)";
  samara::codebooks::BuildOptions few;
  few.certificate_points = 50;
  const TemporaryDirectory directory;
  const std::string path = (directory / "decay.h5").string();
  const auto built = samara::codebooks::build(samara::codebooks::parse_plan(plan, "decay.toml"), few).book;
  samara::codebooks::save(built, path);
  const Book book(samara_open(path.c_str()));
  REQUIRE(samara_derived_count(book.get()) == 1);
  CHECK(samara_derived_name(book.get(), 0) == std::string("square"));
  CHECK(samara_derived_unit(book.get(), 0) == std::string("1"));
  CHECK(samara_derived_name(book.get(), 1) == nullptr);
  const char* const names[] = {"square", "v"};
  samara_options options = {};
  options.outputs = names;
  options.output_count = 2;
  const Asked query(samara_query_open_with(book.get(), &options));
  REQUIRE(query);
  const double points[] = {0.4, 1.2, 1.1, 0.7};
  double values[4], gradients[8], single[2], slopes[4];
  REQUIRE(samara_batch_gradient(query.get(), 2, points, values, gradients, 2) == SAMARA_DONE);
  for (int j = 0; j < 2; ++j) {
    // v = 2 exp(-rate t), to the tolerance of the plan.
    const double t = points[2 * j], rate = points[2 * j + 1], v = 2.0 * std::exp(-rate * t);
    REQUIRE(samara_gradient(query.get(), points + 2 * j, single, slopes) == SAMARA_DONE);
    CHECK(single[0] == Approx(v * v).epsilon(1e-5));
    CHECK(single[1] == Approx(v).epsilon(1e-5));
    CHECK(slopes[1] == Approx(-2.0 * t * v * v).epsilon(1e-4));
    for (int i = 0; i < 2; ++i) CHECK(values[2 * j + i] == single[i]);
    for (int i = 0; i < 4; ++i) CHECK(gradients[4 * j + i] == slopes[i]);
  }
  const double times[] = {0.0, 0.4};
  const Frames frames(samara_trajectory_open(book.get(), 2, times, &options));
  REQUIRE(frames);
  const double rate[] = {1.2};
  double path_values[4], path_slopes[4];
  REQUIRE(samara_trajectory_batch(frames.get(), 1, rate, path_values, path_slopes, 1) == SAMARA_DONE);
  CHECK(path_values[1] == Approx(values[0]).epsilon(1e-13));  // the square at 0.4 s
  CHECK(path_values[3] == Approx(values[1]).epsilon(1e-13));
  CHECK(path_slopes[1] == Approx(gradients[1]).epsilon(1e-13));
  const double late[] = {3.0};
  CHECK(samara_trajectory_open(book.get(), 1, late, &options) == nullptr);
}
