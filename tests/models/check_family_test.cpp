#include "samara/models/trajectories/check_family.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <thread>

#include <catch2/catch.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "samara/base/errors.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/laws/registry.h"
#include "samara/models/trajectories/integrator_trajectories.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

using namespace samara::models;

namespace {

using Values = std::map<std::string, double>;
using Box = std::map<std::string, Interval>;

const Values kCoin = {{"area", 4.71435e-4}, {"thickness", 2.55e-3}, {"density", 6338.6}};
const Box kCoinBox = {{"C_D", {0.6, 2.0}}, {"v(0)", {0.1, 0.8}}};
const CheckFamilyOptions kHalfSecond = {.times = {0.0, 0.1, 0.2, 0.2, 0.35, 0.5}};

void check_passes(const TrajectoryFamily& family, const CheckFamilyOptions& options = kHalfSecond) {
  const samara::Check check = check_family(family, options);
  INFO(fmt::format("{}", fmt::join(check.findings, "\n")));
  CHECK(check.passed());
}

/// What can be wrong with a family; factors of one are right.
struct Faults {
  double derivative = 1.0;
  double derivative_alone = 1.0;  ///< where it is asked for by one coordinate
  double output_alone = 1.0;
  double batch = 1.0;
  double batch_of_threads = 1.0;
  double drift = 1.0;           ///< from call to call of a source
  double call_at_a_time = 1.0;  ///< while another thread asks, too
  bool takes_not_finite = false;
  bool takes_any_size = false;
  bool takes_any_times = false;
  bool takes_any_output = false;
  bool is_done_without_values = false;
  bool fails_without_words = false;
  bool throws_others = false;  ///< outside its box
  bool is_never_there = false;
};

/// x = a t, y = a^2 + b, for t up to 2 s.
class ClosedForm final : public TrajectoryFamily {
 public:
  explicit ClosedForm(const Faults& faults) : faults_(faults) {
    info_.model = "closed";
    info_.source = "closed form";
    info_.coordinates = {{"a", "m/s", false, 1.0, 2.0}, {"b", "m^2/s^2", false, 0.0, 1.0}};
    info_.outputs = {{"x", "m"}, {"y", "m^2/s^2"}};
    info_.end_time = 2.0;
  }

  FamilyInfo& mutable_info() { return info_; }
  const FamilyInfo& info() const override { return info_; }
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    return source(times, outputs, 1.0);
  }
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs,
                                       const std::vector<int>&) const override {
    return source(times, outputs, faults_.derivative_alone);
  }
  FamilyBatch batch(const Eigen::Ref<const Eigen::MatrixXd>& points, const std::vector<double>& times,
                    const std::vector<std::string>& outputs,
                    const FamilyBatchOptions& options) const override {
    FamilyBatch result = TrajectoryFamily::batch(points, times, outputs, options);
    for (Eigen::MatrixXd& values : result.values) {
      values *= faults_.batch;
      if (options.threads > 1) values *= faults_.batch_of_threads;
    }
    return result;
  }

 private:
  class Source final : public TrajectorySource {
   public:
    Source(const ClosedForm& family, const std::vector<double>& times,
           const std::vector<std::string>& outputs, double by_one)
        : family_(family), times_(times), outputs_(outputs), by_one_(by_one) {}

    TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                               Eigen::MatrixXd* derivatives) override {
      const Faults& faults = family_.faults_;
      if (!faults.takes_not_finite || q.size() != 2) {
        check_point(faults.takes_any_size ? q.first(2) : q, 2);
      }
      if (faults.is_never_there) return {TrajectoryStatus::not_integrated, "it is never there"};
      const double a = q[0], b = q[1];
      if (a > 2.0) {
        if (faults.throws_others) throw std::runtime_error("outside");
        return {TrajectoryStatus::outside_box, faults.fails_without_words ? "" : "a is outside the box"};
      }
      factor_ *= faults.drift;
      const double here = factor_ * family_.company();
      for (std::size_t o = 0; o < outputs_.size(); ++o) {
        const bool is_x = outputs_[o] == "x";
        const auto column = static_cast<Eigen::Index>(o);
        for (std::size_t row = 0; row < times_.size(); ++row) {
          const auto at = static_cast<Eigen::Index>(row);
          values(at, column) = here * (is_x ? a * times_[row] : a * a + b);
          if (faults.is_done_without_values) values(at, column) = std::nan("");
          if (outputs_.size() == 1) values(at, column) *= faults.output_alone;
          if (derivatives == nullptr) continue;
          const double factor = here * faults.derivative * by_one_;
          const auto width = static_cast<Eigen::Index>(outputs_.size());
          (*derivatives)(at, column) = factor * (is_x ? times_[row] : 2.0 * a);
          (*derivatives)(at, column + width) = is_x ? 0.0 : factor;
        }
      }
      return {};
    }

   private:
    const ClosedForm& family_;
    std::vector<double> times_;
    std::vector<std::string> outputs_;
    double by_one_;
    double factor_ = 1.0;
  };

  /// A factor that is not one where a thread asks that is not the one that made the family.
  double company() const { return std::this_thread::get_id() == home_ ? 1.0 : faults_.call_at_a_time; }

  std::unique_ptr<TrajectorySource> source(const std::vector<double>& times,
                                           const std::vector<std::string>& outputs, double by_one) const {
    if (!faults_.takes_any_times) {
      check_times(times);
      if (!times.empty() && times.back() > info_.end_time) throw samara::OutsideBoxError("after the end");
    }
    for (const std::string& output : outputs) {
      if (output != "x" && output != "y" && !faults_.takes_any_output)
        throw samara::ArgumentError("no such output");
    }
    return std::make_unique<Source>(*this, times, outputs, by_one);
  }

  Faults faults_;
  FamilyInfo info_;
  std::thread::id home_ = std::this_thread::get_id();
};

