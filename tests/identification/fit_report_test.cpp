#include "samara/identification/report/fit_report.h"

#include <limits>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "files.h"
#include "samara/identification/fit/fit.h"
#include "samara/identification/report/read_fit.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

FitResult example() {
  std::mt19937_64 random(2);
  std::vector<Capture> captures;
  for (int c = 0; c < 3; ++c) {
    captures.push_back(coin_capture(fmt::format("coin {}", c), 1.15, 0.05 * c, 0.1));
    captures.back().labels = {{"drop", fmt::format("{}", c)}};
    add_noise(captures.back(), 5e-4, random);
  }
  captures[0].channels.push_back({"v", "m/s", Eigen::VectorXd::Constant(25, std::nan(""))});
  return fit(*coin_family(), captures);
}

}  // namespace

TEST_CASE("coefficients are read from the JSON of a fit to the last bit") {
  const TemporaryDirectory files;
  FitResult result = example();
  result.captures[0].file = "coins.csv";
  result.noise = {{.outputs = {"x"}, .unit = "m", .value = 4e-4, .estimated = true}};
  const FitResult read = read_fit(files.put("fit.json", fit_json(result)));
  CHECK(read.status == samara::Termination::converged);
  CHECK(read.model == "vertical_fall");
  REQUIRE(read.coefficients.size() == 1);
  CHECK(read.coefficients[0].name == "C_D");
  CHECK(read.coefficients[0].value == result.coefficients[0].value);
  CHECK(read.coefficients[0].standard_error == result.coefficients[0].standard_error);
  REQUIRE(read.captures.size() == 3);
  CHECK(read.captures[0].file == "coins.csv");
  CHECK(read.captures[2].whole == "coin 2");
  CHECK(read.noise.at(0).value == 4e-4);
  for (const char* text :
       {"", "{}", "[1, 2]", "{\"schema\": \"samara-fit/1\"}", "{\"schema\": 7}", "no JSON"}) {
    CHECK_THAT(error_of<samara::InputError>([&] { read_fit(files.put("other.json", text)); }),
               Contains("other.json") && Contains("the JSON of a fit"));
  }
  CHECK_THAT(error_of<samara::InputError>(
                 [&] { read_fit(files.put("other.json", "{\"schema\": \"samara-series/1\"}")); }),
             Contains("its schema is \"samara-series/1\""));
}

TEST_CASE("the status is read from the JSON of a fit, also in the words of older files") {
  const TemporaryDirectory files;
  nlohmann::json json = nlohmann::json::parse(fit_json(example()));
  const auto status_of = [&](const char* word) {
    json["status"] = word;
    return read_fit(files.put("fit.json", json.dump())).status;
  };
  CHECK(status_of("not_determined") == samara::Termination::not_determined);
  CHECK(status_of("max_iterations") == samara::Termination::max_iterations);
  CHECK(status_of("failed") == samara::Termination::failed);
  CHECK(status_of("not determined") == samara::Termination::not_determined);
  CHECK(status_of("iteration limit") == samara::Termination::max_iterations);
}

