#include "samara/codebooks/build/strategy_builder.h"

#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/codebooks/build/build.h"

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
  for (const char* strategy : {"cross", "empirical", "incremental"}) {
    const BuildResult result = build(plate_plan(strategy, "1e-4"), few_points());
    CAPTURE(strategy, result.message, result.book.build().message);
    CHECK(result.met);
    CHECK(result.book.build().strategy == strategy);
    CHECK(result.book.build().status == samara::Termination::converged);
    CHECK(result.book.certificate()->max_error <= 1e-4);
    CHECK(result.book.build().evaluations > 0);
  }
}

TEST_CASE("a strategy that solves other equations leaves its field, and misses") {
  const BuildResult result = build(plate_plan("piecewise_linear", "1e-4", ", nodes = 7"), few_points());
  CAPTURE(result.message, result.book.build().message);
  CHECK_FALSE(result.met);
  CHECK(result.book.build().status == samara::Termination::missed);
  CHECK_THAT(result.book.build().message, Contains("piecewise-linear") && Contains("defect"));
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

TEST_CASE("builds by a strategy end with their evaluations, report their slabs, and are not resumed") {
  Plan plan = plate_plan("cross", "1e-4", ", nodes = 8");
  std::string stage;
  BuildOptions options = few_points();
  options.progress = [&](const samara::Progress& report) {
    if (stage.empty()) stage = report.stage;
    return true;
  };
  build(plan, options);
  CHECK(stage == "cross, round 1: slab 1 of 8");

  plan.builder.max_calls = 200;
  CHECK_THROWS_WITH(build(plan, few_points()),
                    Contains("no result on the first slab: ") && Contains("200 evaluations"));
  // Enough for the first round, not for the second: status and message say so both.
  plan.builder.max_calls = 20'000;
  const BuildResult cut = build(plan, few_points());
  CAPTURE(cut.book.build().evaluations);
  CHECK(cut.book.build().status == samara::Termination::max_calls);
  CHECK_THAT(cut.book.build().message, Contains("allowed are used up; the result is that of round 1"));
}