bool finds(const TrajectoryFamily& family, const std::string& words) {
  const samara::Check check = check_family(family);
  INFO(fmt::format("{}", fmt::join(check.findings, "\n")));
  const bool found = std::ranges::any_of(
      check.findings, [&](const std::string& finding) { return finding.find(words) != std::string::npos; });
  CHECK(found);
  return found;
}

bool finds(const Faults& faults, const std::string& words) {
  return finds(ClosedForm(faults), words);
}

bool finds_in_info(const std::function<void(FamilyInfo&)>& spoil, const std::string& words) {
  ClosedForm family({});
  spoil(family.mutable_info());
  return finds(family, words);
}

}  // namespace

TEST_CASE("a family of trajectories in order has no findings") {
  check_passes(ClosedForm({}), {});
}

TEST_CASE("every family of a model keeps the laws of families") {
  const auto coin = find_model("vertical_fall");
  check_passes(*reference_trajectories(coin, kCoin, kCoinBox));
  check_passes(*step_trajectories(coin, kCoin, kCoinBox, 1e-3));
  check_passes(*step_trajectories(coin, kCoin, kCoinBox, 1e-3)->finer());
  check_passes(*integrator_trajectories(coin, kCoin, kCoinBox, IntegrateOptions{}));
  check_passes(*integrator_trajectories(coin, kCoin, kCoinBox, AdaptiveOptions{}));
  check_passes(*integrator_trajectories(coin, kCoin, kCoinBox, Rk4Options{.step = 1e-3}));
}

TEST_CASE("a family knows that its equations know the time, also where the motion begins at rest") {
  // A pendulum whose pivot is shaken.
  const Equations shaken = {.name = "shaken",
                            .title = "of a test",
                            .states = {{.name = "angle", .unit = "1", .description = "a state"},
                                       {.name = "spin", .unit = "1", .description = "a state"}},
                            .parameters = {{.name = "pull", .unit = "1", .description = "of the test"}},
                            .rates = {"spin", "-pull*(1 + 0.5*sin(t))*sin(angle)"}};
  const auto family_of = [](const Equations& equations) {
    return reference_trajectories(equation_model(equations), {}, {{"pull", {0.5, 1.5}}});
  };
  CHECK_FALSE(family_of(shaken)->info().autonomous);
  Equations calm = shaken;
  calm.rates[1] = "-pull*sin(angle)";
  CHECK(family_of(calm)->info().autonomous);
  Equations kicked = calm;
  kicked.rates[1] = "-pull*sin(angle) + step(t - 0.5)*step(1.2 - t)";
  CHECK_FALSE(family_of(kicked)->info().autonomous);
  // Between all times that could be tried.
  kicked.rates[1] = "-pull*sin(angle) + exp(-((t - 4.7)/0.01)^2)";
  CHECK_FALSE(family_of(kicked)->info().autonomous);
  calm.rates[1] = "sqrt(-pull)";
  CHECK_FALSE(family_of(calm)->info().autonomous);
}

TEST_CASE("the one trajectory of a model without free coordinates is a family") {
  Values held = kCoin;
  held["C_D"] = 1.0;
  const auto coin = find_model("vertical_fall");
  check_passes(*integrator_trajectories(coin, held, {}, IntegrateOptions{}));
  check_passes(*integrator_trajectories(coin, held, {}, Rk4Options{.step = 1e-3}));
  CHECK_THROWS_WITH(reference_trajectories(coin, held, {}), Catch::Contains("the box is empty"));
}