TEST_CASE("how captures were seen is read from the JSON of a fit, or told from its captures") {
  const TemporaryDirectory files;
  FitResult result = example();
  result.setup.camera = {.scale = 0.02, .axes = {"x"}};
  result.setup.priors.coordinates["v(0)"] = {.mean = 0.1, .deviation = 0.05};
  result.setup.unknowns.known.emplace("C_m", "C_m");
  result.setup.compared.periods["x"] = 0.5;
  result.captures[1].start = 0.25;
  const FitResult read = read_fit(files.put("fit.json", fit_json(result)));
  CHECK(read.setup.compared.periods == result.setup.compared.periods);
  CHECK(read.captures[1].start == 0.25);
  CHECK(read.setup.compared.outputs == std::vector<std::string>{"x"});
  CHECK(read.setup.unknowns.shared == std::vector<std::string>{"C_D"});
  CHECK(read.setup.unknowns.per_capture == std::vector<std::string>{"v(0)"});
  CHECK(read.setup.unknowns.offsets == std::vector<std::string>{"x"});
  CHECK(read.setup.unknowns.known.at("C_m").label == "C_m");
  CHECK(read.setup.unknowns.box.at("v(0)").upper == 0.8);
  CHECK(read.setup.priors.coordinates.at("v(0)").deviation == 0.05);
  CHECK(read.setup.camera.scale == 0.02);
  CHECK_FALSE(read.setup.camera.rotation);
  CHECK(read.setup.camera.axes == std::vector<std::string>{"x"});
  CHECK(read.naive_covariance == result.naive_covariance);
  CHECK(read.captures[1].times == result.captures[1].times);
  CHECK(read.captures[1].nuisances[0].value == result.captures[1].nuisances[0].value);
  nlohmann::json older = nlohmann::json::parse(fit_json(result));
  older.erase("setup");
  const FitOptions told = read_fit(files.put("older.json", older.dump())).setup;
  CHECK(told.compared.outputs == read.setup.compared.outputs);
  CHECK(told.unknowns.shared == read.setup.unknowns.shared);
  CHECK(told.unknowns.per_capture == read.setup.unknowns.per_capture);
  CHECK(told.unknowns.offsets == read.setup.unknowns.offsets);
}

TEST_CASE("the JSON of a fit holds its numbers to the last bit") {
  const FitResult result = example();
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  CHECK(json["schema"] == "samara-fit/1");
  CHECK(json["status"] == "converged");
  CHECK(json["model"] == "vertical_fall");
  CHECK(json["coefficients"][0]["name"] == "C_D");
  CHECK(json["coefficients"][0]["value"].get<double>() == result.coefficients[0].value);
  CHECK(json["coefficients"][0]["standard_error"].get<double>() == *result.coefficients[0].standard_error);
  CHECK(json["covariance"][0][0].get<double>() == result.covariance(0, 0));
  CHECK(json["captures"].size() == 3);
  CHECK(json["captures"][1]["labels"]["drop"] == "1");
  CHECK(json["captures"][1]["nuisances"][0]["name"] == "v(0)");
  CHECK(json["captures"][1]["outputs"]["x"]["model"][3].get<double>() == result.captures[1].model(3, 0));
  CHECK(json["starts"].size() == 3);
}

TEST_CASE("reports hold the errors from random weights") {
  FitResult result = example();
  CHECK(nlohmann::json::parse(fit_json(result))["bootstrap"].is_null());
  result.bootstrap = Bootstrap{.replicates = 50, .standard_errors = {0.125}};
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  CHECK(json["bootstrap"]["replicates"] == 50);
  CHECK(json["bootstrap"]["standard_errors"][0].get<double>() == 0.125);
  CHECK_THAT(fit_text(result),
             Contains("errors from 50 fits with clusters weighted at random: C_D +- 0.12\n"));
  result.bootstrap->standard_errors = {std::nan("")};
  CHECK_THAT(fit_text(result), Contains("weighted at random: C_D -\n"));
}

TEST_CASE("an unknown whose chains never moved is the worst R-hat of the text, too") {
  FitResult result = example();
  result.posterior = Posterior{
      .chains = 2,
      .unknowns = {{.name = "C_D", .rhat = std::numeric_limits<double>::infinity(), .effective = 0.0},
                   {.name = "coin 0: v(0)", .rhat = 1.1, .effective = 90.0}}};
  CHECK_THAT(fit_text(result), Contains("R-hat at most inf, 0 effective draws or more"));
  result.posterior->unknowns[0].rhat = 1.2;
  CHECK_THAT(fit_text(result), Contains("R-hat at most 1.200, 0 effective draws or more"));
}

