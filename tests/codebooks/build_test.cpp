#include "samara/codebooks/build.h"

#include <cmath>
#include <filesystem>
#include <vector>

#include <catch2/catch.hpp>
#include <unistd.h>

#include "coin_book.h"
#include "samara/base/errors.h"
#include "samara/codebooks/certify.h"
#include "samara/codebooks/query.h"
#include "samara/models/integrate.h"
#include "samara/pgd/random.h"

using namespace samara;
using Catch::Matchers::Contains;
using codebooks::build;
using codebooks::BuildResult;
using codebooks::parse_plan;

namespace {

/// Largest error over range of every output, on points of the test's own.
double independent_error(const codebooks::Codebook& book, std::uint64_t seed, int points) {
  const models::ParametricModel model = codebooks::model_of(book);
  codebooks::Query query(book);
  pgd::Random random(seed);
  Eigen::VectorXd values(book.output_count());
  double error = 0.0;
  for (int i = 0; i < points; ++i) {
    std::vector<double> x;
    for (const auto& c : book.coordinates()) x.push_back(c.lower + random.uniform() * (c.upper - c.lower));
    query.values(x, values);
    const auto exact = models::integrate(model, std::span(x).subspan(1), std::span(x).first(1));
    for (int o = 0; o < book.output_count(); ++o) {
      const double range = book.certificate()->outputs[static_cast<std::size_t>(o)].range;
      error = std::max(error, std::abs(values[o] - exact.states(0, o)) / range);
    }
  }
  return error;
}

bool same_fields(const codebooks::Codebook& a, const codebooks::Codebook& b) {
  const auto& left = a.pieces().front().groups.front();
  const auto& right = b.pieces().front().groups.front();
  if (left.rank() != right.rank() || left.weights() != right.weights()) return false;
  for (std::size_t k = 0; k < left.factors().size(); ++k) {
    if (left.factors()[k] != right.factors()[k]) return false;
  }
  return a.certificate()->max_error == b.certificate()->max_error &&
         a.build().evaluations == b.build().evaluations;
}

}  // namespace

TEST_CASE("the codebook of (6.18) has one term and no error beyond round-off") {
  const BuildResult result =
      build(parse_plan("model = \"constant_rate\"\n[box]\nk = [1.0, 10.0]\n[time]\nend = "
                       "10.0\n[tolerance]\nrelative = 1e-10\n",
                       "p"));
  CHECK(result.met);
  CHECK(result.book.pieces().front().groups.front().rank() == 1);
  CHECK(result.book.certificate()->max_error < 1e-12);
}

TEST_CASE("the codebook of (6.20) is within 1e-8 of the exact solution between the nodes") {
  const BuildResult result =
      build(parse_plan("model = \"quadratic_drag_fall\"\n[box]\nC_D = [0.5, 2.0]\n[time]\nend = "
                       "1.0\n[tolerance]\nrelative = 1e-8\n",
                       "p"));
  CHECK(result.met);
  codebooks::Query query(result.book);
  pgd::Random random(4);
  Eigen::VectorXd u(1);
  for (int i = 0; i < 1000; ++i) {
    const std::vector<double> x = {random.uniform(), 0.5 + 1.5 * random.uniform()};
    query.values(x, u);
    const double terminal = std::sqrt(2 * 0.1 * 9.81 / (1.23 * x[1] * 0.5));
    // The range of u over the box is 2.5 m/s.
    REQUIRE(u[0] == Approx(-terminal * std::tanh(9.81 * x[0] / terminal)).margin(2.5e-8).epsilon(0));
  }
}

TEST_CASE("a certificate agrees with an independent comparison") {
  const codebooks::Codebook& book = test::coin_build().book;
  CHECK(test::coin_build().met);
  CHECK(book.certificate()->points >= 2000);
  const double error = independent_error(book, 99, 300);
  CHECK(error <= 1.2 * book.certificate()->max_error);
  CHECK(error >= 0.05 * book.certificate()->max_error);
}

