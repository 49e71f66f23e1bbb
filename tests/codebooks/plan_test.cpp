#include "samara/codebooks/plan/plan.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "../error_text.h"
#include "../io/temporary_directory.h"
#include "samara/codebooks/plan/plan_changes.h"
#include "samara/codebooks/plan/plan_template.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/laws/registry.h"

using namespace samara::codebooks;
using Catch::Matchers::Contains;
using Catch::Matchers::EndsWith;
using Catch::Matchers::StartsWith;
using Catch::Matchers::WithinRel;
using samara::InputError;

namespace {

const std::string kPlan = R"toml(model = "vertical_fall"
title = "a coin in water"

[fixed]
density = "6.339 g/cm^3"
thickness = "2.55 mm"
g = 9.81
"x(0)" = "-5 cm"

[box]
C_D = [0.8, 1.6]
area = { range = ["4.5 cm^2", 4.9e-4], nodes = 9 }
"v(0)" = ["0 m/s", "30 cm/s"]

[time]
end = "500 ms"

[tolerance]
relative = 1e-4
absolute = { x = "1 um", v = 1e-5 }

[builder]
kind = "pgd"
strategy = "newton"
max_calls = 100000
threads = 2
seed = 7
)toml";

Plan parsed(const std::string& text) {
  return parse_plan(text, "p.toml");
}

/// The plan above with one text put in place of another.
std::string changed(const std::string& from, const std::string& to) {
  std::string text = kPlan;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// What is wrong with a plan: one sentence, or the test fails.
std::string refusal(const std::string& text) {
  const std::string error = error_text<InputError>([&] { parsed(text); });
  INFO(error);
  CHECK(error.find('\n') == std::string::npos);
  CHECK(error.back() != '.');
  return error;
}

std::string refusal(const std::string& from, const std::string& to) {
  return refusal(changed(from, to));
}

}  // namespace

TEST_CASE("a tolerance that no integrator can certify is refused") {
  CHECK_THAT(
      refusal("relative = 1e-4", "relative = 9e-11"),
      Contains("relative: is 9e-11, expected at least 1e-10, which is what the integrator can certify"));
  CHECK(parsed(changed("relative = 1e-4", "relative = 1e-10")).relative == 1e-10);
}

TEST_CASE("an interval too narrow for nodes is refused") {
  CHECK_THAT(refusal("C_D = [0.8, 1.6]", "C_D = [1.0, 1.0000000000000004]"),
             StartsWith("p.toml:11: [box] C_D: is the interval [1, 1.0000000000000004], expected a width"));
  CHECK(parsed(changed("C_D = [0.8, 1.6]", "C_D = [1.0, 1.00000001]")).box[0].lower == 1.0);
}

TEST_CASE("a title with control characters is refused where it stands") {
  for (const std::string bad : {"\\u0000", "\\u001b[31m", "\\n", "\\u007F"}) {
    CHECK_THAT(refusal("a coin in water", "a coin" + bad),
               StartsWith("p.toml:2: title: has the control character"));
  }
  CHECK(parsed(changed("a coin in water", "d\xC3\xA9j\xC3\xA0 vu")).title == "d\xC3\xA9j\xC3\xA0 vu");
}

TEST_CASE("a plan is read whole: SI numbers, strings with units, ranges with nodes") {
  const Plan plan = parsed(kPlan);
  CHECK(plan.model == "vertical_fall");
  CHECK(plan.title == "a coin in water");
  CHECK(plan.fixed.size() == 4);
  CHECK_THAT(plan.fixed.at("density"), WithinRel(6339.0, 1e-15));
  CHECK_THAT(plan.fixed.at("thickness"), WithinRel(2.55e-3, 1e-15));
  CHECK(plan.fixed.at("g") == 9.81);
  CHECK(plan.fixed.at("x(0)") == -0.05);
  REQUIRE(plan.box.size() == 3);
  CHECK(plan.box[0].name == "C_D");
  CHECK(plan.box[0].lower == 0.8);
  CHECK(plan.box[0].upper == 1.6);
  CHECK_FALSE(plan.box[0].nodes);
  CHECK(plan.box[1].name == "area");
  CHECK_THAT(plan.box[1].lower, WithinRel(4.5e-4, 1e-15));
  CHECK(plan.box[1].upper == 4.9e-4);
  CHECK(plan.box[1].nodes == 9);
  CHECK(plan.box[2].name == "v(0)");
  CHECK(plan.box[2].lower == 0.0);
  CHECK(plan.box[2].upper == 0.3);
  CHECK(plan.end == 0.5);
  CHECK(plan.relative == 1e-4);
  CHECK(plan.absolute.size() == 2);
  CHECK_THAT(plan.absolute.at("x"), WithinRel(1e-6, 1e-15));
  CHECK(plan.absolute.at("v") == 1e-5);
  CHECK(plan.builder.kind == "pgd");
  CHECK(plan.builder.strategy == "newton");
  CHECK(plan.builder.max_calls == 100000);
  CHECK(plan.builder.threads == 2);
  CHECK(plan.builder.seed == 7);
  CHECK(plan.source == "p.toml");
  CHECK(plan.text == kPlan);
}

