#include "samara/identification/problem/warnings.h"

#include <catch2/catch.hpp>

using namespace samara::identification;

TEST_CASE("warnings keep their order, and each sentence once") {
  Warnings warnings;
  CHECK(warnings.empty());
  CHECK(warnings.add(WarningKind::noise, "much noise"));
  warnings.add_all(WarningKind::captures, {"few frames", "much noise", "few frames"});
  CHECK_FALSE(warnings.add(WarningKind::captures, "few frames"));
  CHECK(warnings.sentences() == std::vector<std::string>{"much noise", "few frames"});

  Warnings others;
  others.add(WarningKind::bounds, "at a bound");
  others.add(WarningKind::noise, "much noise");
  warnings.add_all(others);
  CHECK(warnings.sentences() == std::vector<std::string>{"much noise", "few frames", "at a bound"});
}

TEST_CASE("warnings are found by their kind and a part of their sentence") {
  Warnings warnings;
  warnings.add_all(WarningKind::captures, {"few frames", "a gap"});
  warnings.add(WarningKind::bounds, "k lies at a bound");
  CHECK(warnings.has(WarningKind::bounds));
  CHECK(warnings.has(WarningKind::captures, "gap"));
  CHECK_FALSE(warnings.has(WarningKind::bounds, "gap"));
  CHECK_FALSE(warnings.has(WarningKind::steps));
}
