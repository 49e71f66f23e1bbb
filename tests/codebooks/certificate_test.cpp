#include "samara/codebooks/book/certificate.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/certify/builder_end.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/pgd/tensors/random.h"

// What a certificate states: of how much of the box, at how many points, and where errors stand out.

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::WithinRel;

namespace {

std::string verdict_of(const Codebook& book) {
  return verdict(book.build(), *book.certificate());
}

Plan plan_of(const std::string& tail, int inputs = 2) {
  std::string names, box;
  for (int k = 0; k < inputs; ++k) {
    names += (k == 0 ? "x" : ", x") + std::to_string(k) + " = \"1\"";
    box += "x" + std::to_string(k) + " = [0, 1]\n";
  }
  return parse_plan("[command]\nrun = ['none']\ninputs = {" + names + "}\noutputs = { f = \"1\" }\n[box]\n" +
                        box + "[tolerance]\nrelative = 1e-2\n" + tail,
                    "p.toml");
}

samara::pgd::PointsFunction function_of(std::function<double(const Eigen::VectorXd&)> f) {
  return [f = std::move(f)](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < points.cols(); ++j) values(0, j) = f(points.col(j));
  };
}

double smooth(const Eigen::VectorXd& x) {
  return std::exp(-x.sum()) + x[0];
}

}  // namespace

TEST_CASE("the share of the box that may be worse is Clopper and Pearson's limit") {
  for (const int points : {10, 300, 2000, 100'000}) {
    // None wrong: (1 - share)^points = 0.05, nearly 3/points.
    CHECK_THAT(share_above(0, points), WithinRel(1.0 - std::pow(0.05, 1.0 / points), 1e-9));
    CHECK(share_above(0, points) <= 3.0 / points);
    CHECK(share_above(points, points) == 1.0);
    CHECK(share_above(1, points) > share_above(0, points));
  }
  CHECK_THROWS_AS(share_above(-1, 10), samara::ArgumentError);
  CHECK_THROWS_AS(share_above(11, 10), samara::ArgumentError);
  CHECK_THROWS_AS(share_above(0, 0), samara::ArgumentError);
}

TEST_CASE("at most five of a hundred certificates state too small a share") {
  samara::pgd::Random random(20261122);
  constexpr int kTrials = 4000, kPoints = 300;
  for (const double share : {0.002, 0.01, 0.05}) {
    int too_small = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
      int wrong = 0;
      for (int j = 0; j < kPoints; ++j) wrong += random.uniform() < share ? 1 : 0;
      too_small += share_above(wrong, kPoints) < share ? 1 : 0;
    }
    // Three deviations of the count above its expected value.
    CHECK(too_small <= 0.05 * kTrials + 3.0 * std::sqrt(0.05 * 0.95 * kTrials));
  }
}

TEST_CASE("a certificate takes as many points as the plan's assurance asks for") {
  CHECK(plan_of("").certificate_points() == 2000);
  CHECK(plan_of("assurance = 0.999\n").certificate_points() == 3000);
  CHECK(plan_of("assurance = 0.99\n").certificate_points() == 300);
  CHECK(plan_of("[builder]\nmax_calls = 500\n").certificate_points() == 500);
  CHECK_THAT(
      error_text<samara::InputError>([] { plan_of("assurance = 0.999\n[builder]\nmax_calls = 500\n"); }),
      Contains("p.toml:10") && Contains("takes 3000 points, more than the 500 calls"));
  for (const std::string wrong : {"1", "0.5", "nan", "-1", "1.5"}) {
    CHECK_THAT(error_text<samara::InputError>([&] { plan_of("assurance = " + wrong + "\n"); }),
               Contains("assurance"));
  }
  // A model's calls are evaluations: they do not bound its certificate.
  const Plan coin = parse_plan(
      "model = 'vertical_fall'\n[fixed]\narea = 4e-4\nthickness = 2e-3\ndensity = 6000\n[box]\nC_D = [1, "
      "2]\n[time]\n"
      "end = 0.1\n[tolerance]\nassurance = 0.999\n[builder]\nmax_calls = 10\n",
      "p.toml");
  CHECK(coin.certificate_points() == 3000);
}

TEST_CASE(
    "where a call takes longer than a minute, the certificate takes no more points than the builder did") {
  CHECK(plan_of("").certificate_points(59.0, 300.0) == 2000);
  CHECK(plan_of("").certificate_points(61.0, 300.0) == 300);
  CHECK(plan_of("").certificate_points(61.0, 1e5) == 2000);
  CHECK(plan_of("assurance = 0.99\n").certificate_points(61.0, 50.0) == 300);
}