TEST_CASE("the model of a plan has the box free in the order of the file") {
  const samara::models::ParametricModel model = parsed(kPlan).parametric_model();
  REQUIRE(model.free_count() == 3);
  CHECK(model.free()[0].name == "C_D");
  CHECK(model.free()[1].name == "area");
  CHECK(model.free()[2].name == "v(0)");
  CHECK(model.fixed().size() == 4);
}

TEST_CASE("what a plan leaves out has its default") {
  const Plan plan = parsed("model = 'constant_rate'\nbox.k = [1, 5]\ntime.end = 1\n");
  CHECK(plan.title.empty());
  CHECK(plan.fixed.empty());
  CHECK(plan.box.size() == 1);
  CHECK(plan.relative == 1e-3);
  CHECK(plan.absolute.empty());
  CHECK(plan.builder.kind == "auto");
  CHECK(plan.builder.strategy == "auto");
  CHECK(plan.builder.max_calls == 0);
  CHECK(plan.builder.threads == 0);
  CHECK(plan.builder.seed == 1);
}

TEST_CASE("a plan read from a file keeps its text to the last byte") {
  const TemporaryDirectory directory;
  const std::string text = "# caf\xC3\xA9\r\n" + kPlan;
  put_content(directory / "coin.toml", text);
  const Plan plan = read_plan(directory / "coin.toml");
  CHECK(plan.text == text);
  CHECK(plan.source == (directory / "coin.toml").string());
  CHECK(plan.end == 0.5);
  put_content(directory / "bad.toml", changed("[0.8, 1.6]", "[1.6, 0.8]"));
  CHECK_THAT(error_text<InputError>([&] { read_plan(directory / "bad.toml"); }),
             StartsWith((directory / "bad.toml").string() + ":11: "));
}

TEST_CASE("a plan that cannot be read as TOML is refused with its place") {
  const TemporaryDirectory directory;
  CHECK_THAT(error_text<InputError>([&] { read_plan(directory / "none.toml"); }),
             Contains("none.toml: the file does not exist"));
  CHECK_THAT(error_text<InputError>([&] { read_plan(directory.path()); }), Contains("is a directory"));
  CHECK_THAT(refusal("end = \"500 ms\"", "end = "), StartsWith("p.toml:16: not valid TOML: "));
  CHECK_THAT(refusal("[time]", "[time"), StartsWith("p.toml:15: not valid TOML: "));
}

TEST_CASE("an unknown key is refused with its line and the nearest known one") {
  CHECK(refusal("title =", "titel =") == "p.toml:2: titel: unknown key; did you mean \"title\"?");
  CHECK(refusal("[tolerance]", "[tolerence]") ==
        "p.toml:18: tolerence: unknown key; did you mean \"tolerance\"?");
  CHECK(refusal("end =", "End =") == "p.toml:16: [time] End: unknown key; did you mean \"end\"?");
  CHECK(refusal("relative", "relativ") ==
        "p.toml:19: [tolerance] relativ: unknown key; did you mean \"relative\"?");
  CHECK(refusal("threads", "treads") ==
        "p.toml:26: [builder] treads: unknown key; did you mean \"threads\"?");
  CHECK(refusal("nodes", "node") == "p.toml:12: [box.area] node: unknown key; did you mean \"nodes\"?");
}

