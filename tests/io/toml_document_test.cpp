#include "samara/io/toml_document.h"

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "samara/io/toml_edit.h"
#include "temporary_directory.h"

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using samara::InputError;
using samara::io::changed_toml;
using samara::io::TomlTable;

namespace {

const char* const kPlan = R"toml(model = "falling_plate_nd"

[fixed]
thickness = "1.5 mm"
density = 1100
tilt = "90 deg"

[box]
C_T = [0.8, 1.4]
A   = { range = [1.0, 1.8], nodes = 14 }
"theta(0)" = ["10 deg", 0.5]

[time]
end = 5
exact = true

[command]
run = ["./solver", "--fast"]
inputs = [{ name = "a", unit = "m" }, { name = "b" }]
)toml";

TomlTable plan() {
  return TomlTable::parse(kPlan, "plan.toml");
}

template <typename Call>
std::string toml_error(const Call& call) {
  return error_text<InputError>(call);
}

}  // namespace

TEST_CASE("values of each kind are read by key") {
  const TomlTable root = plan();
  CHECK(root.string("model") == "falling_plate_nd");
  CHECK(root.table("time").integer("end") == 5);
  CHECK(root.table("time").number("end") == 5.0);
  CHECK(root.table("time").boolean("exact"));
  CHECK(root.table("box").numbers("C_T") == std::vector{0.8, 1.4});
  CHECK(root.table("box").table("A").numbers("range") == std::vector{1.0, 1.8});
  CHECK(root.table("box").table("A").integer("nodes") == 14);
  CHECK(root.table("command").strings("run") == std::vector<std::string>{"./solver", "--fast"});
  CHECK(root.table("command").tables("inputs").at(1).string("name") == "b");
  const TomlTable nested = TomlTable::parse("pairs = [[\"a\", \"b\"], []]\n", "pairs.toml");
  CHECK(nested.string_lists("pairs") == std::vector<std::vector<std::string>>{{"a", "b"}, {}});
}

TEST_CASE("quantities are SI numbers, or strings with a unit") {
  const TomlTable root = plan();
  CHECK(root.table("fixed").quantity("thickness", "m") == 1.5e-3);
  CHECK(root.table("fixed").quantity("density", "kg/m^3") == 1100.0);
  CHECK(root.table("box").quantities("theta(0)", "rad") == std::vector{10 * (3.141592653589793 / 180), 0.5});
}

TEST_CASE("an optional value that is missing is nothing, one of the wrong kind is an error") {
  const TomlTable time = plan().table("time");
  CHECK(time.optional_number("end") == 5.0);
  CHECK_FALSE(time.optional_number("slabs"));
  CHECK_FALSE(time.optional_string("slabs"));
  CHECK_FALSE(time.optional_boolean("slabs"));
  CHECK_FALSE(time.optional_integer("slabs"));
  CHECK_FALSE(time.optional_quantity("slabs", "s"));
  CHECK_FALSE(time.optional_numbers("slabs"));
  CHECK_FALSE(time.optional_strings("slabs"));
  CHECK_FALSE(time.optional_quantities("slabs", "s"));
  CHECK_FALSE(time.optional_table("slabs"));
  CHECK_FALSE(time.optional_tables("slabs"));
  CHECK_THAT(toml_error([&] { time.optional_string("end"); }),
             Contains("expected a string, found the integer 5"));
}

TEST_CASE("kinds can be asked for, and a missing key is of no kind") {
  const TomlTable root = TomlTable::parse("s='a'\nb=true\ni=1\nf=1.5\na=[]\nt={}", "t");
  CHECK((root.is_string("s") && !root.is_string("b") && !root.is_string("none")));
  CHECK((root.is_boolean("b") && !root.is_boolean("i")));
  CHECK((root.is_integer("i") && !root.is_integer("f")));
  CHECK((root.is_number("i") && root.is_number("f") && !root.is_number("s")));
  CHECK((root.is_array("a") && !root.is_array("t")));
  CHECK((root.is_table("t") && !root.is_table("a")));
}

TEST_CASE("keys come in the order of the file") {
  CHECK(plan().keys() == std::vector<std::string>{"model", "fixed", "box", "time", "command"});
  CHECK(plan().table("box").keys() == std::vector<std::string>{"C_T", "A", "theta(0)"});
  CHECK(TomlTable::parse("t = { z = 1, b = 2, a = 3 }", "t").table("t").keys() ==
        std::vector<std::string>{"z", "b", "a"});
}

TEST_CASE("quoted keys are single keys") {
  const TomlTable root = TomlTable::parse("\"v(0)\" = 1\n\"a.b\" = 2\n'' = 3\na.c = 4", "t");
  CHECK(root.integer("v(0)") == 1);
  CHECK(root.integer("a.b") == 2);
  CHECK(root.integer("") == 3);
  CHECK_FALSE(root.has("a.c"));
  CHECK(root.table("a").integer("c") == 4);
}

