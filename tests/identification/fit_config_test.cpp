#include "samara/identification/problem/fit_config.h"

#include <filesystem>

#include <catch2/catch.hpp>

#include "files.h"
#include "samara/identification/fit/prediction_config.h"
#include "samara/models/laws/registry.h"

using namespace samara::identification;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using Catch::Matchers::WithinRel;

namespace {

ConfigNames names() {
  return config_names(samara::models::find_model("vertical_fall")->info());
}

std::string config_error(const std::string& text) {
  return error_of<samara::InputError>([&] { parse_fit_config(text, "fit.toml", names()); });
}

}  // namespace

TEST_CASE("the configs of measured sets name what their models have") {
  const std::filesystem::path folder = std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures";
  for (const auto& [file, model] : {std::pair{"april_tag_fit", "immersed_body"},
                                    {"blimp_fit", "coefficient_body"},
                                    {"blimp_predict", "coefficient_body"},
                                    {"falling_paper_fit", "immersed_body"},
                                    {"falling_paper_folds", "immersed_body"},
                                    {"falling_paper_varying", "immersed_body"},
                                    {"settling_pom_fit", "immersed_body"},
                                    {"settling_ptfe_fit", "immersed_body"},
                                    {"table_tennis_fit", "sphere_flight_turned_spin"},
                                    {"table_tennis_predict", "sphere_flight_turned_spin"}}) {
    const auto path = folder / (std::string(file) + ".toml");
    const FitOptions options = read_fit_config(path, config_names(samara::models::find_model(model)->info()));
    CHECK(options.solver.step);
    for (const auto& [name, known] : options.unknowns.known) CHECK(options.unknowns.box.contains(name));
    const PredictionConfig prediction = read_prediction_config(path);
    const bool splits = !prediction.left_out.empty() && options.unknowns.per_capture.empty();
    if (!prediction.folds) CHECK(prediction.fitted.empty() == !splits);
    for (const std::string& name : prediction.hidden) CHECK(options.unknowns.known.contains(name));
  }
  CHECK(read_fit_config(folder / "falling_paper_fit.toml",
                        config_names(samara::models::find_model("immersed_body")->info()))
            .unknowns.known.at("I_z")
            .power == 4.0);
}

TEST_CASE("an empty config leaves every default") {
  const FitOptions options = parse_fit_config("", "fit.toml", names());
  CHECK_FALSE(options.compared.span);
  CHECK(options.loss.kind == LossKind::huber);
  CHECK(options.loss.length_scale == 2e-3);
  CHECK(options.starts.count == 3);
  CHECK_FALSE(options.unknowns.offsets);
}