TEST_CASE("a model that does not exist is refused with the nearest one") {
  CHECK_THAT(refusal("vertical_fall", "vertical_fal"),
             StartsWith("p.toml:1: model: ") && EndsWith("did you mean \"vertical_fall\"?"));
  CHECK_THAT(refusal("\"vertical_fall\"", "3"), StartsWith("p.toml:1: model: expected a string"));
  CHECK(refusal("model =", "#") == "p.toml: model: the key is missing");
}

TEST_CASE("a parameter that the model does not have is refused with the nearest one") {
  CHECK(refusal("density =", "densitty =") ==
        "p.toml:5: [fixed] densitty: the model \"vertical_fall\" has no parameter or initial value of this "
        "name; did you mean \"density\"?");
  CHECK_THAT(refusal("\"v(0)\" =", "\"v(1)\" ="),
             StartsWith("p.toml:13: [box] \"v(1)\": ") && EndsWith("did you mean \"v(0)\"?"));
  // One of another model.
  CHECK_THAT(refusal("thickness =", "mass ="),
             StartsWith("p.toml:6: [fixed] mass: ") && Contains("\"vertical_fall\" has no parameter"));
  // A state is no parameter; its initial value is.
  CHECK_THAT(refusal("\"v(0)\" =", "v ="), StartsWith("p.toml:13: [box] v: "));
  // Tolerances belong to states.
  CHECK_THAT(refusal("{ x = ", "{ y = "),
             StartsWith("p.toml:20: [tolerance.absolute] y: the model \"vertical_fall\" has no state"));
}

TEST_CASE("an interval must have two ends in ascending order") {
  CHECK(refusal("[0.8, 1.6]", "[1.6, 0.8]") ==
        "p.toml:11: [box] C_D: is the interval [1.6, 0.8], expected lower < upper");
  CHECK_THAT(refusal("[0.8, 1.6]", "[0.8, 0.8]"),
             StartsWith("p.toml:11: [box] C_D: is the interval [0.8, 0.8]"));
  CHECK_THAT(refusal("[0.8, 1.6]", "[0.8]"), StartsWith("p.toml:11: [box] C_D: has 1 numbers"));
  CHECK_THAT(refusal("[0.8, 1.6]", "[]"), StartsWith("p.toml:11: [box] C_D: has 0 numbers"));
  CHECK_THAT(refusal("[0.8, 1.6]", "[0.8, 1.2, 1.6]"), StartsWith("p.toml:11: [box] C_D: has 3 numbers"));
  CHECK_THAT(refusal("[0.8, 1.6]", "0.8"), StartsWith("p.toml:11: [box] C_D: expected an array"));
  CHECK_THAT(refusal("[\"4.5 cm^2\", 4.9e-4]", "[\"4.5 m^2\", 4.9e-4]"),
             StartsWith("p.toml:12: [box] area: is the interval [4.5, 0.00049]"));
  CHECK_THAT(refusal("range = [\"4.5 cm^2\", 4.9e-4], ", ""),
             StartsWith("p.toml:12: [box.area] range: the key is missing"));
}

TEST_CASE("the nodes of an axis are 2 to 2000") {
  for (const char* bad : {"nodes = 1", "nodes = 0", "nodes = -3", "nodes = 2001"}) {
    CHECK_THAT(refusal("nodes = 9", bad),
               StartsWith("p.toml:12: [box.area] nodes: is ") && EndsWith("2 to 2000"));
  }
  CHECK_THAT(refusal("nodes = 9", "nodes = 9.0"), Contains("expected an integer"));
  CHECK(parsed(changed("nodes = 9", "nodes = 2")).box[1].nodes == 2);
}

TEST_CASE("a plan may name the basis and the transform of an axis") {
  using samara::pgd::Basis;
  using samara::pgd::Transform;
  CHECK(parsed(kPlan).box[1].basis == Basis::chebyshev);
  CHECK(parsed(kPlan).box[1].transform == Transform::none);
  const BoxEntry entry = parsed(changed("nodes = 9", "basis = 'legendre', transform = 'log'")).box[1];
  CHECK(entry.basis == Basis::legendre);
  CHECK(entry.transform == Transform::logarithm);
  CHECK_FALSE(entry.nodes);
  CHECK(parsed(changed("nodes = 9", "nodes = 9, basis = 'p2'")).box[1].basis == Basis::p2);
  CHECK(parsed(changed("nodes = 9", "basis = 'fourier'")).box[1].basis == Basis::fourier);
}

