/// Fits of bodies whose mass was given wrongly.
#include "samara/identification/fit/mass_check.h"

#include <catch2/catch.hpp>

#include "samara/identification/fit/fit.h"
#include "samara/models/laws/registry.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// Doubts about two falls of a coin, fitted with its density times `factor`.
std::vector<std::string> doubts(double factor, FitOptions options = {}, bool labelled = false) {
  auto fixed = coin_fixed();
  std::vector<Capture> captures = {coin_capture("a", 1.1, 0.1, 0.2), coin_capture("b", 1.1, 0.3, -0.1)};
  std::map<std::string, samara::models::Interval> box = {{"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}};
  const double density = factor * fixed.at("density");
  if (labelled) {
    for (Capture& capture : captures) capture.labels["rho"] = std::to_string(density);
    options.unknowns.known["density"] = "rho";
    fixed.erase("density");
    box["density"] = {1.0, 1e8};
  } else {
    fixed["density"] = density;
  }
  const auto family = reference_trajectories(samara::models::find_model("vertical_fall"), fixed, box);
  const FitResult fitted = fit(*family, captures, options);
  return check_mass(*family, captures, options, fitted);
}

}  // namespace

TEST_CASE("a density that is wrong by a thousand is named, to either side, fixed or of each capture") {
  const auto heavy = doubts(1e3, {}, true);
  REQUIRE(heavy.size() == 1);
  CHECK_THAT(heavy[0], Contains("the mass of the body is in doubt") &&
                           Contains("a density 10^3 times as small would leave"));
  const auto light = doubts(1e-3);
  REQUIRE(light.size() == 1);
  CHECK_THAT(light[0], Contains("a density 10^3 times as large would leave"));
}

TEST_CASE("a known density is doubted beyond its box, and nothing that a trial refuses ends the fit") {
  // Captures from files are refused by another kind of error.
  std::vector<Capture> captures = {coin_capture("a", 1.1, 0.1, 0.2), coin_capture("b", 1.1, 0.3, -0.1)};
  auto fixed = coin_fixed();
  const double density = 1e3 * fixed.at("density");
  fixed.erase("density");
  for (Capture& capture : captures) {
    capture.file = "coins.csv";
    capture.labels["rho"] = fmt::format("{}", density);
  }
  FitOptions options;
  options.unknowns.known["density"] = "rho";
  const std::map<std::string, samara::models::Interval> box = {
      {"C_D", {0.6, 2.0}}, {"v(0)", {-0.4, 0.8}}, {"density", {0.5 * density, 2.0 * density}}};
  options.unknowns.box["density"] = {0.7 * density, 1.5 * density};
  const auto family = reference_trajectories(samara::models::find_model("vertical_fall"), fixed, box);
  const FitResult fitted = fit(*family, captures, options);
  const auto said = check_mass(*family, captures, options, fitted);
  REQUIRE(said.size() == 1);
  CHECK_THAT(said[0], Contains("a density 10^3 times as small would leave"));
}

TEST_CASE("fits of other masses hold the noise that the fit found, and are silent") {
  FitOptions options;
  options.noise.estimated = true;
  options.uncertainty.bootstrap.replicates = 2;
  options.starts.count = 1;
  int told = 0;
  options.progress = [&](const samara::Progress&) { return ++told > 0; };
  const auto said = doubts(1e3, options);
  REQUIRE(said.size() == 1);
  CHECK_THAT(said[0], Contains("a density 10^3 times as small would leave"));
  CHECK(told == 1);  // by the fit itself
}

TEST_CASE("the right density is in no doubt, and another error is not blamed on it") {
  CHECK(doubts(1.0).empty());
  // C_D = 1.1 is outside its box: no power of ten of the mass makes up for that.
  FitOptions narrow;
  narrow.unknowns.box = {{"C_D", {1.5, 2.0}}};
  CHECK(doubts(1.0, narrow).empty());
}
