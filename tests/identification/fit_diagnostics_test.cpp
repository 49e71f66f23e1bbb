#include <algorithm>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "samara/identification/fit/fit.h"
#include "samara/identification/report/fit_report.h"
#include "synthetic.h"

using namespace samara::identification;
using Catch::Matchers::Contains;

namespace {

/// Captures of BrakedFamily with k = 1.4.
std::vector<Capture> braked(int count, double noise, double end = 1.5) {
  std::mt19937_64 random(4);
  const std::vector<double> times = even_times(20, end);
  std::vector<Capture> captures;
  for (int c = 0; c < count; ++c) {
    captures.push_back(
        make_capture(fmt::format("{}", c), times, BrakedFamily::depths(1.4, 0.5 + 0.2 * c, times)));
    add_noise(captures.back(), noise, random);
  }
  return captures;
}

/// x = (a + b) t: what has only a sum.
class SumFamily final : public samara::models::TrajectoryFamily {
 public:
  explicit SumFamily(double of_b = 1.0) : of_b_(of_b) {
    info_.model = "sum";
    info_.source = "closed form";
    info_.coordinates = {{"a", "m/s", false, -2.0, 4.0}, {"b", "m/s", false, -2.0, 4.0}};
    info_.outputs = {{"x", "m"}};
  }
  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>& times,
                                                       const std::vector<std::string>&) const override {
    return std::make_unique<Source>(times, of_b_);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    Source(const std::vector<double>& at_times, double factor)
        : t(Eigen::Map<const Eigen::VectorXd>(at_times.data(), static_cast<Eigen::Index>(at_times.size()))),
          of_b(factor) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      values.col(0) = (q[0] + of_b * q[1]) * t;
      if (!derivatives) return {};
      derivatives->col(0) = t;
      derivatives->col(1) = of_b * t;
      return {};
    }
    Eigen::VectorXd t;
    double of_b;
  };
  samara::models::FamilyInfo info_;
  double of_b_;
};

std::vector<Capture> lines(int count) {
  std::mt19937_64 random(9);
  const std::vector<double> times = even_times(20, 1.0);
  std::vector<Capture> captures;
  for (int c = 0; c < count; ++c) {
    captures.push_back(make_capture(
        fmt::format("{}", c), times,
        1.5 * Eigen::Map<const Eigen::VectorXd>(times.data(), static_cast<Eigen::Index>(times.size()))));
    add_noise(captures.back(), 2e-3, random);
  }
  return captures;
}

}  // namespace

TEST_CASE("the profile of a well-determined coefficient agrees with its standard error") {
  const BrakedFamily family;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.uncertainty.profiles = true;
  const FitResult result = fit(family, braked(8, 2e-3), options);
  const Coefficient& k = result.coefficients[0];
  const Profile* p = result.find_profile("k");
  REQUIRE(p);
  REQUIRE(p->shape == ProfileShape::identified);
  // Its dispersion is chosen so, and its quantile is Student's for 7 = 8 clusters - 1; what is left is the
  // bend of the profile.
  CHECK(*p->interval_lower == Approx(k.value - 2.3646 * *k.standard_error).epsilon(0.02));
  CHECK(*p->interval_upper == Approx(k.value + 2.3646 * *k.standard_error).epsilon(0.02));
  CHECK(p->best_cost == result.cost);
  CHECK_THAT(verdict(result, k), Contains(" to ") && Contains("95 %"));
  CHECK(result.find_profile("nothing") == nullptr);
}

TEST_CASE("intervals of profiles cover the truth about as often as they say") {
  const BrakedFamily family;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  options.uncertainty.profiles = true;
  const std::vector<double> times = even_times(20, 1.0);
  std::mt19937_64 random(11);
  for (const int count : {1, 4}) {
    int covered = 0;
    constexpr int kSeeds = 300;
    for (int seed = 0; seed < kSeeds; ++seed) {
      std::vector<Capture> captures;
      for (int c = 0; c < count; ++c) {
        captures.push_back(
            make_capture(fmt::format("{}", c), times, BrakedFamily::depths(1.4, 0.8 + 0.2 * c, times)));
        add_noise(captures.back(), 2e-3, random);
      }
      const FitResult result = fit(family, captures, options);
      const Profile& p = result.profiles.at(0);
      covered += p.interval_lower.value_or(-1e9) < 1.4 && 1.4 < p.interval_upper.value_or(1e9) ? 1 : 0;
    }
    // 300 seeds: a standard deviation of 1.3 %. Four clusters of unlike weight are worth fewer than four.
    INFO(count << " captures: " << covered << " of " << kSeeds);
    CHECK(covered >= (count == 1 ? 0.91 : 0.88) * kSeeds);
    CHECK(covered <= 0.99 * kSeeds);
  }
}