TEST_CASE("a basis or transform that an axis cannot have is refused at its line") {
  const auto with = [](const std::string& keys) { return refusal("nodes = 9", keys); };
  CHECK_THAT(with("basis = 'radau'"), StartsWith("p.toml:12: [box.area] basis: is \"radau\""));
  CHECK_THAT(with("basis = 'legender'"), EndsWith("did you mean \"legendre\"?"));
  CHECK_THAT(with("basis = 'p1'"), EndsWith("expected a key nodes beside it"));
  CHECK_THAT(with("nodes = 8, basis = 'fourier'"),
             EndsWith("expected an odd number of nodes on a fourier axis"));
  CHECK_THAT(with("basis = 'fourier', transform = 'log'"), EndsWith("which a fourier axis cannot have"));
  CHECK_THAT(with("transform = 'logarithm'"),
             StartsWith("p.toml:12: [box.area] transform: is \"logarithm\""));
  const std::string model = "model = 'constant_rate'\ntime.end = 1\n[box]\n";
  CHECK_THAT(refusal(model + "k = { range = [0, 5], transform = 'log' }\n"),
             EndsWith("is \"log\", which is not defined at the lower end 0"));
}

TEST_CASE("numbers that are not finite are refused wherever they stand") {
  for (const std::string bad : {"nan", "inf", "-inf", "+nan"}) {
    CHECK_THAT(refusal("g = 9.81", "g = " + bad),
               StartsWith("p.toml:7: [fixed] g: expected a finite number"));
    CHECK_THAT(refusal("1.6]", bad + "]"), StartsWith("p.toml:11: [box] C_D: element 1: expected a finite"));
    CHECK_THAT(refusal("end = \"500 ms\"", "end = " + bad),
               StartsWith("p.toml:16: [time] end: expected a finite"));
    CHECK_THAT(refusal("relative = 1e-4", "relative = " + bad),
               StartsWith("p.toml:19: [tolerance] relative: expected a finite number"));
    CHECK_THAT(refusal("v = 1e-5", "v = " + bad),
               StartsWith("p.toml:20: [tolerance.absolute] v: expected a finite number"));
  }
  CHECK_THAT(refusal("\"2.55 mm\"", "\"nan mm\""), StartsWith("p.toml:6: [fixed] thickness: "));
  CHECK_THAT(refusal("\"500 ms\"", "\"1e999 ms\""), StartsWith("p.toml:16: [time] end: "));
}

TEST_CASE("a unit of the wrong dimension, or none known, is refused") {
  CHECK_THAT(refusal("\"2.55 mm\"", "\"2.55 kg\""),
             StartsWith("p.toml:6: [fixed] thickness: \"2.55 kg\" has the dimension kg"));
  CHECK_THAT(refusal("\"30 cm/s\"", "\"30 cm\""), StartsWith("p.toml:13: [box] \"v(0)\": element 1: "));
  CHECK_THAT(refusal("\"500 ms\"", "\"500 m\""), StartsWith("p.toml:16: [time] end: "));
  CHECK_THAT(refusal("\"1 um\"", "\"1 ux\""),
             StartsWith("p.toml:20: [tolerance.absolute] x: ") && Contains("ux"));
  // The time of a dimensionless model has no unit either.
  const std::string rate = "model = 'constant_rate'\nbox.k = [1, 5]\ntime.end = ";
  CHECK_THAT(refusal(rate + "'1 s'"), StartsWith("p.toml:3: [time] end: "));
  CHECK(parsed(rate + "1").end == 1.0);
}

TEST_CASE("a name is fixed or free, not both") {
  CHECK(refusal("g = 9.81", "C_D = 1.0") ==
        "p.toml:11: [box] C_D: is fixed in [fixed] and free in [box], expected one of them");
}