TEST_CASE("a table outlives the value it was taken from") {
  const TomlTable range = TomlTable::parse("[a]\nb = { c = 1 }", "t").table("a").table("b");
  CHECK(range.integer("c") == 1);
}

TEST_CASE("a table knows file, path and lines") {
  const TomlTable root = plan();
  CHECK(root.file() == "plan.toml");
  CHECK(root.path().empty());
  CHECK(root.table("box").path() == "[box]");
  CHECK(root.table("box").table("A").path() == "[box.A]");
  CHECK(root.table("command").tables("inputs").at(1).path() == "[command.inputs[1]]");
  CHECK(root.table("box").line("theta(0)") == 11);
  CHECK(root.table("box").line("none") == 8);
  CHECK(root.line("none") == 0);
}

TEST_CASE("a value of the wrong kind is refused with file, line, table, key and what was found") {
  const TomlTable root = plan();
  CHECK(toml_error([&] { root.table("fixed").number("thickness"); }) ==
        "plan.toml:4: [fixed] thickness: expected a number, found the string \"1.5 mm\"");
  CHECK(toml_error([&] { root.integer("model"); }) ==
        "plan.toml:1: model: expected an integer, found the string \"falling_plate_nd\"");
  CHECK_THAT(toml_error([&] { root.table("time").boolean("end"); }), Contains("found the integer 5"));
  CHECK_THAT(toml_error([&] { root.table("time").table("exact"); }), Contains("found the boolean true"));
  CHECK_THAT(toml_error([&] { root.string("box"); }),
             Contains("plan.toml:8: box: expected a string, found a table"));
  CHECK_THAT(toml_error([&] { root.table("box").number("C_T"); }), Contains("found an array"));
  CHECK_THAT(toml_error([&] { root.table("box").integer("theta(0)"); }),
             StartsWith("plan.toml:11: [box] \"theta(0)\":"));
  CHECK_THAT(toml_error([&] { root.strings("model"); }), Contains("expected an array of strings"));
  CHECK_THAT(toml_error([&] { root.table("command").string_lists("run"); }),
             Contains("element 0: expected an array of strings"));
  CHECK_THAT(toml_error([&] { root.table("box").strings("C_T"); }),
             Contains("element 0: expected a string, found the number 0.8"));
  CHECK_THAT(toml_error([&] { root.table("box").tables("C_T"); }), Contains("element 0: expected a table"));
  CHECK_THAT(toml_error([] { TomlTable::parse("d = 2020-01-01", "t").number("d"); }),
             Contains("found a date"));
  CHECK_THAT(toml_error([] { TomlTable::parse("d = 2.0", "t").integer("d"); }),
             Contains("found the number 2"));
}

TEST_CASE("a missing key is refused at its table") {
  CHECK(toml_error([] { plan().table("time").number("start"); }) ==
        "plan.toml:13: [time] start: the key is missing");
  CHECK(toml_error([] { plan().string("title"); }) == "plan.toml: title: the key is missing");
}

TEST_CASE("numbers that are not finite are refused") {
  for (const std::string text : {"nan", "inf", "-inf"}) {
    const TomlTable root = TomlTable::parse(std::string("a = ") + text + "\nb = [1, " + text + "]", "t.toml");
    CHECK_THAT(toml_error([&] { root.number("a"); }),
               StartsWith("t.toml:1: a: expected a finite number, found"));
    CHECK_THAT(toml_error([&] { root.quantity("a", "m"); }), Contains("expected a finite number"));
    CHECK_THAT(toml_error([&] { root.numbers("b"); }),
               StartsWith("t.toml:2: b: element 1: expected a finite number"));
  }
}

TEST_CASE("numbers too large or too small to calculate with are refused") {
  const TomlTable root = TomlTable::parse(
      "a = 1e300\nb = [1, -1e-300]\nc = '1e70 m'\nd = [1e60, -1e-60, 0, '1e-70 m']\ne = 0.0", "t.toml");
  CHECK(toml_error([&] { root.number("a"); }) ==
        "t.toml:1: a: has the number 1e+300, expected at most 1e+60 in size");
  CHECK(toml_error([&] { root.numbers("b"); }) ==
        "t.toml:2: b: element 1: has the number -1e-300, expected at least 1e-60 in size, or 0");
  CHECK_THAT(toml_error([&] { root.quantity("c", "m"); }), Contains("c: has the number 1e+70"));
  CHECK_THAT(toml_error([&] { root.quantities("d", "m"); }), Contains("d: element 3: has the number 1e-70"));
  CHECK(root.number("e") == 0.0);
}