TEST_CASE("a capture that is too short gives a coefficient one limit, and the profile says so") {
  const BrakedFamily family;
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.starts.count = 1;
  options.uncertainty.profiles = true;
  // Over 0.1 s at 2 mm the braking of 1/s is barely seen: it may be anything from none to strong.
  const FitResult result = fit(family, braked(1, 2e-3, 0.1), options);
  const Profile* p = result.find_profile("k");
  REQUIRE(p);
  CHECK(p->shape != ProfileShape::identified);
  CHECK_THAT(fit_text(result), Contains("not determined") || Contains("at most") || Contains("at least"));
}

TEST_CASE("two coefficients that act as a sum are named as one, whatever their profiles say") {
  FitOptions options;
  options.loss.kind = LossKind::none;
  options.uncertainty.profiles = true;
  const FitResult result = fit(SumFamily(), lines(3), options);
  CHECK(result.status == samara::Termination::not_determined);
  REQUIRE(result.identifiability);
  REQUIRE(result.identifiability->phrases.size() == 1);
  CHECK(result.identifiability->phrases[0] == "a and b only as a sum");
  // a may rise until b meets its bound: a limit that the box gives, not the captures.
  const Profile* p = result.find_profile("a");
  REQUIRE(p);
  CHECK(p->lower_end == ProfileEnd::box);
  CHECK(verdict(result, result.coefficients[0]) == "not determined");
  const std::string text = fit_text(result);
  CHECK_THAT(text, Contains("determined by the captures: a and b only as a sum"));
  CHECK_THAT(text, Contains("not determined\n"));
}

TEST_CASE("a fit says of a coefficient without influence that it is known not at all") {
  FitOptions options;
  options.loss.kind = LossKind::none;
  const FitResult result = fit(SumFamily(0.0), lines(3), options);
  REQUIRE(result.identifiability);
  CHECK(result.identifiability->phrases.at(0) == "b not at all");
  CHECK(verdict(result, result.coefficients[1]) == "not determined");
}

TEST_CASE("residuals of a fit to independent noise are white, those of a wrong model are not") {
  const BrakedFamily family;
  FitOptions options;
  options.loss.kind = LossKind::none;
  const FitResult good = fit(family, braked(10, 2e-3), options);
  REQUIRE(good.whiteness);
  CHECK(good.whiteness->series.size() == 10);
  CHECK(good.whiteness->series[3].capture == "3");
  CHECK(good.whiteness->rejected <= 2);
  std::vector<Capture> bent = braked(10, 2e-4);
  for (Capture& capture : bent)
    capture.channels[0].values.array() += 5e-3 * (12.0 * capture.times.array()).sin();
  const FitResult wrong = fit(family, bent, options);
  CHECK(wrong.whiteness->rejected == 10);
  CHECK_THAT(fit_text(wrong), Contains("naive errors are too small"));
}

TEST_CASE("the JSON holds what a fit may claim") {
  const BrakedFamily family;
  FitOptions options;
  options.uncertainty.profiles = true;
  FitResult result = fit(family, braked(4, 2e-3), options);
  result.predictions = {
      {.predictor = "model", .quantity = "position, 0.1 s ahead", .captures = 2, .median = 0.01}};
  result.global_search = GlobalSearch{.method = "crs", .evaluations = 300, .cost = std::nan("")};
  const nlohmann::json json = nlohmann::json::parse(fit_json(result));
  const nlohmann::json& profile = json["profiles"][0];
  CHECK(profile["name"] == "k");
  CHECK(profile["shape"] == "identified");
  CHECK(profile["interval"][0].get<double>() == *result.profiles[0].interval_lower);
  CHECK(profile["values"].size() == profile["costs"].size());
  CHECK(json["coefficients"][0]["verdict"] == verdict(result, result.coefficients[0]));
  CHECK(json["identifiability"]["directions"][0]["kind"] == "determined");
  CHECK(json["whiteness"]["series"].size() == 4);
  CHECK(json["predictions"][0]["median"] == 0.01);
  CHECK(json["global_search"]["evaluations"] == 300);
  CHECK(json["global_search"]["cost"].is_null());
  const std::string text = fit_text(result);
  CHECK_THAT(text, Contains("position, 0.1 s ahead [m]") && Contains("search of the box by crs: 300 points"));
}
