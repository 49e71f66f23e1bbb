#include <cmath>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/certify/certify_plan.h"
#include "samara/codebooks/composition/flow_map.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"
#include "same_codebook.h"
#include "sample_books.h"

// Codebooks of programs, here one of awk: exp(-a b) and a + b, at times t: exp(-a t) and b t.

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinAbs;

namespace {

const std::string kTimeless = "{ printf \"%.17g %.17g\\n\", exp(-$1 * $2), $1 + $2 }";
const std::string kTimed =
    "{ s = \"\"; for (i = 3; i <= NF; ++i) s = s sprintf(\"%.17g %.17g \", exp(-$1 * $i), $2 * $i); print s "
    "}";

Plan plan_of(const std::string& program, const std::string& tail = "") {
  return parse_plan("[command]\nrun = ['awk', '''" + program + R"toml(''']
inputs = { a = "1/s", b = "m" }
outputs = { p = "1", q = "m" }
[box]
b = [0.5, 2.0]
a = [1.0, 3.0]
[tolerance]
relative = 1e-5
assurance = 0.95
)toml" + tail,
                    "p.toml");
}

const BuildResult& timeless() {
  static const BuildResult result = build(plan_of(kTimeless));
  return result;
}

}  // namespace

TEST_CASE("a plan of a command names its call, its inputs and outputs, and may have no time") {
  const Plan plan = plan_of(kTimeless);
  REQUIRE(plan.command);
  CHECK(plan.model.empty());
  CHECK(plan.end == 0.0);
  CHECK(plan.command->run == std::vector<std::string>{"awk", kTimeless});
  CHECK(plan.command->inputs[1].name == "b");
  CHECK(plan.command->outputs[1].unit == "m");
  CHECK(plan.command->timeout == 60.0);
  CHECK(plan.certificate_points() == 60);
  CHECK(plan.box[0].name == "b");
  CHECK_THAT(error_text<samara::ArgumentError>([&] { plan.parametric_model(); }), Contains("has no model"));
}

TEST_CASE("an output that is constant up to rounding is met, and counts by its size") {
  const BuildResult result =
      build(plan_of("{ printf \"%.17g %.17g\\n\", exp(-$1 * $2), 3.7 * ($1 + $2) / ($1 + $2) }"));
  INFO(result.message << "; " << result.book.build().message);
  CHECK(result.met);
  CHECK_THAT(result.book.certificate()->outputs[1].range, Catch::Matchers::WithinRel(3.7, 1e-12));
}

TEST_CASE("a command without time becomes a codebook without time, in the order of the box") {
  const BuildResult& result = timeless();
  INFO(result.message << "; " << result.book.build().message);
  REQUIRE(result.met);
  CHECK_FALSE(result.resumable);
  const Codebook& book = result.book;
  CHECK(book.is_of_command());
  CHECK_FALSE(book.has_time());
  CHECK(book.parameters().size() == 2);
  CHECK(book.coordinates()[0].name == "b");
  CHECK(book.certificate()->points == 60);
  CHECK(book.certificate()->times == 0);
  CHECK(book.certificate()->outputs[0].worst.size() == 2);
  Query query(book);
  Eigen::VectorXd values(2);
  Eigen::MatrixXd gradient(2, 2);
  const Eigen::MatrixXd points = random_points(book, 300, 4);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    const double b = points(0, j), a = points(1, j);
    query.values(point(points, j), values, gradient);
    // The tolerance times the ranges, 0.6 and 3.5; slopes of polynomials of degree about 8 are worse by some
    // tens.
    CHECK_THAT(values[0], WithinAbs(std::exp(-a * b), 1e-5));
    CHECK_THAT(values[1], WithinAbs(a + b, 4e-5));
    CHECK_THAT(gradient(0, 0), WithinAbs(-a * std::exp(-a * b), 1e-3));
    CHECK_THAT(gradient(1, 1), WithinAbs(1.0, 1e-3));
  }
}

TEST_CASE("a codebook of a command is stored and read to the last bit, with and without time") {
  const TemporaryDirectory directory;
  save(timeless().book, directory / "book.h5");
  check_same_codebook(load(directory / "book.h5"), timeless().book);
  const BuildResult timed = build(plan_of(kTimed, "[time]\nend = 2\n"));
  INFO(timed.message);
  REQUIRE(timed.met);
  CHECK(timed.book.has_time());
  CHECK(timed.book.certificate()->times > 10);
  save(timed.book, directory / "timed.h5");
  check_same_codebook(load(directory / "timed.h5"), timed.book);
  TrajectoryQuery query(timed.book, {0.0, 0.7, 2.0});
  Eigen::MatrixXd values(3, 2);
  query.values(std::vector{1.5, 2.0}, values);
  CHECK_THAT(values(1, 0), WithinAbs(std::exp(-1.4), 1e-5));
  CHECK_THAT(values(2, 1), WithinAbs(3.0, 4e-5));
}