TEST_CASE("a quantity with a wrong unit is refused with its place") {
  const TomlTable fixed = plan().table("fixed");
  CHECK(toml_error([&] { fixed.quantity("thickness", "kg"); }) ==
        "plan.toml:4: [fixed] thickness: \"1.5 mm\" has the dimension m, expected kg");
  CHECK_THAT(toml_error([] { TomlTable::parse("a = ['1 m', '2 mx']", "t").quantities("a", "m"); }),
             Contains("t:1: a: element 1: \"2 mx\": unknown unit \"mx\""));
  CHECK_THAT(toml_error([] { TomlTable::parse("a = true", "t").quantity("a", "m"); }),
             Contains("expected a number, or a string with a unit, found the boolean true"));
}

TEST_CASE("a quantity that must be more than 0 is refused with its place where it is not") {
  const TomlTable root =
      TomlTable::parse("[a]\nlength = '2 mm'\nnone = 0\nwarm = '2 degC'\nstep = '2 mK'\nless = -0.5", "t");
  const TomlTable a = root.table("a");
  CHECK(a.positive("length", "m") == 2e-3);
  CHECK_FALSE(a.optional_positive("height", "m"));
  CHECK(a.positive("warm", "K") == 275.15);
  CHECK(a.positive_difference("step", "K") == 2e-3);
  CHECK(toml_error([&] { a.positive("none", "m"); }) == "t:3: [a] none: is 0 m; more than 0 was expected");
  CHECK(toml_error([&] { a.optional_positive("less", "m"); }) ==
        "t:6: [a] less: is -0.5 m; more than 0 was expected");
  CHECK(toml_error([&] { a.positive_difference("none", "K"); }) ==
        "t:3: [a] none: is 0 K; more than 0 was expected");
  CHECK(toml_error([&] { a.positive("none", "1"); }) == "t:3: [a] none: is 0; more than 0 was expected");
  CHECK_THAT(toml_error([&] { a.positive_difference("warm", "K"); }),
             StartsWith("t:4: [a] warm: ") && Contains("a difference of temperatures is given in K"));
}

TEST_CASE("an unknown key is refused with its line and the nearest known") {
  const TomlTable box = plan().table("box");
  CHECK_NOTHROW(box.expect_keys({"A", "C_T", "theta(0)", "unused"}));
  CHECK(toml_error([&] {
          box.expect_keys({"C_T", "AA", "theta(0)"});
        }) == "plan.toml:10: [box] A: unknown key; did you mean \"AA\"?");
  CHECK_THAT(toml_error([] { plan().expect_keys({"model"}); }),
             Contains("plan.toml:3: fixed: unknown key; known: model"));
}

TEST_CASE("callers can raise errors with a place") {
  CHECK(std::string(plan().table("box").error("C_T", "the range is empty").what()) ==
        "plan.toml:9: [box] C_T: the range is empty");
}

TEST_CASE("a text that is not TOML is refused with its line, in one sentence") {
  for (const std::string bad :
       {"a = ", "a = 1\na = 2", "[t", "a = \"open", "= 1", "a = 1 b = 2", "[t]\n[t]"}) {
    const std::string error =
        toml_error([&] { TomlTable::parse(std::string("x = 1\n") + bad + "\n", "bad.toml"); });
    INFO(bad);
    CHECK_THAT(error,
               StartsWith("bad.toml:2: not valid TOML: ") || StartsWith("bad.toml:3: not valid TOML: "));
    CHECK(error.find('\n') == std::string::npos);
  }
}

TEST_CASE("a text of another kind is named by what it is") {
  const auto error = [](const std::string& text) {
    return toml_error([&] { TomlTable::parse(text, "f", "a plan of a codebook"); });
  };
  CHECK(error("# a comment\nt[s],x[m]\n0,0\n") == "f: is a table, expected a plan of a codebook");
  CHECK(error("t;x\n0,5;1\n") == "f: is a table, expected a plan of a codebook");
  CHECK(error("{\"schema\": \"samara-fit/1\"}\n") == "f: is JSON, expected a plan of a codebook");
  CHECK_THAT(error("<!DOCTYPE html>\n"), StartsWith("f: is a page or a picture (HTML, XML), expected"));
  CHECK_THAT(error("model vertical, or so\n[box]\n"), StartsWith("f:1: not valid TOML: "));
}

