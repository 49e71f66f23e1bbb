#include "samara/pgd/sampling/sampling.h"

#include <cmath>
#include <set>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/pgd/tensors/random.h"
#include "sampled_functions.h"

using namespace samara::pgd;
using Catch::Contains;

TEST_CASE("a smooth function of five coordinates is met, and independent points agree") {
  const Scalar f = [](std::span<const double> x) {
    return std::cos(x[0] + 2.0 * x[1] * x[2]) / (1.5 + x[3] + 0.5 * x[4] * x[0]);
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SamplingResult result =
        sample(unit_box(5), {{"f"}}, one_output(f), {.tolerance = 1e-6, .seed = seed});
    INFO(result.message);
    REQUIRE(result.tolerance_met());
    // The exploration sees 30 points for each coordinate and one for every two hundred calls allowed.
    CHECK(result.points_checked >= 30 * 5 + 500);
    CHECK(independent_error(result, f) < 3e-6);
    CHECK(result.error <= 1e-6);
    CHECK(result.root_mean_square_error <= result.error);
    CHECK(static_cast<double>(result.calls) < 0.2 * result.grid_size);
  }
}

TEST_CASE("the build does not believe a tolerance that it has not reached") {
  const Scalar kink = [](std::span<const double> x) { return std::abs(sum_of(x) - 0.5 * 4.0); };
  const Scalar pole = [](std::span<const double> x) { return 1.0 / (sum_of(x) - 0.37 * 4.0); };
  const Scalar noise = [](std::span<const double> x) {
    return std::exp(-sum_of(x)) + 1e-6 * std::sin(1.3e6 * sum_of(x) + 78233.0 * x[0]);
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    for (const Scalar& f : {kink, pole, noise}) {
      const SamplingResult result =
          sample(unit_box(4), {{"f"}}, one_output(f), {.tolerance = 1e-7, .max_calls = 8000, .seed = seed});
      CHECK_FALSE(result.tolerance_met());
      REQUIRE(result.field);
      CHECK(result.error > 1e-7);
      CHECK_THAT(result.message, Contains("errs by"));
    }
  }
}

