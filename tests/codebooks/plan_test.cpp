#include "samara/codebooks/plan.h"

#include <catch2/catch.hpp>

#include "coin_book.h"
#include "samara/base/errors.h"

using namespace samara;
using Catch::Matchers::Contains;
using codebooks::parse_plan;

namespace {

std::string replaced(const std::string& from, const std::string& to) {
  std::string text = test::coin_plan();
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

void check_refused(const std::string& text, const std::string& place, const std::string& part) {
  CAPTURE(text);
  CHECK_THROWS_AS(parse_plan(text, "plan.toml"), InputError);
  CHECK_THROWS_WITH(parse_plan(text, "plan.toml"), Contains(place) && Contains(part));
}

}  // namespace

TEST_CASE("a plan is read in SI units, in the order of its box") {
  const codebooks::Plan plan = parse_plan(test::coin_plan(), "plan.toml");
  CHECK(plan.model == "vertical_fall");
  CHECK(plan.fixed.at("thickness") == Approx(2.55e-3).epsilon(1e-15));
  CHECK(plan.fixed.at("density") == Approx(6338.5).epsilon(1e-14));
  REQUIRE(plan.box.size() == 2);
  CHECK(plan.box[0].name == "C_D");
  CHECK(plan.box[1].name == "v(0)");
  CHECK(plan.box[1].lower == Approx(-0.1).epsilon(1e-14));
  CHECK(plan.end == 0.4);
  CHECK(plan.relative == 1e-3);
  CHECK(plan.text == test::coin_plan());
}

TEST_CASE("nodes, floors and the builder's settings are read") {
  const codebooks::Plan plan =
      parse_plan(replaced("C_D = [0.8, 1.6]", "C_D = { range = [0.8, 1.6], nodes = 9 }") +
                     "absolute = { x = \"1 mm\" }\n[builder]\nkind = \"pgd\"\nstrategy = \"newton\"\n"
                     "max_calls = 1000\nthreads = 2\nseed = 5\n",
                 "plan.toml");
  CHECK(plan.box[0].nodes == 9);
  CHECK(plan.absolute.at("x") == 1e-3);
  CHECK(plan.builder.kind == "pgd");
  CHECK(plan.builder.max_calls == 1000);
  CHECK(plan.builder.threads == 2);
  CHECK(plan.builder.seed == 5);
}

TEST_CASE("what cannot be a plan is refused with its line and what was expected") {
  check_refused(replaced("[box]", "[bocks]"), "plan.toml:6", "bocks");
  check_refused(replaced("C_D", "C_T"), "plan.toml:7", "did you mean \"C_D\"?");
  check_refused(replaced("C_D = [0.8, 1.6]", "k = [1.0, 2.0]"), "plan.toml:7", "vertical_fall");
  check_refused(replaced("[0.8, 1.6]", "[1.6, 0.8]"), "plan.toml:7", "lower < upper");
  check_refused(replaced("[0.8, 1.6]", "[1.0, 1.0]"), "plan.toml:7", "lower < upper");
  check_refused(replaced("[0.8, 1.6]", "[0.8, nan]"), "plan.toml:7", "nan");
  check_refused(replaced("[0.8, 1.6]", "[0.8, inf]"), "plan.toml:7", "inf");
  check_refused(replaced("[0.8, 1.6]", "[0.8]"), "plan.toml:7", "1 numbers");
  check_refused(replaced("[0.8, 1.6]", "[-1.0, 1.6]"), "plan.toml", "C_D");
  check_refused(replaced("2.55 mm", "2.55 kg"), "plan.toml:4", "2.55 kg");
  check_refused(replaced("2.55 mm", "2.55 furlong"), "plan.toml:4", "furlong");
  check_refused(replaced("thickness = \"2.55 mm\"\n", ""), "plan.toml", "thickness");
  check_refused(replaced("[box]\n", "C_D = 1.0\n[box]\n"), "C_D", "fixed in [fixed] and free in [box]");
  check_refused(replaced("0.4 s", "0 s"), "plan.toml:10", "more than 0");
  check_refused(replaced("0.4 s", "-1 s"), "plan.toml:10", "more than 0");
  check_refused(replaced("1e-3", "0.0"), "plan.toml:12", "relative");
  check_refused(replaced("vertical_fall", "vertical_fal"), "plan.toml", "vertical_fall");
  check_refused(replaced("[time]", "[time"), "plan.toml:9", "");
  check_refused(test::coin_plan() + "[builder]\nkind = \"sampling\"\n", "plan.toml:14", "sampling");
  check_refused(test::coin_plan() + "[builder]\nthreads = -1\n", "plan.toml:14", "threads");
  check_refused("model = \"constant_rate\"\n[box]\n[time]\nend = 1\n", "plan.toml", "empty");
  CHECK_THROWS_AS(codebooks::read_plan("no/such/plan.toml"), InputError);
}