TEST_CASE("a file with keys of another kind of file is named by that kind") {
  const auto error = [](const std::string& text, const std::string& expected) {
    const TomlTable table = TomlTable::parse(text, "f", expected);
    return toml_error([&] { table.expect_keys({"model", "box", "time", "columns"}); });
  };
  const std::string sidecar = "group_by = [\"drop\"]\nframe_rate = 60\n";
  CHECK(error(sidecar, "a plan of a codebook") == "f: is a sidecar, expected a plan of a codebook");
  // A key more, or one that is misspelt, makes it no other kind.
  CHECK_THAT(error(sidecar + "bos = 1\n", "a sidecar"), StartsWith("f:1: group_by: unknown key"));
  CHECK_THAT(error("time = 1\nscale = 2\n", "a plan of a codebook"), StartsWith("f:2: scale: unknown key"));
  CHECK_THAT(error("bos = 1\n", "a plan of a codebook"), StartsWith("f:1: bos: unknown key"));
  CHECK_THAT(error(sidecar, "TOML"), StartsWith("f:1: group_by: unknown key"));
}

TEST_CASE("nesting of any depth is read or refused, and never exhausts the stack") {
  const auto nested_error = [](std::string text, const std::string& repeated, const std::string& last) {
    for (int i = 0; i < 200000; ++i) text += repeated;
    text += last;
    return toml_error([&] { TomlTable::parse(text, "deep"); });
  };
  CHECK_THAT(nested_error("a = ", "[", ""), StartsWith("deep"));
  CHECK_THAT(nested_error("t = ", "{a=", ""), StartsWith("deep"));
  CHECK(nested_error("x = 1\n", "a.", "a = 1") == "deep:2: a key has more than 200 dots");
  CHECK(nested_error("[", "'a' . ", "a]") == "deep:1: a key has more than 200 dots");
  CHECK(nested_error("a = [", "0.5, ", "]") == "no exception");
  CHECK(nested_error("a = '", "...", "'") == "no exception");
}

TEST_CASE("a file is read with its path in errors") {
  const TemporaryDirectory directory;
  put_content(directory / "p.toml",
              "\xEF\xBB\xBF"
              "a = 1\r\nb = 'x'\r\n");
  const TomlTable root = TomlTable::read(directory / "p.toml");
  CHECK(root.integer("a") == 1);
  CHECK_THAT(toml_error([&] { root.number("b"); }), StartsWith((directory / "p.toml").string() + ":2: b: "));
  CHECK_THAT(toml_error([&] { TomlTable::read(directory / "none.toml"); }),
             Contains("none.toml: the file does not exist"));
  CHECK_THAT(toml_error([&] { TomlTable::read(directory.path()); }), Contains("is a directory"));
}

TEST_CASE("a change of a TOML text leaves everything else as it stands") {
  const std::string text =
      "# a plan\nmodel = \"m\"  # \u00e4\n[fixed]\n\"v(0)\" = \"1 \u00b5m/s\"  # why\na = 1\n[box]\nk = "
      "[1.0,\n  2.0]\n";
  CHECK(
      changed_toml(text, "t", {{"fixed", "v(0)", "2.5"}}) ==
      "# a plan\nmodel = \"m\"  # \u00e4\n[fixed]\n\"v(0)\" = 2.5  # why\na = 1\n[box]\nk = [1.0,\n  2.0]\n");
  CHECK(
      changed_toml(text, "t", {{"box", "k", ""}, {"fixed", "k", "3"}}) ==
      "# a plan\nmodel = \"m\"  # \u00e4\n[fixed]\nk = 3\n\"v(0)\" = \"1 \u00b5m/s\"  # why\na = 1\n[box]\n");
  CHECK(changed_toml(text, "t", {{"time", "end", "5"}}) == text + "\n[time]\nend = 5\n");
  CHECK(changed_toml("[a]", "t", {{"a", "x y", "1"}}) == "[a]\n\"x y\" = 1\n");
  CHECK(changed_toml(text, "t", {{"fixed", "nothing", ""}}) == text);
}

TEST_CASE("a key of a TOML table that only its tables imply gets a head of its own") {
  const std::string box = "a = 1\n[box.C_D]\nrange = [0, 1]\n";
  CHECK(changed_toml(box, "t", {{"box", "v(0)", "[0, 1]"}}) ==
        "a = 1\n[box]\n\"v(0)\" = [0, 1]\n\n[box.C_D]\nrange = [0, 1]\n");
  CHECK(changed_toml(box + "[box]\nk = 1\n", "t", {{"box", "m", "2"}}) == box + "[box]\nm = 2\nk = 1\n");
}

TEST_CASE("a key that does not stand on lines of its own is not changed") {
  for (const char* text : {"fixed = { a = 1 }\n", "fixed.a = 1\n", "fixed = 3\n"}) {
    INFO(text);
    CHECK_THAT(error_text<samara::ArgumentError>([&] {
                 changed_toml(text, "t", {{"fixed", "b", "2"}});
               }),
               Contains("does not stand on a line of its own"));
  }
  CHECK_THROWS_AS(changed_toml("a = ", "t", {{"fixed", "b", "2"}}), samara::InputError);
}
