#include "samara/base/errors.h"

#include <catch2/catch.hpp>

TEST_CASE("an input error names file and line where lines mean something") {
  CHECK(std::string(samara::InputError("plan.toml", 3, "bad").what()) == "plan.toml:3: bad");
  CHECK(std::string(samara::InputError("book.h5", "truncated").what()) == "book.h5: truncated");
}

TEST_CASE("every error of the family can be caught as samara::Error") {
  CHECK_THROWS_AS(throw samara::ArgumentError("a"), samara::Error);
  CHECK_THROWS_AS(throw samara::InputError("f", "a"), samara::Error);
  CHECK_THROWS_AS(throw samara::OutsideBoxError("a"), samara::Error);
}
