#include "samara/flow/march/load_history.h"

#include <cmath>
#include <functional>

#include <catch2/catch.hpp>

#include "flow_cases.h"
#include "samara/base/streams.h"

using namespace samara::flow;
using flow_cases::kPi;

namespace {

using Series = std::function<double(double)>;

/// Periods of a made-up body, in steps of 0.02.
std::vector<PeriodMeans> periods_of(const Series& drag, const Series& lift, double until) {
  PeriodCounter counter;
  std::vector<PeriodMeans> periods;
  const double step = 0.02;
  for (long s = 1; s <= std::lround(until / step); ++s) {
    const double t = static_cast<double>(s) * step;
    if (const auto period = counter.add({t, step, drag(t), lift(t), 0.5 * lift(t)}))
      periods.push_back(*period);
  }
  return periods;
}

double sine(double t) {
  return 0.3 * std::sin(2 * kPi * t / 7.0);
}

/// Equal periods with these drags.
std::vector<PeriodMeans> with_drags(const std::vector<double>& drags) {
  std::vector<PeriodMeans> periods;
  for (const double drag : drags) periods.push_back({.length = 7.0, .drag = drag, .by_crossing = true});
  return periods;
}

}  // namespace

TEST_CASE("periods of a lift that swings are cut where it passes its mean upwards", "[flow]") {
  const auto drag = [](double t) { return 2.0 + 0.1 * std::cos(4 * kPi * t / 7.0); };
  const std::vector<PeriodMeans> periods = periods_of(
      drag, [](double t) { return 0.1 + sine(t); }, 210.0);
  REQUIRE(periods.size() >= 25);
  for (std::size_t i = 5; i < periods.size(); ++i) {
    CHECK(periods[i].by_crossing);
    CHECK(periods[i].length == Approx(7.0).epsilon(0.01));
    CHECK(periods[i].drag == Approx(2.0).epsilon(1e-3));
    CHECK(periods[i].lift == Approx(0.1).margin(2e-3));
    CHECK(periods[i].lift_squared - periods[i].lift * periods[i].lift == Approx(0.045).epsilon(0.02));
  }
  CHECK(shedding_frequency(periods) == Approx(1.0 / 7.0).epsilon(0.01));
}

TEST_CASE("windows of a still lift and forced ends of a drifting one are no periods of shedding", "[flow]") {
  const auto one = [](double) { return 1.0; };
  const std::vector<PeriodMeans> still = periods_of(
      one, [](double) { return 0.2; }, 100.0);
  CHECK(still.size() >= 19);
  CHECK(shedding_frequency(still) == 0.0);
  const std::vector<PeriodMeans> drifting = periods_of(
      one, [](double t) { return 0.01 * t; }, 200.0);
  CHECK(drifting.size() >= 5);
  CHECK(shedding_frequency(drifting) == 0.0);
  // The windows before shedding begins do not count with what sheds.
  const std::vector<PeriodMeans> late = periods_of(
      one, [](double t) { return t < 100.0 ? 0.0 : sine(t); }, 250.0);
  CHECK(shedding_frequency(late) == Approx(1.0 / 7.0).epsilon(0.02));
}

TEST_CASE("a drag that still drifts has not settled, and its mean is not known", "[flow]") {
  std::vector<double> slow, fast, noisy, short_run;
  for (int i = 0; i < 10; ++i) {
    slow.push_back(2.0 * std::pow(1.001, i));
    // Over windows that share three of five periods this moves by 1.4 % only.
    fast.push_back(2.0 * std::pow(1.007, i));
    noisy.push_back(2.0 + (i % 2 == 0 ? 0.01 : -0.01));
  }
  CHECK(is_settled(with_drags(slow)));
  CHECK(is_settled(with_drags(noisy)));
  CHECK_FALSE(is_settled(with_drags(fast)));
  CHECK_FALSE(is_settled(with_drags({2, 2, 2, 2, 2, 2, 2, 2, 2})));

  CHECK(is_known(with_drags(noisy), 0.01));
  CHECK_FALSE(is_known(with_drags({2, 2, 2, 2}), 0.01));
  // Half of their interval is 0.98 %: a drift that passes for scatter.
  const std::vector<PeriodMeans> drifting = with_drags({2.0, 2.01, 2.02, 2.03, 2.04});
  CHECK(mean_drag(drifting).half_width < 0.01 * mean_drag(drifting).value);
  CHECK_FALSE(is_known(drifting, 0.01));
}

TEST_CASE("shedding that still grows is no mean, and what was averaged of it is dropped", "[flow]") {
  // As of an ellipse broadside on, four cells to its length, at Re 32,000: after its first ten periods the drag moves
  // by less than 2 % in five of them, and grows by 14 % yet; at 600 l/U the drag of what was averaged still drifted.
  const auto size = [](double t) { return 0.05 + 0.33 / (1.0 + std::exp((90.0 - t) / 15.0)); };
  const Series drag = [&](double t) { return 2.44 + 2.6 * size(t) * size(t); };
  const Series lift = [&](double t) { return size(t) * std::sqrt(2.0) * std::sin(2 * kPi * t / 5.0); };
  const std::vector<PeriodMeans> early = periods_of(drag, lift, 60.0);
  CHECK(is_settled(early));
  CHECK_FALSE(is_known({early.end() - 5, early.end()}, 0.01));
  const std::vector<PeriodMeans> all = periods_of(drag, lift, 400.0);
  const std::vector<PeriodMeans> growing(all.begin() + 10, all.begin() + 24),
      grown(all.end() - 20, all.end());
  CHECK(holds_transient(growing, 0.01));
  CHECK_FALSE(holds_transient(grown, 0.01));
  CHECK(is_known(grown, 0.01));
  CHECK(mean_drag(grown).value == Approx(drag(400.0)).epsilon(0.005));
  // Scatter is no transient, nor is what has fewer than ten periods.
  std::vector<double> noisy;
  for (int i = 0; i < 14; ++i) noisy.push_back(2.0 + 0.1 * std::sin(5.0 * i * i));
  CHECK_FALSE(holds_transient(with_drags(noisy), 0.01));
  CHECK_FALSE(holds_transient({growing.begin(), growing.begin() + 9}, 0.01));
}

