#include "samara/base/require.h"

#include <limits>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/base/errors.h"

using samara::ArgumentError;
using samara::require;
using samara::require_not_negative;
using samara::require_positive;

namespace {

template <class Call>
std::string refusal_of(const Call& call) {
  return error_text<ArgumentError>(call);
}

}  // namespace

TEST_CASE("a value that is refused is named with what was expected and where") {
  CHECK(refusal_of([] { require(false, "max_rank", 0, "at least 1", "enrich"); }) ==
        "enrich: max_rank is 0; at least 1 was expected");
  CHECK(refusal_of([] { require(false, "tolerance", 1.5, "a number between 0 and 1"); }) ==
        "tolerance is 1.5; a number between 0 and 1 was expected");
  CHECK_NOTHROW(require(true, "max_rank", 0, "at least 1"));
}

TEST_CASE("whole numbers are shown whole, others as they read back") {
  CHECK(refusal_of([] { require(false, "calls", 100000L, "fewer"); }) ==
        "calls is 100000; fewer was expected");
  CHECK(refusal_of([] { require(false, "step", 0.1, "more"); }) == "step is 0.1; more was expected");
}

TEST_CASE("only finite numbers of the right sign are positive, or not negative") {
  const double infinity = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double value : {0.0, -1.0, infinity, nan}) {
    INFO(value);
    CHECK_THROWS_AS(require_positive(value, "step [s]"), ArgumentError);
  }
  for (const double value : {-1e-300, infinity, nan}) {
    INFO(value);
    CHECK_THROWS_AS(require_not_negative(value, "step [s]"), ArgumentError);
  }
  CHECK_NOTHROW(require_positive(1e-300, "step [s]"));
  CHECK_NOTHROW(require_not_negative(0.0, "step [s]"));
  CHECK(refusal_of([&] { require_positive(0.0, "step [s]", "simulate"); }) ==
        "simulate: step [s] is 0; a positive finite number was expected");
}