TEST_CASE("of two coordinates of high rank all nodes are called, and of low rank few") {
  // exp(-4 (x - y)^2) has about as many terms as nodes; the other function has two.
  const Scalar high = [](std::span<const double> x) { return std::exp(-4.0 * std::pow(x[0] - x[1], 2)); };
  const Scalar low = [](std::span<const double> x) {
    return std::sin(9.0 * x[0]) * std::cos(8.0 * x[1]) + x[0];
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SamplingResult whole = sample(unit_box(2), {{"f"}}, one_output(high),
                                        {.tolerance = 1e-6, .max_calls = 20'000, .seed = seed});
    INFO(whole.message);
    REQUIRE(whole.tolerance_met());
    CHECK(whole.calls - whole.points_checked >= static_cast<long>(whole.grid_size));
    CHECK(independent_error(whole, high) < 3e-6);
    const SamplingResult crosses =
        sample(unit_box(2), {{"f"}}, one_output(low), {.tolerance = 1e-6, .max_calls = 20'000, .seed = seed});
    REQUIRE(crosses.tolerance_met());
    CHECK(static_cast<double>(crosses.calls - crosses.points_checked) < 0.7 * crosses.grid_size);
    CHECK(independent_error(crosses, low) < 3e-6);
  }
}

TEST_CASE("two narrow peaks are found") {
  const Scalar f = [](std::span<const double> x) {
    double a = 0.0, b = 0.0;
    for (const double value : x) {
      a += std::pow(value - 0.3, 2);
      b += std::pow(value - 0.7, 2);
    }
    return std::exp(-a / 0.04) + std::exp(-b / 0.04);
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SamplingResult result =
        sample(unit_box(6), {{"f"}}, one_output(f), {.tolerance = 1e-3, .max_calls = 20000, .seed = seed});
    CHECK(result.tolerance_met());
    const std::vector<double> first(6, 0.3), second(6, 0.7);
    CHECK((*result.field)(first)[0] == Approx(f(first)).margin(3e-3));
    CHECK((*result.field)(second)[0] == Approx(f(second)).margin(3e-3));
  }
}

TEST_CASE("a constant, a zero and a function of one coordinate take few calls and rank one") {
  const SamplingResult constant =
      sample(unit_box(6), {{"f"}}, one_output([](std::span<const double>) { return 3.25; }),
             {.exploration_points = 100});
  CHECK(constant.tolerance_met());
  CHECK(constant.calls < 400);
  CHECK((*constant.field)(std::vector<double>(6, 0.4))[0] == Approx(3.25).epsilon(1e-13));
  const SamplingResult zero =
      sample(unit_box(3), {{"f"}}, one_output([](std::span<const double>) { return 0.0; }));
  CHECK(zero.tolerance_met());
  CHECK((*zero.field)(std::vector<double>(3, 0.4))[0] == 0.0);
  const Scalar sine = [](std::span<const double> x) { return std::sin(7.0 * x[2]); };
  const SamplingResult one = sample(unit_box(6), {{"f"}}, one_output(sine), {.tolerance = 1e-7});
  CHECK(one.tolerance_met());
  CHECK(independent_error(one, sine) < 2e-7);
  for (const TrainCore& core : one.field->train().cores) CHECK(core.right == 1);
  // Only the coordinate that matters got nodes.
  for (int k = 0; k < 6; ++k) CHECK((one.field->axes()[static_cast<std::size_t>(k)].size() > 3) == (k == 2));
}

TEST_CASE("a small range on a large offset is resolved, and where rounding does not allow it, missed") {
  struct Case {
    double amplitude, tolerance;
    bool is_met;
  };
  // Doubles of 1e6 lie 1.2e-10 apart: 6e-7 of the first range, 6e-5 of the second.
  for (const Case& one : {Case{1e-4, 1e-4, true}, Case{1e-6, 1e-5, false}}) {
    const auto f = [&](std::span<const double> x) {
      return 1e6 + one.amplitude * std::sin(3.0 * x[0] * x[1] + x[2]);
    };
    const SamplingResult result =
        sample(unit_box(3), {{"f"}}, one_output(f), {.tolerance = one.tolerance, .max_calls = 3000});
    CHECK(result.tolerance_met() == one.is_met);
    if (result.tolerance_met()) CHECK(independent_error(result, f) < 3.0 * one.tolerance);
  }
}

TEST_CASE("the error of the field that is kept is measured at all points that were called") {
  // A spike that some later point meets: what was kept before cannot go on claiming a small error.
  const Scalar f = [](std::span<const double> x) {
    return x[0] * x[1] + std::exp(-(std::pow(x[0] - 0.6123, 2) + std::pow(x[1] - 0.237, 2)) / 9e-4);
  };
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const SamplingResult result =
        sample(unit_box(2), {{"f"}}, one_output(f), {.tolerance = 1e-4, .max_calls = 4000, .seed = seed});
    if (result.tolerance_met() || result.range[0] < 1.2) continue;  // it was not seen
    CHECK(result.error > 0.1 * independent_error(result, f));
  }
}

TEST_CASE("all outputs come from the same calls, each to the tolerance of its own range") {
  long calls = 0;
  const PointsFunction f = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    calls += points.cols();
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      for (Eigen::Index m = 0; m < 40; ++m) {
        const double t = 0.05 * static_cast<double>(m);
        // Sizes over six decades.
        values(m, j) = std::pow(10.0, static_cast<double>(m % 7) - 3.0) * std::exp(-points(0, j) * t) *
                       std::cos(t + points(1, j));
      }
    }
  };
  const std::vector<OutputLabel> outputs(40, OutputLabel{"u"});
  const SamplingResult result =
      sample(unit_box(2), outputs, f, {.tolerance = 1e-8, .exploration_points = 100});
  REQUIRE(result.tolerance_met());
  CHECK(calls == result.calls);
  CHECK(result.calls < 800);
  Eigen::MatrixXd point(2, 1), exact(40, 1);
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    point << random.uniform(), random.uniform();
    f(point, exact);
    const Eigen::VectorXd value = (*result.field)(std::vector<double>{point(0, 0), point(1, 0)});
    CHECK(((value - exact.col(0)).array() / result.range.array()).abs().maxCoeff() < 3e-8);
  }
}

TEST_CASE("no point is asked for twice, and the same seed asks for the same points") {
  std::set<std::vector<double>> first, second;
  for (std::set<std::vector<double>>* seen : {&first, &second}) {
    long calls = 0;
    const SamplingResult result = sample(unit_box(3), {{"f"}}, one_output([&](std::span<const double> x) {
                                           ++calls;
                                           seen->insert({x.begin(), x.end()});
                                           return std::exp(x[0] * x[1]) + x[2];
                                         }));
    CHECK(static_cast<long>(seen->size()) == calls);
    CHECK(result.calls == calls);
  }
  CHECK(first == second);
}

TEST_CASE("of a single coordinate whose transform is chosen, no point is asked for twice either") {
  std::set<double> seen;
  long calls = 0;
  const SamplingResult result =
      sample({{{"a"}, 0.5, 2.0}}, {{"f"}}, one_output([&](std::span<const double> x) {
               ++calls;
               seen.insert(x[0]);
               return std::exp(x[0]);
             }),
             {.exploration_points = 50});
  REQUIRE(result.tolerance_met());
  CHECK(static_cast<long>(seen.size()) == calls);
  CHECK(result.calls == calls);
}