TEST_CASE("a config sets every option, with units converted") {
  const FitOptions options = parse_fit_config(R"toml(
span = "400 ms"
outputs = ["x"]
loss = { kind = "cauchy", scale = "3 mm" }
shared = ["C_D"]
per_capture = ["v(0)"]
offsets = ["x"]
cluster_by = ["drop"]
starts = 5
max_iterations = 50
segments = { length = "60 ms", stages = [1, 10] }
global = { method = "direct", budget = 40, seed = 7 }
step = "1 ms"
averaged_frames = 5
rounds = 2
bootstrap = { replicates = 50, seed = 3 }
log_scale = ["C_D"]
[initial]
C_D = 1.1
[known]
area = "area_m2"
[priors]
C_D = { mean = 1.1, deviation = 0.2, logarithmic = true }
[periods]
x = "1 cm"
[fixed]
density = "2.7 g/cm^3"
thickness = 0.002
[box]
C_D = [0.6, 2.0]
"v(0)" = ["-40 cm/s", "0.8 m/s"]
)toml",
                                              "fit.toml", names());
  CHECK_THAT(*options.compared.span, WithinRel(0.4, 1e-15));
  CHECK(options.compared.outputs == std::vector<std::string>{"x"});
  CHECK(options.loss.kind == LossKind::cauchy);
  CHECK_THAT(options.loss.length_scale, WithinRel(3e-3, 1e-15));
  CHECK(options.unknowns.shared == std::vector<std::string>{"C_D"});
  CHECK(options.unknowns.per_capture == std::vector<std::string>{"v(0)"});
  CHECK(*options.unknowns.offsets == std::vector<std::string>{"x"});
  CHECK(options.uncertainty.cluster_by == std::vector<std::string>{"drop"});
  CHECK(options.starts.count == 5);
  CHECK_THAT(*options.segments.length, WithinRel(0.06, 1e-15));
  CHECK(options.segments.stages == std::vector<double>{1.0, 10.0});
  CHECK_THAT(*options.solver.step, WithinRel(1e-3, 1e-15));
  CHECK(options.unknowns.log_scale == std::vector<std::string>{"C_D"});
  CHECK(options.starts.global.method == GlobalMethod::direct);
  CHECK(options.starts.global.budget == 40);
  CHECK(options.starts.global.seed == 7);
  CHECK(options.compared.averaged_frames == 5);
  CHECK(options.starts.rounds == 2);
  CHECK(options.uncertainty.bootstrap.replicates == 50);
  CHECK(options.uncertainty.bootstrap.seed == 3);
  CHECK(options.starts.initial.at("C_D") == 1.1);
  CHECK(options.unknowns.known.at("area").label == "area_m2");
  CHECK(options.unknowns.known.at("area").power == 1.0);
  CHECK(options.priors.coordinates.at("C_D").logarithmic);
  CHECK(options.priors.coordinates.at("C_D").deviation == 0.2);
  CHECK_THAT(options.compared.periods.at("x"), WithinRel(0.01, 1e-15));
  CHECK(options.solver.max_iterations == 50);
  CHECK_THAT(options.unknowns.fixed.at("density"), WithinRel(2700.0, 1e-15));
  CHECK(options.unknowns.fixed.at("thickness") == 0.002);
  CHECK(options.unknowns.box.at("C_D").upper == 2.0);
  CHECK_THAT(options.unknowns.box.at("v(0)").lower, WithinRel(-0.4, 1e-15));
}

TEST_CASE("a config of a body with an attitude says how its turns count") {
  const ConfigNames of_body = config_names(samara::models::find_model("immersed_body")->info());
  const auto read = [&](const std::string& text) { return parse_fit_config(text, "fit.toml", of_body); };
  const FitOptions options = read("round_body = true\nattitude_scale = \"2 deg\"");
  CHECK(options.starts.round_body);
  CHECK_THAT(options.loss.attitude_scale, WithinRel(2.0 * M_PI / 180.0, 1e-15));
  CHECK_NOTHROW(read("outputs = [\"x\", \"qw\", \"qx\", \"qy\", \"qz\"]\nattitude_scale = 0.01"));
  CHECK(error_of<samara::InputError>([&] { read("outputs = [\"x\", \"y\"]\nattitude_scale = 0.01"); }) ==
        "fit.toml:2: attitude_scale: the attitude is not among the compared outputs (x, y)");
  // Turns that are not measured, of a body that is round.
  CHECK(read("outputs = [\"x\", \"y\"]\nround_body = true").starts.round_body);
}

TEST_CASE("keys that would change nothing are refused where they stand") {
  CHECK(config_error("rounds = 5") == "fit.toml:1: rounds: belongs to `segments`, which is not there");
  CHECK(parse_fit_config("rounds = 1", "fit.toml", names()).starts.rounds == 1);
  CHECK(parse_fit_config("rounds = 2\n[series]\nspan = \"1 s\"", "fit.toml", names()).starts.rounds == 2);
  for (const std::string key : {"round_body = true", "attitude_scale = \"1 deg\""}) {
    CHECK_THAT(config_error("\n" + key), StartsWith("fit.toml:2: " + key.substr(0, key.find(' '))) &&
                                             Contains("belongs to an attitude (qw, qx, qy, qz)"));
  }
  CHECK_FALSE(parse_fit_config("round_body = false", "fit.toml", names()).starts.round_body);
  const std::string scale = "loss = { scale = { v = \"5 mm/s\" } }\n", period = "[periods]\nv = 1\n";
  CHECK_THAT(config_error("outputs = [\"x\"]\n" + scale),
             StartsWith("fit.toml:2: ") && Contains("v: is not among the compared outputs (x)"));
  // Of an output that some captures lack, too, and of what a prediction is scored by.
  CHECK_NOTHROW(parse_fit_config(scale + period, "fit.toml", names()));
  CHECK_NOTHROW(parse_fit_config("outputs = [\"x\"]\n" + period, "fit.toml", names()));
}

