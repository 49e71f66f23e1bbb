#include "samara/base/errors.h"

#include <catch2/catch.hpp>

#include "samara/base/text.h"

TEST_CASE("an input error names file and line where lines mean something") {
  CHECK(std::string(samara::InputError("plan.toml", 3, "bad").what()) == "plan.toml:3: bad");
  CHECK(std::string(samara::InputError("book.h5", "truncated").what()) == "book.h5: truncated");
}

TEST_CASE("every error of the family can be caught as samara::Error") {
  CHECK_THROWS_AS(throw samara::ArgumentError("a"), samara::Error);
  CHECK_THROWS_AS(throw samara::InputError("f", "a"), samara::Error);
  CHECK_THROWS_AS(throw samara::OutsideBoxError("a"), samara::Error);
}

TEST_CASE("the ending of a name counts in capitals, too") {
  CHECK(samara::ending_of("a.b/fall.CSV") == ".csv");
  CHECK(samara::ending_of("a.b/fall") == "");
  CHECK(samara::ending_of("") == "");
}

TEST_CASE("a quote ends between characters, and of bytes that are none after sixty") {
  const std::string umlaut = "\xC3\xA4";
  CHECK(samara::in_quotes(std::string(59, 'a') + umlaut) == '"' + std::string(59, 'a') + "...\"");
  CHECK(samara::in_quotes(std::string(70, '\x80')) == '"' + std::string(60, '\x80') + "...\"");
  CHECK(samara::in_quotes("").size() == 2);
}