TEST_CASE("a coordinate over decades gets the transform under which it is smooth") {
  const Scalar f = [](std::span<const double> x) { return std::log(x[0]) * std::log(x[0]) + x[1] / x[2]; };
  const SamplingResult result = sample({{{"a"}, 1e-3, 1e3}, {{"b"}, -1.0, 1.0}, {{"c"}, 1.0, 100.0}}, {{"f"}},
                                       one_output(f), {.tolerance = 1e-9, .exploration_points = 200});
  REQUIRE(result.tolerance_met());
  CHECK(result.field->axes()[0].transform() == Transform::logarithm);
  CHECK(result.field->axes()[1].transform() == Transform::none);
  CHECK(result.field->axes()[2].transform() == Transform::reciprocal);
  CHECK(result.calls < 700);
  SampledCoordinate fixed = {{"a"}, 0.1, 10.0};
  fixed.try_transforms = false;
  const SamplingResult plain =
      sample({fixed}, {{"f"}}, one_output([](std::span<const double> x) { return std::log(x[0]); }),
             {.tolerance = 1e-4});
  CHECK(plain.field->axes()[0].transform() == Transform::none);
}

TEST_CASE("what goes wrong in the function is reported with its point, and the work so far is kept") {
  const Scalar good = [](std::span<const double> x) { return std::exp(x[0] + x[1]) / (1.0 + x[2]); };
  // Enough good calls for a first interpolant.
  long calls = 0;
  const SamplingResult broken =
      sample(unit_box(3), {{"f"}},
             one_output([&](std::span<const double> x) { return ++calls > 150 ? std::nan("") : good(x); }),
             {.tolerance = 1e-12});
  CHECK(broken.status == samara::Termination::not_finite);
  CHECK_THAT(broken.message, Contains("f is nan at a = "));
  CHECK(broken.bad_point.size() == 3);
  CHECK(broken.field);
  calls = 0;
  const SamplingResult thrown = sample(unit_box(3), {{"f"}}, one_output([&](std::span<const double> x) {
                                         if (++calls > 150) throw std::runtime_error("the pump broke");
                                         return good(x);
                                       }),
                                       {.tolerance = 1e-12});
  CHECK(thrown.status == samara::Termination::failed);
  CHECK_THAT(thrown.message, Contains("the pump broke") && Contains("a = "));
  CHECK(thrown.bad_point.size() == 3);
  const SamplingResult none =
      sample(unit_box(2), {{"f"}}, one_output([](std::span<const double>) -> double { throw 42; }));
  CHECK(none.status == samara::Termination::failed);
  CHECK_FALSE(none.field);
  CHECK(std::isinf(none.error));
  const SamplingResult table = sample(
      unit_box(2), {{"f"}}, [](const Eigen::MatrixXd&, Eigen::MatrixXd& values) { values.resize(2, 2); });
  CHECK_THAT(table.message, Contains("2 x 2"));
}

TEST_CASE("a kink and a pole are missed, and reported with a point beside them") {
  const SamplingResult kink = sample(
      unit_box(3), {{"f"}}, one_output([](std::span<const double> x) { return std::abs(sum_of(x) - 1.4); }),
      {.tolerance = 1e-4, .max_calls = 3000});
  REQUIRE_FALSE(kink.tolerance_met());
  REQUIRE(kink.worst_point.size() == 3);
  CHECK(std::abs(sum_of(kink.worst_point) - 1.4) < 0.1);
  CHECK_THAT(kink.message, Contains(", most at a = "));
  // The range grows with every point near the pole, and the errors over it hang on the worst of them.
  const SamplingResult pole = sample(
      unit_box(2), {{"f"}}, one_output([](std::span<const double> x) { return 1.0 / (sum_of(x) - 0.74); }),
      {.tolerance = 1e-4, .max_calls = 3000});
  REQUIRE_FALSE(pole.tolerance_met());
  CHECK(std::abs(sum_of(pole.worst_point) - 0.74) < 0.05);
}

TEST_CASE("limits of calls and time, and cancellation, end with the best so far") {
  const Scalar f = [](std::span<const double> x) { return std::cos(9.0 * sum_of(x)) / (1.1 - x[0] * x[1]); };
  const SamplingResult calls =
      sample(unit_box(4), {{"f"}}, one_output(f), {.tolerance = 1e-9, .max_calls = 500});
  CHECK(calls.status == samara::Termination::max_calls);
  CHECK(calls.calls <= 500);
  CHECK(calls.field);
  CHECK_THAT(calls.message, Contains("of the 500 allowed"));
  const SamplingResult time =
      sample(unit_box(4), {{"f"}}, one_output(f), {.tolerance = 1e-9, .max_seconds = 1e-9});
  CHECK(time.status == samara::Termination::max_seconds);
  int reports = 0;
  const SamplingResult cancelled =
      sample(unit_box(4), {{"f"}}, one_output(f),
             {.tolerance = 1e-9, .progress = [&](const samara::Progress&) { return ++reports < 10; }});
  CHECK(cancelled.status == samara::Termination::cancelled);
  const SamplingResult narrow =
      sample(unit_box(4), {{"f"}}, one_output(f), {.tolerance = 1e-9, .max_rank = 2, .max_nodes = 4});
  CHECK(narrow.status == samara::Termination::exhausted);
}