TEST_CASE("a codebook of a command is certified again by the command of a plan, and by no other") {
  const Codebook& book = timeless().book;
  CertifyOptions options{.points = 150, .seed = 77, .tolerance = 1e-5};
  const Certificate same = certify(book, plan_of(kTimeless), options);
  CHECK(same.met);
  CHECK(same.points == 150);
  CHECK(same.max_error > 0.0);
  CHECK_THAT(same.integrator, Contains("the command of the plan: awk"));
  // p + 0.01 instead of p, whose range is nearly exp(-1/2) - exp(-6).
  const Certificate other =
      certify(book, plan_of("{ printf \"%.17g %.17g\\n\", exp(-$1 * $2) + 0.01, $1 + $2 }"), options);
  CHECK_FALSE(other.met);
  CHECK_THAT(other.outputs[0].max_si, WithinAbs(0.01, 1e-4));
  CHECK(other.outputs[1].max < 1e-5);
  const auto refused = [&](const Codebook& of, const Plan& plan) {
    return error_text<samara::ArgumentError>([&] { certify(of, plan, options); });
  };
  CHECK_THAT(refused(book, plan_of(kTimed, "[time]\nend = 2\n")), Contains("the plan has time"));
  CHECK_THAT(refused(coin_build().book, plan_of(kTimeless)),
             Contains("a solution of the model vertical_fall"));
  Plan fewer = plan_of(kTimeless);
  fewer.builder.max_calls = 100;
  CHECK_THAT(refused(book, fewer), Contains("150, more than the 100 calls"));
  options.points = 0;
  CHECK_THAT(refused(book, plan_of(kTimeless)), Contains("at least 1 was expected"));
}

TEST_CASE("what needs time or a model says that a codebook of a command lacks it") {
  const Codebook& book = timeless().book;
  CHECK_THAT(error_text<samara::ArgumentError>([&] { TrajectoryQuery(book, {0.0}); }),
             Contains("a query of trajectories needs time, which this codebook does not have"));
  CHECK_THAT(error_text<samara::ArgumentError>([&] { FlowMap{book}; }),
             Contains("sampled from a command (awk"));
  const Codebook timed = build(plan_of(kTimed, "[time]\nend = 1\n")).book;
  CHECK_THAT(error_text<samara::ArgumentError>([&] { FlowMap{timed}; }),
             Contains("which has no model to integrate"));
}

TEST_CASE("a command that is not called often enough ends with the status max_calls and what it has") {
  const BuildResult result = build(plan_of(kTimeless, "[builder]\nmax_calls = 150\n"));
  INFO(result.book.build().message);
  CHECK_FALSE(result.met);
  CHECK_FALSE(result.resumable);
  CHECK(result.book.build().status == samara::Termination::max_calls);
  CHECK(result.book.certificate()->failed_points == 0);
  CHECK_THAT(error_text<samara::NoResultError>([&] {
               Plan plan = plan_of(kTimeless);
               plan.builder.max_calls = 2;
               build(plan);
             }),
             Contains("ended before it had a result"));
}

TEST_CASE("a command that fails somewhere leaves what was found, marked, with the point, and its calls") {
  // Near a corner that only a finer grid comes to.
  const std::string program =
      "{ if ($1 > 2.9 && $2 > 0.6 && $2 < 0.7) exit 3; printf \"%.17g %.17g\\n\", exp(-$1 * $2), $1 + $2 }";
  const TemporaryDirectory directory;
  BuildOptions options{.checkpoint = directory / "c"};
  const BuildResult result = build(plan_of(program), options);
  INFO(result.book.build().message);
  CHECK_FALSE(result.met);
  CHECK(result.resumable);
  CHECK(std::filesystem::exists(options.checkpoint));
  CHECK(result.book.build().status == samara::Termination::failed);
  CHECK_THAT(result.book.build().message, Contains("the function failed at b = 0.6") &&
                                              Contains("\"awk\" ended with the code 3") &&
                                              Contains("; the best"));
  CHECK(result.book.certificate()->failed_points == 60);
  CHECK_THAT(result.message, Contains("60 of 60 points have no answer"));
}