TEST_CASE("a required parameter that is neither fixed nor free is named") {
  CHECK_THAT(refusal("thickness = \"2.55 mm\"", ""),
             StartsWith("p.toml:1: ") && Contains("needs \"thickness\" (m), expected in [fixed] or [box]"));
  CHECK_THAT(refusal("density = \"6.339 g/cm^3\"\nthickness = \"2.55 mm\"", ""),
             Contains("\"density\" (kg/m^3)") && Contains("\"thickness\" (m)"));
}

TEST_CASE("a plan needs a box with something in it, and an end") {
  const std::string model = "model = 'constant_rate'\n";
  CHECK(refusal(model + "[time]\nend = 1\n") == "p.toml: box: the key is missing");
  CHECK(refusal(model + "[box]\n[time]\nend = 1\n") ==
        "p.toml:2: box: is empty, expected at least one free parameter or initial value");
  CHECK_THAT(refusal(model + "box = 3\n"), StartsWith("p.toml:2: box: expected a table"));
  CHECK(refusal(model + "[box]\nk = [1, 5]\n") == "p.toml: time: the key is missing");
  CHECK_THAT(refusal(model + "[box]\nk = [1, 5]\n[time]\n"),
             StartsWith("p.toml:4: [time] end: the key is missing"));
}

TEST_CASE("the end of the time is positive") {
  CHECK(refusal("\"500 ms\"", "0") == "p.toml:16: [time] end: is 0, expected more than 0");
  CHECK_THAT(refusal("\"500 ms\"", "\"-1 s\""), StartsWith("p.toml:16: [time] end: is -1"));
}

TEST_CASE("a value outside the meaning of its parameter is refused at its line") {
  // Fixed ones.
  CHECK(refusal("\"2.55 mm\"", "0.0") == "p.toml:6: [fixed] thickness: is 0, expected more than 0");
  CHECK(refusal("g = 9.81", "g = -9.81") == "p.toml:7: [fixed] g: is -9.81, expected at least 0");
  // Corners of the box.
  CHECK(refusal("[0.8, 1.6]", "[-0.1, 1.6]") == "p.toml:11: [box] C_D: is -0.1, expected at least 0");
  CHECK(refusal("[\"4.5 cm^2\", 4.9e-4]", "[0, 4.9e-4]") ==
        "p.toml:12: [box] area: is 0, expected more than 0");
  CHECK(refusal("model = \"immersed_body\"\n[box]\nkappa = [0.5, 1.5]\n") ==
        "p.toml:3: [box] kappa: is 1.5, expected at most 1");
  // The model itself refuses a corner, not the middle.
  CHECK_THAT(
      refusal("model = \"falling_rectangle\"\n[fixed]\nchord = 0.02\nthickness = 0.002\ndensity = 2000\n"
              "[box]\noffset = [0, 0.011]\n[time]\nend = 1\n"),
      Contains("offset is 0.011 m"));
  // The border of the meaning of C_D belongs to it; initial values mean something everywhere.
  CHECK(parsed(changed("[0.8, 1.6]", "[0, 1.6]")).box[0].lower == 0.0);
  CHECK(parsed(changed("\"0 m/s\"", "\"-3 m/s\"")).box[2].lower == -3.0);
}

TEST_CASE("tolerances are between 0 and 1, floors are not negative") {
  for (const std::string bad : {"0", "0.0", "-1e-3", "1", "1.0", "2"}) {
    CHECK_THAT(refusal("relative = 1e-4", "relative = " + bad),
               StartsWith("p.toml:19: [tolerance] relative: is ") && EndsWith("more than 0 and less than 1"));
  }
  CHECK(refusal("v = 1e-5", "v = -1e-5") ==
        "p.toml:20: [tolerance.absolute] v: is -1e-05, expected at least 0");
  CHECK(parsed(changed("v = 1e-5", "v = 0")).absolute.at("v") == 0.0);
}