TEST_CASE("a drag that stands still while a tiny swing of the lift grows is no mean", "[flow]") {
  // As of a plate broadside on, 32 cells to its length: from 80 to 120 l/U the drag is 1.685 of steady flow, while
  // the lift grows by half every 5 l/U, until the plate sheds with a drag of more than 2.2.
  const auto with_swings = [](double first, double growth) {
    std::vector<PeriodMeans> periods;
    for (int i = 0; i < 8; ++i) {
      const double swing = first * std::pow(growth, i);
      periods.push_back({.length = 5.0, .drag = 1.685, .lift_squared = swing * swing});
    }
    return periods;
  };
  CHECK_FALSE(is_known(with_swings(2e-5, 1.5), 0.01));
  CHECK_FALSE(is_known(with_swings(1e-9, 1.5), 0.01));
  CHECK(is_known(with_swings(1e-3, 1.0), 0.01));
  CHECK(is_known(with_swings(1e-3, 0.7), 0.01));
  CHECK(is_known(with_swings(0.0, 1.0), 0.01));
}

TEST_CASE("a lift that stands still does not grow by the rounding of its squares", "[flow]") {
  std::vector<PeriodMeans> periods;
  for (int i = 0; i < 8; ++i) {
    const double squared = i < 4 ? 0.49 : 0.49 * (1.0 + 4e-16);
    periods.push_back({.length = 5.0, .drag = 1.0, .lift = 0.7, .lift_squared = squared});
  }
  CHECK(is_known(periods, 0.01));
  // As counted, in steps that vary as those of a flow do.
  for (const double still : {0.7, 0.31, -1.234}) {
    samara::Stream random(6, 0);
    PeriodCounter counter;
    std::vector<PeriodMeans> counted;
    for (double time = 0.0; time < 500.0;) {
      const double step = 0.01 * (1.0 + 0.1 * random.uniform());
      time += step;
      if (const auto period = counter.add({time, step, 1.0, still, 0.0})) counted.push_back(*period);
    }
    int refused = 0;
    for (auto end = counted.begin() + 5; end != counted.end(); ++end)
      refused += is_known({counted.begin(), end}, 0.01) ? 0 : 1;
    INFO("of " << counted.size() << " periods of the lift " << still);
    CHECK(refused == 0);
  }
}

TEST_CASE("shedding whose swings scatter and do not grow is averaged on and on", "[flow]") {
  // Of each period: drawn for itself, with a drag that goes with the square of the swing.
  const auto restarts = [](double scatter, std::uint64_t seed, double growth) {
    samara::Stream random(seed, 0);
    std::vector<PeriodMeans> averaged;
    int count = 0;
    for (int i = 0; i < 200; ++i) {
      const double grown = 1.0 - growth * std::exp(-0.1 * i);
      const double swing = 0.3 * grown * std::max(0.05, 1.0 + scatter * random.normal());
      averaged.push_back({.length = 5.0, .drag = 2.44 + 2.6 * swing * swing, .lift_squared = swing * swing});
      if (!holds_transient(averaged, 0.01)) continue;
      averaged.clear();
      ++count;
    }
    return count;
  };
  for (const double scatter : {0.15, 0.2, 0.3}) {
    int stationary = 0, growing = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      stationary += restarts(scatter, seed, 0.0);
      growing += restarts(scatter, seed, 0.9) > 0 ? 1 : 0;
    }
    INFO("of ten runs whose swings scatter by " << scatter);
    CHECK(stationary <= 1);
    CHECK(growing == 10);
  }
}

TEST_CASE("means over the last periods are of the steps within them, by shares", "[flow]") {
  std::vector<LoadRecord> history;
  for (int s = 1; s <= 1000; ++s) history.push_back({.time = 0.02 * s, .step = 0.02, .drag = 0.02 * s});
  for (const double period : {2.5, 0.05, 0.013}) {
    const std::vector<PeriodMeans> periods = last_periods(history, period);
    REQUIRE(std::ssize(periods) == std::lround(std::floor(10.0 / period)));
    for (std::size_t p = 0; p < periods.size(); ++p) {
      CHECK(periods[p].length == Approx(period));
      const double middle = 20.0 - period * (static_cast<double>(periods.size() - p) - 0.5);
      CHECK(std::abs(periods[p].drag - middle) < 0.021);
    }
  }
}

TEST_CASE("the error of a mean drag is Student's, and that of less than two periods is not known", "[flow]") {
  CHECK(std::isinf(mean_drag(with_drags({2.0})).half_width));
  const MeanWithError mean = mean_drag(with_drags({1.0, 2.0, 3.0}));
  CHECK(mean.value == Approx(2.0));
  CHECK(mean.half_width == Approx(4.303 / std::sqrt(3.0)).epsilon(1e-9));
}