TEST_CASE("every plan and every seed has certificate points of its own") {
  std::set<std::uint64_t> seeds;
  for (const std::string tail : {"", "[builder]\nseed = 2\n", "[builder]\nseed = 3\n"})
    seeds.insert(plan_of(tail).certificate_seed());
  seeds.insert(plan_of("", 3).certificate_seed());
  CHECK(seeds.size() == 4);
  CHECK(plan_of("").certificate_seed() == plan_of("").certificate_seed());
  CHECK(plan_of("# a remark\n[builder]\nthreads = 1\n").certificate_seed() == plan_of("").certificate_seed());
  CHECK(plan_of("absolute = { f = 1 }\n").certificate_seed() == plan_of("").certificate_seed());
  Plan other = plan_of("");
  other.builder.seed = 9;
  CHECK(other.certificate_seed() != plan_of("").certificate_seed());
  CHECK(build(plan_of("[builder]\nseed = 2\n"), function_of(smooth)).book.certificate()->seed !=
        build(plan_of(""), function_of(smooth)).book.certificate()->seed);
}

TEST_CASE("fewer points than usual are named with the verdict, in the file too") {
  const TemporaryDirectory directory;
  const BuildResult few = build(plan_of("assurance = 0.99\n"), function_of(smooth));
  REQUIRE(few.met);
  CHECK(verdict_of(few.book) == "met at 300 points");
  CHECK_THAT(few.message, Contains("met at 300 points"));
  const BuildResult usual = build(plan_of(""), function_of(smooth));
  REQUIRE(usual.met);
  CHECK(verdict_of(usual.book) == "met");
  CHECK(usual.book.certificate()->wrong_points == 0);
  save(few.book, directory / "few.h5");
  CHECK(verdict_of(load(directory / "few.h5")) == "met at 300 points");
  CHECK(load(directory / "few.h5").certificate()->wrong_points == 0);
  Certificate missed = *usual.book.certificate();
  missed.met = false;
  BuildRecord record = usual.book.build();
  CHECK(verdict(record, missed) == "missed");
  record.status = samara::Termination::max_calls;
  CHECK(verdict(record, missed) == "not converged");
  missed.failed_points = 1;
  CHECK(verdict(record, missed) == "missed");
  // The builder's own points erred.
  missed.failed_points = 0;
  for (const samara::Termination ended : {samara::Termination::missed, samara::Termination::refuted}) {
    record.status = ended;
    CHECK(verdict(record, missed) == "missed");
  }
}

TEST_CASE("a narrow peak is not called met by a build that has not seen it") {
  // In 1e-3 of the box, where 2,000 points see it in 86 of 100 builds: its tails show it to all of them.
  const auto peak = [](const Eigen::VectorXd& x) {
    const Eigen::Vector4d centre(0.31, 0.62, 0.47, 0.73);
    return 0.5 * x.sum() + 1.7 * std::exp(-0.5 * (x - centre).squaredNorm() / (0.05 * 0.05));
  };
  const Eigen::Vector4d centre(0.31, 0.62, 0.47, 0.73);
  int met = 0;
  for (int seed = 1; seed <= 6; ++seed) {
    const BuildResult result = build(
        plan_of("[builder]\nmax_calls = 30000\nseed = " + std::to_string(seed) + "\n", 4), function_of(peak));
    INFO(result.message << "; " << result.book.build().message);
    met += result.met ? 1 : 0;
    if (!result.met) continue;
    Query query(result.book);
    Eigen::VectorXd value(1);
    query.values({centre.data(), 4}, value);
    CHECK(value[0] == Approx(peak(centre)).margin(1e-2 * result.book.certificate()->outputs[0].range));
  }
  CHECK(met > 0);
}

TEST_CASE("a command that takes one point at a time gets the same certificate") {
  // Of one point an output has no range, and errors of 1e5 Pa look large.
  const auto loads = function_of([](const Eigen::VectorXd& x) { return 1e5 * smooth(x); });
  std::string text = plan_of("").text;
  text.insert(text.find("[box]"), "batch = 1\n");
  const BuildResult one = build(parse_plan(text, "p.toml"), loads);
  const BuildResult many = build(plan_of(""), loads);
  INFO(one.message << "; " << one.book.build().message);
  REQUIRE(one.met);
  REQUIRE(many.met);
  CHECK(one.book.certificate()->max_error == many.book.certificate()->max_error);
  CHECK(one.book.certificate()->refuted_before == many.book.certificate()->refuted_before);
}