TEST_CASE("the text names the clusters that carry a coefficient almost alone") {
  FitResult result = example();
  Coefficient& c = result.coefficients[0];
  result.clusters = 3;
  result.cluster_names = {"flight 98", "flight 7", "flight 8"};
  c.standard_error = 0.1;
  c.cluster_shares = {0.9, 0.06, 0.04};
  c.effective_clusters = 1.2;
  CHECK_THAT(fit_text(result), Contains(fmt::format("{} is determined mostly by flight 98 (90 %):", c.name)));
  CHECK_THAT(verdict(result, c), Contains("by flight 98 almost alone"));
}

TEST_CASE("reports of joined segments say how nearly they join") {
  FitResult result = example();
  CHECK(nlohmann::json::parse(fit_json(result))["join_defect"].is_null());
  CHECK_THAT(fit_text(result), !Contains("segments join"));
  result.join_defect = 0.0125;
  CHECK(nlohmann::json::parse(fit_json(result))["join_defect"] == 0.0125);
  CHECK_THAT(fit_text(result), Contains("segments join to within 0.013 standard deviations"));
}

TEST_CASE("numbers that are not there are null in JSON") {
  FitResult result = example();
  result.coefficients[0].standard_error.reset();
  result.captures[0].measured(2, 0) = std::nan("");
  result.captures[0].id = "not \xff utf-8";
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  CHECK(json["coefficients"][0]["standard_error"].is_null());
  CHECK(json["captures"][0]["outputs"]["x"]["measured"][2].is_null());
}

TEST_CASE("noise levels and what steps cost stand in all reports") {
  FitResult result = example();
  CHECK(nlohmann::json::parse(fit_json(result))["integration_shift"].is_null());
  result.noise = {
      {.outputs = {"x", "y"}, .unit = "m", .value = 2e-3, .degrees_of_freedom = 50.0, .estimated = true},
      {.outputs = {"theta"}, .unit = "1", .value = 0.1}};
  result.noise_rounds = 3;
  result.integration_shift = 0.25;
  result.coefficients[0].integration_shift = -0.01;
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  CHECK(json["noise"][0]["outputs"][1] == "y");
  // 2e-3/sqrt(2 * 50)
  CHECK(json["noise"][0]["standard_error"].get<double>() == Approx(2e-4));
  CHECK(json["noise"][1]["standard_error"].is_null());
  CHECK(json["noise_rounds"] == 3);
  CHECK(json["integration_shift"].get<double>() == 0.25);
  CHECK(json["coefficients"][0]["integration_shift"].get<double>() == -0.01);
  const std::string text = fit_text(result);
  CHECK_THAT(text, Contains("noise of x, y: 0.00200 +- 0.00020 m, estimated\n") &&
                       Contains("noise of theta: taken to be 0.1\n") && Contains("estimated in 3 rounds") &&
                       Contains("would move no coefficient by more than 0.25 standard errors"));
}

TEST_CASE("the attitude as a whole has a residual, but no values frame by frame") {
  FitResult result = example();
  for (CaptureFit& capture : result.captures) capture.residuals.push_back({"attitude", "rad", 0.02});
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  CHECK(json["captures"][0]["outputs"].size() == 1);
  CHECK(json["captures"][0]["residuals"][1]["output"] == "attitude");
}

TEST_CASE("a fit that never ran has a report as well") {
  CHECK_THAT(fit_text(FitResult{}), Contains("the fit did not run"));
  CHECK(nlohmann::json::parse(fit_json(FitResult{}))["status"] == "failed");
}

TEST_CASE("the text names coefficients, captures and warnings") {
  FitResult result = example();
  result.warnings.add(WarningKind::source, "the moon was full");
  const std::string text = fit_text(result);
  CHECK_THAT(text, Contains("C_D") && Contains("v(0) [m/s]") && Contains("coin 2") && Contains("3 clusters"));
  CHECK_THAT(text, Contains("warning: the moon was full\n"));
  CHECK_THAT(text, !Contains(" \n"));
}
