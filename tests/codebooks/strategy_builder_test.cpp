#include <algorithm>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "../io/temporary_directory.h"
#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/file/save.h"
#include "samara/codebooks/query/query.h"
#include "samara/pgd/nonlinear/march.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;

namespace {

/// A swing of the reference plate to t = 1.
Plan plate_plan(const std::string& strategy, const std::string& tolerance, const std::string& nodes = "") {
  std::string text = "model = 'falling_plate_nd'\n[fixed]\n'theta(0)' = 0.4\n[box]\n";
  text += "C_T = { range = [0.8, 1.4]" + nodes + " }\nC_R = { range = [2, 4]" + nodes + " }\n";
  text += "[time]\nend = 1\n[tolerance]\nrelative = " + tolerance + "\n";
  text += "[builder]\nkind = 'pgd'\nstrategy = '" + strategy + "'\n";
  return parse_plan(text, "p.toml");
}

BuildOptions few_points() {
  BuildOptions options;
  options.certificate_points = 100;
  return options;
}

}  // namespace

TEST_CASE("plans name the strategy that builds them, and the certificate agrees") {
  for (const char* strategy : {"cross", "empirical", "incremental", "decoupling"}) {
    const BuildResult result = build(plate_plan(strategy, "1e-4"), few_points());
    CAPTURE(strategy, result.message, result.book.build().message);
    CHECK(result.met);
    CHECK(result.book.build().strategy == strategy);
    CHECK(result.book.build().status == samara::Termination::converged);
    CHECK(result.book.certificate()->max_error <= 1e-4);
    CHECK(result.book.build().evaluations > 0);
  }
}

TEST_CASE("every strategy that a plan may name ends in a certified codebook that is saved, read and asked") {
  for (const std::string& strategy : samara::pgd::strategy_names()) {
    const bool is_coarse = strategy == "enrichment" || strategy == "piecewise_linear";
    const BuildResult result = build(plate_plan(strategy, is_coarse ? "2e-2" : "1e-3"), few_points());
    CAPTURE(strategy, result.message, result.book.build().message);
    CHECK(result.met);
    CHECK(result.book.build().strategy == strategy);
    const TemporaryDirectory directory;
    save(result.book, directory / "plate.h5");
    const Codebook read = load(directory / "plate.h5");
    CHECK(read.build().strategy == strategy);
    REQUIRE(read.certificate());
    CHECK(read.certificate()->met);
    Eigen::VectorXd before(result.book.output_count()), after(read.output_count());
    const std::vector<double> point = {0.7, 1.1, 3.1};
    Query(result.book).values(point, before);
    Query(read).values(point, after);
    CHECK(after.isApprox(before, 1e-12));
  }
}

TEST_CASE("a strategy that solves other equations leaves its field, and misses") {
  const BuildResult result = build(plate_plan("piecewise_linear", "1e-4", ", nodes = 7"), few_points());
  CAPTURE(result.message, result.book.build().message);
  CHECK_FALSE(result.met);
  CHECK(result.book.build().status == samara::Termination::missed);
  CHECK_THAT(result.book.build().message, Contains("piecewise-linear") && Contains("comes no closer"));
  CHECK(result.book.certificate()->max_error < 0.1);
}

TEST_CASE("nodes that the plan fixes are kept, slabs are shortened until a strategy contracts") {
  const BuildResult result = build(plate_plan("incremental", "1e-3", ", nodes = 8"), few_points());
  CAPTURE(result.message);
  CHECK(result.met);
  for (const Piece& piece : result.book.pieces()) {
    for (std::size_t k = 1; k <= 2; ++k) CHECK(piece.groups().front().axes()[k].size() == 8);
  }
}

TEST_CASE("by the name of newton the strategy is meant that linearises by Newton") {
  const BuildResult result = build(plate_plan("newton", "1e-3"), few_points());
  CHECK(result.met);
  CHECK(result.book.build().strategy == "cross");
}

TEST_CASE("too few nodes in a plan end in a codebook that says so, by any strategy") {
  for (const char* strategy : {"auto", "empirical"}) {
    const BuildResult result = build(plate_plan(strategy, "1e-5", ", nodes = 2"), few_points());
    CAPTURE(strategy, result.message);
    CHECK_FALSE(result.met);
    CHECK(result.book.build().status == samara::Termination::missed);
    CHECK_THAT(result.book.build().message, Contains("the nodes that are prescribed do not suffice"));
    CHECK(result.book.certificate()->max_error < 0.1);
  }
}

TEST_CASE("builds by a strategy end with their evaluations, and report their slabs") {
  Plan plan = plate_plan("cross", "1e-4", ", nodes = 8");
  std::vector<std::string> stages;
  BuildOptions options = few_points();
  options.progress = [&](const samara::Progress& report) {
    stages.push_back(report.stage);
    return true;
  };
  build(plan, options);
  CHECK(std::ranges::count(stages, "slab 1") > 0);

  plan.builder.max_calls = 100'000;
  const BuildResult cut = build(plan, few_points());
  CAPTURE(cut.book.build().evaluations);
  CHECK(cut.book.build().status == samara::Termination::max_calls);
  CHECK_THAT(cut.book.build().message, Contains("evaluations used, 100000 allowed"));
}

TEST_CASE("where the guard points of a march see too much, but the certificate does not, the plan is met") {
  // On prescribed nodes the error is what it is; the tolerance is set between half of it and all of it.
  const Plan asked = plate_plan("slabs", "1e-6", ", nodes = 3");
  const double error = build(asked, few_points()).book.certificate()->max_error;
  Plan plan = asked;
  plan.relative = 1.4 * error;
  const BuildResult result = build(plan, few_points());
  CAPTURE(result.message, result.book.build().message, error);
  CHECK(result.book.build().status == samara::Termination::missed);
  CHECK(result.book.certificate()->max_error <= plan.relative);
  CHECK(result.met);
  plan.relative = 0.7 * error;
  CHECK_FALSE(build(plan, few_points()).met);
}

TEST_CASE("what guard points saw beyond the tolerance is not outvoted by a certificate of few points") {
  BuildOptions options;
  options.certificate_points = 1;
  Plan plan = plate_plan("slabs", "1e-9", ", nodes = 3");
  const double seen = build(plan, options).book.certificate()->spent.nonlinearity;
  plan.relative = 0.9 * seen;
  const BuildResult result = build(plan, options);
  CAPTURE(result.message, seen, result.book.certificate()->max_error);
  CHECK(result.book.certificate()->max_error <= plan.relative);
  CHECK_FALSE(result.met);
}