TEST_CASE("a certificate that comes after refutations states more") {
  CHECK_THAT(share_above(0, 2000, 2), WithinRel(1.0 - std::pow(0.0125, 1.0 / 2000), 1e-9));
  CHECK_THROWS_AS(share_above(0, 10, -1), samara::ArgumentError);
}

TEST_CASE("the assurance is kept after refutations, by more points") {
  const Plan plan = plan_of("assurance = 0.99\n");
  for (const int refuted : {0, 1, 2, 20})
    CHECK(share_above(0, plan.certificate_points(0.0, 0.0, refuted), refuted) <= 0.01);
  CHECK(plan.certificate_points(0.0, 0.0, 1) == 370);
  // A peak in 3e-3 of the box: the builder meets it in one of three builds, 3,000 points in all of them.
  const auto peak = [](const Eigen::VectorXd& x) {
    return smooth(x) + std::exp(-0.5 * (x - Eigen::Vector2d(0.31, 0.62)).squaredNorm() / (0.01 * 0.01));
  };
  int most = 0;
  for (int seed = 1; seed <= 5; ++seed) {
    const Plan asked = plan_of(
        "assurance = 0.999\n[builder]\nmax_calls = 4000\nguards = 10\nseed = " + std::to_string(seed) + "\n");
    const BuildResult result = build(asked, function_of(peak));
    const Certificate& certificate = *result.book.certificate();
    INFO(result.message << "; " << result.book.build().message);
    CHECK(certificate.points == asked.certificate_points(0.0, 0.0, certificate.refuted_before));
    most = std::max(most, certificate.refuted_before);
  }
  CHECK(most > 0);
}

TEST_CASE("cancelled in its certificate, a build calls nothing more") {
  long calls = 0;
  bool stop = false;
  const auto counted = function_of([&](const Eigen::VectorXd& x) {
    ++calls;
    return smooth(x);
  });
  long calls_when_stopped = 0;
  BuildOptions options;
  options.progress = [&](const samara::Progress& progress) {
    if (!stop && progress.stage == "certificate" && progress.fraction > 0.3) {
      stop = true;
      calls_when_stopped = calls;
    }
    return !stop;
  };
  const BuildResult result = build(plan_of(""), counted, options);
  CHECK(stop);
  CHECK_FALSE(result.met);
  CHECK(result.resumable);
  CHECK(calls == calls_when_stopped);
}

TEST_CASE("a certificate that was cancelled while it climbs is not met") {
  // A bump of a third of the tolerance stands out from the errors of a smooth function.
  const auto bumpy = function_of([](const Eigen::VectorXd& x) {
    return smooth(x) + 6e-3 * std::exp(-0.5 * (x - Eigen::Vector2d(0.3, 0.7)).squaredNorm() / (0.04 * 0.04));
  });
  const BuildResult whole = build(plan_of(""), bumpy);
  INFO(whole.message << "; " << whole.book.build().message);
  REQUIRE(whole.met);
  REQUIRE(whole.book.certificate()->climbed_points > 0);
  bool climbing = false;
  BuildOptions options;
  options.progress = [&](const samara::Progress& progress) {
    climbing = climbing || (progress.stage == "certificate" && progress.fraction == 1.0);
    return !climbing;
  };
  const BuildResult stopped = build(plan_of(""), bumpy, options);
  CHECK(climbing);
  CHECK_FALSE(stopped.met);
  CHECK_FALSE(stopped.book.certificate()->met);
  CHECK(stopped.resumable);
}

TEST_CASE("a function may answer instead of the plan's command, and its failures are reported as of one") {
  const BuildResult result = build(plan_of(""), function_of(smooth));
  INFO(result.message);
  REQUIRE(result.met);
  const double at[] = {0.3, 0.6};
  Eigen::VectorXd value(1);
  Query query(result.book);
  query.values(at, value);
  CHECK(value[0] == Approx(std::exp(-0.9) + 0.3).margin(1e-2));
  const auto failing = function_of([](const Eigen::VectorXd& x) {
    if (x[0] == 1.0) throw std::runtime_error("no answer at the border");
    return smooth(x);
  });
  CHECK_THAT(error_text<samara::NoResultError>([&] { build(plan_of(""), failing); }),
             Contains("no answer at the border"));
  CHECK_THROWS_AS(build(plan_of(""), samara::pgd::PointsFunction()), samara::ArgumentError);
}