TEST_CASE("the trajectory of a family is that of its integrator") {
  const ParametricModel model(find_model("vertical_fall"), kCoin, {"C_D", "v(0)"});
  const std::vector<double> q = {1.1, 0.3};
  const std::vector<double> times = {0.1, 0.4};
  const auto family = reference_trajectories(find_model("vertical_fall"), kCoin, kCoinBox);
  const FamilyTrajectory one = trajectory(*family, q, times, {"x", "v"}, Derivatives::yes);
  const Trajectory same = integrate(model, q, times, {}, true);
  REQUIRE(one.outcome);
  CHECK(one.values.col(1) == same.states.col(0));
  CHECK(one.values.col(0) == same.states.col(1));
  CHECK(one.derivatives.col(2) == same.sensitivities[1].col(1));
}

TEST_CASE("rows after the end of an integration are NaN, and the outcome says when and why") {
  const auto family = integrator_trajectories(find_model("vertical_fall"), kCoin, kCoinBox,
                                              Rk4Options{.step = 0.01, .max_steps = 25});
  const FamilyTrajectory one = trajectory(*family, std::vector{1.0, 0.2}, {0.1, 0.2, 0.3}, {"v"});
  CHECK(one.outcome.status == TrajectoryStatus::not_integrated);
  CHECK(one.outcome.reached == 0.2);
  CHECK_THAT(one.outcome.message, Catch::Contains("more steps than allowed"));
  CHECK(one.values.topRows(2).allFinite());
  CHECK(std::isnan(one.values(2, 0)));
  const std::vector<double> times = {0.1, 0.2, 0.3};
  CHECK(rows_reached(one.outcome, times) == 2);
  CHECK(rows_reached({.status = TrajectoryStatus::outside_box}, times) == 0);
  CHECK(rows_reached({}, times) == 3);
}

TEST_CASE("wrong derivatives of a family are found") {
  CHECK(finds({.derivative = 1.001}, "derivative of \"x\" by \"a\""));
  CHECK(finds({.derivative_alone = 1.001}, "derivatives by \"a\" alone"));
}

TEST_CASE("a family that depends on how it is asked is found") {
  CHECK(finds({.output_alone = 1.001}, "\"x\" alone is not"));
  CHECK(finds({.batch = 1.001}, "in a batch, point 0 has another trajectory"));
  CHECK(finds({.batch_of_threads = 1.0 + 1e-14}, "depends on the number of threads"));
  CHECK(finds({.drift = 1.0 + 1e-14}, "gives other bits"));
  CHECK(finds({.call_at_a_time = 1.0 + 1e-14}, "threads at once"));
}

TEST_CASE("a family that takes what means nothing is found") {
  CHECK(finds({.takes_not_finite = true}, "\"b\" is nan is not refused"));
  CHECK(finds({.takes_any_size = true}, "a number too many is not refused"));
  CHECK(finds({.takes_any_times = true}, "times that decrease is not refused"));
  CHECK(finds({.takes_any_times = true}, "a time after the end is not refused"));
  CHECK(finds({.takes_any_output = true}, "an output that there is not is not refused"));
}

TEST_CASE("outcomes that say nothing, or the wrong thing, are found") {
  CHECK(finds({.is_done_without_values = true}, "the status is done, and values are not finite"));
  CHECK(finds({.fails_without_words = true}, "no message says why"));
  CHECK(finds({.throws_others = true}, "no samara::Error"));
  CHECK(finds({.is_never_there = true}, "no trajectory at any of 6 points"));
}

TEST_CASE("what a family says wrongly of itself is found") {
  CHECK(finds_in_info([](FamilyInfo& info) { info.source.clear(); }, "no words on its source"));
  CHECK(finds_in_info([](FamilyInfo& info) { info.coordinates[1].name = "a"; }, "\"a\" is used twice"));
  CHECK(finds_in_info([](FamilyInfo& info) { info.coordinates[0].upper = 1.0; }, "goes from 1 to 1"));
  CHECK(finds_in_info([](FamilyInfo& info) { info.fixed["b"] = 1.0; }, "both free and held"));
  CHECK(finds_in_info([](FamilyInfo& info) { info.translations = {"z"}; }, "\"z\" of translations"));
  CHECK(finds_in_info([](FamilyInfo& info) { info.outputs[1].unit.clear(); }, "has no unit"));
  CHECK_THROWS_WITH(check_family(ClosedForm({}), {.points = 0}), Catch::Contains("points is 0"));
}