TEST_CASE("the body's own properties may be free, also with the added mass that follows from them") {
  for (const char* box :
       {"C_D = [1.0, 1.3]\narea = [4.5e-4, 5e-4]\n", "density = [6000, 7000]\nthickness = [2.4e-3, 2.7e-3]\n",
        "m_a = [4e-3, 5e-3]\nC_D = [1.0, 1.3]\n"}) {
    std::string fixed = "\"v(0)\" = 0.1\n";
    const std::string free = box;
    if (free.find("area") == std::string::npos) fixed += "area = 4.7e-4\n";
    if (free.find("density") == std::string::npos) fixed += "density = 6300\n";
    if (free.find("thickness") == std::string::npos) fixed += "thickness = 2.5e-3\n";
    if (free.find("C_D") == std::string::npos) fixed += "C_D = 1.1\n";
    const BuildResult result =
        build(parse_plan("model = \"vertical_fall\"\n[fixed]\n" + fixed + "[box]\n" + free +
                             "[time]\nend = 0.4\n[tolerance]\nrelative = 1e-3\n",
                         "p"));
    CAPTURE(free, result.message);
    CHECK(result.met);
    CHECK(independent_error(result.book, 5, 100) < 1e-3);
  }
}

TEST_CASE("a body lighter than the fluid rises, and the codebook knows") {
  const BuildResult result = build(parse_plan(
      "model = \"vertical_fall\"\n[fixed]\narea = 4.7e-4\nthickness = 2.5e-3\ndensity = 500\n"
      "[box]\nC_D = [0.8, 1.6]\n\"v(0)\" = [-0.1, 0.2]\n[time]\nend = 0.4\n[tolerance]\nrelative = 1e-3\n",
      "p"));
  CHECK(result.met);
  codebooks::Query query(result.book);
  Eigen::VectorXd values(2);
  query.values(std::vector<double>{0.4, 1.0, 0.0}, values);
  CHECK(values[0] < 0.0);
  CHECK(values[1] < 0.0);
}

TEST_CASE("a build that cannot meet its tolerance is marked and still answers") {
  std::string text = test::coin_plan();
  text.replace(text.find("C_D = [0.8, 1.6]"), 16, "C_D = { range = [0.8, 1.6], nodes = 2 }");
  const BuildResult result = build(parse_plan(text, "p"));
  CHECK_FALSE(result.met);
  CHECK_FALSE(result.book.certificate()->met);
  CHECK_THAT(result.message, Contains("missed its tolerance"));
  CHECK(result.book.certificate()->max_error > 1e-3);
  Eigen::VectorXd values(2);
  codebooks::Query(result.book).values(std::vector<double>{0.2, 1.0, 0.0}, values);
  CHECK(std::isfinite(values[0]));
}

TEST_CASE("the number of calls is limited when the plan says so") {
  const BuildResult result = build(parse_plan(test::coin_plan() + "[builder]\nmax_calls = 100\n", "p"));
  CHECK(result.book.build().status == "max_calls");
  CHECK_FALSE(result.met);
}

TEST_CASE("the number of threads does not change the codebook") {
  const BuildResult one = build(parse_plan(test::coin_plan() + "[builder]\nthreads = 1\n", "p"));
  const BuildResult two = build(parse_plan(test::coin_plan() + "[builder]\nthreads = 2\n", "p"));
  CHECK(same_fields(one.book, two.book));
}

TEST_CASE("a build interrupted after any round resumes to the same codebook") {
  const auto checkpoint =
      std::filesystem::temp_directory_path() / ("samara_resume_" + std::to_string(getpid()));
  const codebooks::Plan plan = parse_plan(test::coin_plan(), "p");
  struct Killed {};
  // The callback dies as a killed process would, as soon as the checkpoint of a round is there.
  codebooks::BuildOptions killed;
  killed.checkpoint = checkpoint;
  killed.progress = [&](const Progress&) -> bool {
    if (std::filesystem::exists(checkpoint)) throw Killed{};
    return true;
  };
  CHECK_THROWS_AS(build(plan, killed), Killed);
  REQUIRE(std::filesystem::exists(checkpoint));

  CHECK_THROWS_WITH(build(parse_plan(test::coin_plan() + "title = \"other\"\n", "p"),
                          {.checkpoint = checkpoint, .resume = true}),
                    Contains("title") || Contains("another plan"));
  const BuildResult resumed = build(plan, {.checkpoint = checkpoint, .resume = true});
  CHECK_FALSE(std::filesystem::exists(checkpoint));
  CHECK(same_fields(resumed.book, test::coin_build().book));
}