TEST_CASE("builders, strategies and numbers of the builder are checked") {
  CHECK_THAT(refusal("kind = \"pgd\"", "kind = \"dmrg\""),
             StartsWith("p.toml:23: [builder] kind: is \"dmrg\"") && EndsWith("known: auto, pgd, sampling"));
  CHECK_THAT(refusal("\"newton\"", "\"newtn\""), StartsWith("p.toml:24: [builder] strategy: is \"newtn\"") &&
                                                     EndsWith("did you mean \"newton\"?"));
  CHECK_THAT(refusal("\"newton\"", "\"picard\""),
             EndsWith("known: auto, newton, steps, slabs, asymptotic, cross, decoupling, empirical, "
                      "enrichment, incremental, "
                      "piecewise_linear, polynomial"));
  CHECK_THAT(refusal("max_calls = 100000", "max_calls = -1"),
             StartsWith("p.toml:25: [builder] max_calls: is -1"));
  CHECK_THAT(refusal("threads = 2", "threads = -1"), StartsWith("p.toml:26: [builder] threads: is -1"));
  CHECK_THAT(refusal("threads = 2", "threads = 2.5"), Contains("expected an integer"));
  CHECK_THAT(refusal("seed = 7", "seed = -7"), StartsWith("p.toml:27: [builder] seed: is -7"));
}

TEST_CASE("what is set in place of a plan makes a plan that says it, and can be built again") {
  PlanChanges changes{
      .coordinates = {{"C_D", "1.1", ""}, {"density", "2.7 g/cm^3", "7000"}, {"area", "4.6 cm^2", "4.8e-4"}},
      .relative = 1e-5,
      .threads = 1};
  const Plan plan = changed_plan(kPlan, "p.toml", changes);
  CHECK(plan.fixed.at("C_D") == 1.1);
  CHECK_FALSE(plan.fixed.contains("density"));
  REQUIRE(plan.box.size() == 3);
  const auto entry = [&](const std::string& name) {
    return *std::ranges::find(plan.box, name, &BoxEntry::name);
  };
  CHECK(entry("density").lower == 2700.0);
  CHECK(entry("density").upper == 7000.0);
  CHECK(entry("area").upper == 4.8e-4);
  CHECK(entry("area").nodes == 9);  // what else is said of an axis stays
  CHECK(plan.relative == 1e-5);
  CHECK(plan.builder.threads == 1);
  CHECK(plan.builder.seed == 7);
  CHECK(parsed(plan.text).whole_text() == plan.whole_text());
  CHECK(changed_plan(kPlan, "p.toml", {}).text == kPlan);
}

TEST_CASE("what is set in place of a plan is checked as the plan is") {
  const auto error = [](const PlanChanges& changes) {
    return error_text<samara::ArgumentError>([&] { changed_plan(kPlan, "p.toml", changes); });
  };
  CHECK_THAT(error({.coordinates = {{"C_D", "2", "1"}}}), Contains("C_D") && Contains("lower < upper"));
  CHECK_THAT(error({.coordinates = {{"C_D", "-1", ""}}}), Contains("C_D"));
  CHECK_THAT(error({.coordinates = {{"C_D", "1 m", ""}}}), Contains("dimension"));
  CHECK_THAT(error({.coordinates = {{"C_T", "1", ""}}}), Contains("C_T"));
  CHECK_THAT(error({.relative = 2.0}), Contains("relative"));
  CHECK_THAT(error({.coordinates = {{"C_D", "1", ""}, {"area", "1 cm^2", ""}, {"v(0)", "0", ""}}}),
             Contains("box"));
}

TEST_CASE("the plan to begin with is a plan, for every model") {
  for (const std::string& name : samara::models::model_names()) {
    INFO(name);
    const Plan plan = parsed(plan_template(*samara::models::find_model(name), name));
    CHECK(plan.model == name);
    CHECK(plan.box.size() == 1);
  }
  for (const std::string& name : samara::models::field_model_names())
    CHECK(parsed(plan_template(*samara::models::find_field_model(name))).field != nullptr);
}

TEST_CASE("the plan to begin with ends before its solutions do, and its field is not zero everywhere") {
  // From rest the coupled products with c1 = 0.9 blow up at t = 1.44.
  const Plan plan = parsed(plan_template(*samara::models::find_model("coupled_triple"), "coupled_triple"));
  CHECK(plan.end == 1.0);
  CHECK(parsed(plan_template(*samara::models::find_model("constant_rate"), "constant_rate")).end == 2.0);
  CHECK(parsed(plan_template(*samara::models::find_field_model("heat_rod"))).fixed.at("amplitude") > 0.0);
}