TEST_CASE("a span may go by its former name, window, but not by both") {
  CHECK(parse_fit_config("window = \"0.4 s\"", "fit.toml", names()).compared.span == 0.4);
  CHECK_THAT(config_error("span = \"0.4 s\"\nwindow = \"0.4 s\""),
             StartsWith("fit.toml:2: window: ") && Contains("one of the two"));
  CHECK_THAT(config_error("window = 0"), StartsWith("fit.toml:1: window: ") && Contains("more than 0"));
}

TEST_CASE("loss scales may be given output by output") {
  const FitOptions options =
      parse_fit_config("loss = { scale = { v = \"5 mm/s\", x = 0.001 } }", "fit.toml", names());
  CHECK_THAT(options.loss.scales.at("v"), WithinRel(5e-3, 1e-15));
  CHECK(options.loss.scales.at("x") == 1e-3);
  CHECK(options.loss.kind == LossKind::huber);
}

TEST_CASE("whatever a config gets wrong is named with its line") {
  CHECK_THAT(config_error("spann = \"1 s\""),
             StartsWith("fit.toml:1: ") && Contains("did you mean \"span\"?"));
  CHECK_THAT(config_error("span = \"1 m\""), StartsWith("fit.toml:1: span: "));
  CHECK_THAT(config_error("\nspan = 0"), StartsWith("fit.toml:2: span: ") && Contains("more than 0"));
  CHECK_THAT(config_error("outputs = [\"y\"]"), Contains("unknown name \"y\""));
  CHECK_THAT(config_error("shared = [\"C_d\"]"), Contains("did you mean \"C_D\"?"));
  CHECK_THAT(config_error("loss = { kind = \"hubert\" }"), Contains("did you mean \"huber\"?"));
  CHECK_THAT(config_error("loss = { kinds = \"huber\" }"), Contains("did you mean \"kind\"?"));
  CHECK_THAT(config_error("loss = { scale = \"2 s\" }"), StartsWith("fit.toml:1: [loss] scale: "));
  CHECK_THAT(config_error("loss = { scale = { y = \"2 m\" } }"), Contains("unknown key"));
  CHECK_THAT(config_error("starts = 0"), Contains("more than 0"));
  CHECK_THAT(config_error("starts = 2.5"), Contains("starts"));
  CHECK_THAT(config_error("[fixed]\narae = 1"),
             StartsWith("fit.toml:2: [fixed] arae: ") && Contains("\"area\""));
  CHECK_THAT(config_error("[fixed]\narea = \"1 m\""), StartsWith("fit.toml:2: [fixed] area: "));
  CHECK_THAT(config_error("[box]\nC_D = [2.0, 1.0]"),
             StartsWith("fit.toml:2: [box] C_D: ") && Contains("lower < upper"));
  CHECK_THAT(config_error("[box]\nC_D = [1.0]"), Contains("lower < upper"));
}