TEST_CASE("pivots of a similar function save calls where features are narrow") {
  const auto peaks = [](double shift) {
    return one_output([shift](std::span<const double> x) {
      double a = 0.0, b = 0.0;
      for (const double value : x) {
        a += std::pow(value - 0.3 - shift, 2);
        b += std::pow(value - 0.7, 2);
      }
      return std::exp(-a / 0.04) + std::exp(-b / 0.04);
    });
  };
  // Single builds differ by luck as much as by their start.
  long cold_calls = 0, warm_calls = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    SamplingOptions options{.tolerance = 1e-3, .exploration_points = 50, .seed = seed};
    const SamplingResult other = sample(unit_box(4), {{"f"}}, peaks(0.0), options);
    const SamplingResult cold = sample(unit_box(4), {{"f"}}, peaks(0.01), options);
    options.start = other.pivots;
    const SamplingResult warm = sample(unit_box(4), {{"f"}}, peaks(0.01), options);
    REQUIRE(cold.tolerance_met());
    REQUIRE(warm.tolerance_met());
    cold_calls += cold.calls;
    warm_calls += warm.calls;
  }
  CHECK(warm_calls < cold_calls);
}

TEST_CASE("a smooth function is called in large batches, few of them") {
  const Scalar f = [](std::span<const double> x) {
    return std::cos(x[0] + 2.0 * x[1] * x[2]) / (1.5 + x[3] + 0.5 * x[4] * x[0]);
  };
  std::vector<SampledCoordinate> box = unit_box(5);
  for (SampledCoordinate& c : box) c.lower = 0.1;  // so that transforms are tried
  long batches = 0, calls = 0;
  const PointsFunction counted = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    ++batches;
    calls += points.cols();
    one_output(f)(points, values);
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const SamplingResult result = sample(box, {{"f"}}, counted, {.tolerance = 1e-6, .seed = seed});
    REQUIRE(result.tolerance_met());
    // A pivot at every bond takes two batches, however many bonds there are.
    INFO(calls << " calls, " << batches << " batches");
    CHECK(calls > 30 * batches);
    calls = batches = 0;
  }
}

TEST_CASE("calls that make no sense are refused by name") {
  const PointsFunction f = one_output([](std::span<const double>) { return 0.0; });
  CHECK_THROWS_WITH(sample({}, {{"f"}}, f), Contains("number of coordinates is 0"));
  CHECK_THROWS_WITH(sample({{{"a"}, 1.0, 1.0}}, {{"f"}}, f), Contains("a goes from 1 to 1"));
  CHECK_THROWS_WITH(sample({{{"a"}, 0.0, std::nan("")}}, {{"f"}}, f), Contains("expected an interval"));
  CHECK_THROWS_WITH(sample({{{"a"}, 0.0, 1.0}, {{"a"}, 0.0, 1.0}}, {{"f"}}, f), Contains("two coordinates"));
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, f, {.tolerance = 0.0}), Contains("tolerance is 0"));
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, f, {.max_calls = 0}), Contains("max_calls is 0"));
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, f, {.max_nodes = 2}), Contains("max_nodes is 2"));
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, f, {.exploration_points = -1}),
                    Contains("exploration_points is -1"));
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, {}), Contains("no function"));
  CHECK_THROWS_WITH(sample({{{"a"}, -1.7e308, 1.7e308}}, {{"f"}}, f), Contains("a goes from"));
  const Eigen::VectorXd infinite = Eigen::VectorXd::Constant(1, INFINITY);
  CHECK_THROWS_WITH(sample(unit_box(1), {{"f"}}, f, {.absolute = infinite}), Contains("absolute"));
  CHECK_THROWS_WITH(sample(unit_box(2), {{"f"}}, f, {.start = Eigen::MatrixXd::Zero(3, 1)}),
                    Contains("start has 3 coordinates"));
  SampledCoordinate wrong = {{"a", "1", AxisRole::parameter, Transform::logarithm}, -1.0, 1.0};
  CHECK_THROWS_WITH(sample({wrong}, {{"f"}}, f), Contains("log") && Contains("does not allow"));
}