TEST_CASE("options of segments and priors outside their meaning are refused with the line") {
  CHECK_THAT(config_error("segments = \"0 s\"\n"), StartsWith("fit.toml:1: "));
  CHECK_THAT(config_error("segments = { length = \"1 s\", stages = [] }\n"), Contains("the list is empty"));
  CHECK_THAT(config_error("segments = { length = \"1 s\", stages = [1, -2] }\n"), Contains("-2"));
  CHECK_THAT(config_error("bootstrap = 0\n"), StartsWith("fit.toml:1: ") && Contains("more than 0"));
  for (const char* one : {"bootstrap = 1", "bootstrap = { replicates = 1 }"})
    CHECK_THAT(config_error(one), StartsWith("fit.toml:1: ") && Contains("is 1; 2 or more was expected"));
  CHECK_THAT(config_error("global = \"anneal\"\n"), Contains("no global search \"anneal\""));
  CHECK_THAT(config_error("step = \"1 m\"\n"), StartsWith("fit.toml:1: "));
  CHECK_THAT(config_error("[priors]\nC_D = { mean = 1, deviation = 0 }\n"), StartsWith("fit.toml:2: "));
  CHECK_THAT(config_error("[priors]\nC_D = { mean = -1, deviation = 1, logarithmic = true }\n"),
             Contains("more than 0"));
  CHECK_THAT(config_error("[periods]\nx = -1\n"), StartsWith("fit.toml:2: "));
  CHECK_THAT(config_error("[periods]\nx = 1e-300\n"),
             StartsWith("fit.toml:2: [periods] x: has the number 1e-300, expected at least 1e-60"));
  CHECK_THAT(
      config_error("segments = { length = \"1 s\", stages = [1, 1e300] }\n"),
      StartsWith("fit.toml:1: [segments] stages: element 1: has the number 1e+300, expected at most 1e+60"));
  CHECK_THAT(config_error("[known]\nthicknes = \"t\"\n"), Contains("thickness"));
}

TEST_CASE(
    "periods and weights of segments beyond what can be calculated with are refused in a program, too") {
  FitOptions options;
  for (const double period : {0.0, 0.01, 1e-60, 1e60}) {
    options.compared.periods = {{"x", period}};
    CHECK_NOTHROW(validate(options));
  }
  for (const double period : {-1.0, 1e-300, 1e300}) {
    options.compared.periods = {{"x", period}};
    CHECK_THROWS_WITH(validate(options), Contains("the period of \"x\" is"));
  }
  options.compared.periods = {};
  options.segments.stages = {1.0, 1e300};
  CHECK_THROWS_WITH(validate(options), Contains("segments.stages is 1e+300; 1e-60 to 1e+60 was expected"));
}

TEST_CASE("a config says where a delay lies, and what is known of it") {
  const FitOptions options = parse_fit_config(
      "shared = [\"delay\"]\n"
      "delay = { range = [\"-20 ms\", \"20 ms\"] }\n"
      "[priors]\n"
      "delay = { mean = \"2 ms\", deviation = \"5 ms\" }\n"
      "[initial]\n"
      "delay = \"1 ms\"\n",
      "fit.toml", names());
  REQUIRE(options.measurement.delay.has_value());
  CHECK(options.measurement.delay->lower == -0.02);
  CHECK(options.measurement.delay->upper == 0.02);
  CHECK(options.priors.coordinates.at("delay").deviation == 0.005);
  CHECK(options.starts.initial.at("delay") == 0.001);
  CHECK_THAT(config_error("delay = { range = [\"20 ms\", \"-20 ms\"] }"),
             Contains("[lower, upper] with lower < upper"));
  CHECK_THAT(config_error("delay = { range = [nan, 0.1] }"), Contains("fit.toml:1"));
  CHECK_THAT(config_error("delay = { range = [\"1 m\", \"2 m\"] }"), Contains("range"));
  CHECK_THAT(config_error("delay = { width = \"20 ms\" }"), Contains("width"));
  CHECK_THAT(config_error("shared = [\"delay\"]"), Contains("unknown name \"delay\""));
  CHECK_THAT(config_error("delay = { range = [0, 0.1] }\n[box]\ndelay = [0, 0.2]"), Contains("delay"));
}

TEST_CASE("lists that add to what is so by default are not empty, and no offsets are none") {
  CHECK_THAT(config_error("shared = []"), StartsWith("fit.toml:1") && Contains("shared: the list is empty") &&
                                              Contains("unless per_capture names them"));
  CHECK_THAT(config_error("per_capture = []"),
             Contains("per_capture: the list is empty") && Contains("unless shared names them"));
  CHECK(parse_fit_config("offsets = []", "fit.toml", names()).unknowns.offsets->empty());
}
