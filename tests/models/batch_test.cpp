#include "samara/models/batch/batch.h"

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <random>
#include <stdexcept>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "samara/base/errors.h"
#include "samara/models/batch/watch_batch.h"
#include "samara/models/integrators/rk4.h"
#include "samara/models/laws/registry.h"
#include "scalar_model.h"

using namespace samara::models;
using Catch::Matchers::WithinAbs;
using Catch::Matchers::WithinRel;

namespace {

const std::vector<std::string> kFree = {"C_D90", "C_R", "ux(0)"};

/// So many points that the last pack of any machine is not full.
Eigen::MatrixXd card_points(Eigen::Index count = 101) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  Eigen::MatrixXd points(count, 3);
  for (Eigen::Index n = 0; n < count; ++n) {
    points.row(n) << 0.4 + share(random), 0.5 + share(random), 0.1 * share(random);
  }
  return points;
}

std::vector<double> point(const Eigen::MatrixXd& points, Eigen::Index n) {
  const Eigen::VectorXd q = points.row(n);
  return {q.begin(), q.end()};
}

bool same_bits(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

/// Largest difference over the largest entry of its row (a state).
double relative_difference(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  const Eigen::VectorXd size = b.rowwise().lpNorm<Eigen::Infinity>().cwiseMax(1e-300);
  return (size.cwiseInverse().asDiagonal() * (a - b)).cwiseAbs().maxCoeff();
}

constexpr std::array kTimes = {0.0, 0.05, 0.2};

}  // namespace

TEST_CASE("a batch takes the steps of single trajectories") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points();
  const BatchTrajectories batch = integrate_batch(card, points, kTimes);
  REQUIRE(batch.states.cols() == 101 * 3);
  Rk4Integrator single(card);
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    CHECK(batch.status[static_cast<std::size_t>(n)] == BatchStatus::done);
    CHECK(batch.reached[n] == 0.2);
    const Trajectory trajectory = single(point(points, n), kTimes);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::VectorXd state = trajectory.states.row(k);
      // The same operations in the same order; 200 steps leave room for a compiler that orders them
      // otherwise.
      CHECK((batch.states.col(batch.column(n, k)) - state).lpNorm<Eigen::Infinity>() <=
            1e-13 * state.lpNorm<Eigen::Infinity>());
    }
  }
}

TEST_CASE("packs with sines and cosines take the steps of single trajectories to round-off") {
  const ParametricModel plate(find_model("falling_plate_nd"), {}, {"C_T", "theta(0)"});
  Eigen::MatrixXd points(11, 2);
  for (Eigen::Index n = 0; n < 11; ++n)
    points.row(n) << 0.8 + 0.05 * static_cast<double>(n), 0.3 * static_cast<double>(n);
  const std::array times = {2.0};
  const BatchTrajectories batch = integrate_batch(plate, points, times, {.step = 0.01});
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const Trajectory trajectory = integrate_rk4(plate, point(points, n), times, {.step = 0.01});
    // Sines of packs differ from those of the C library in the last bit; the motion spreads that little by
    // little.
    CHECK((batch.states.col(n) - trajectory.states.row(0).transpose()).cwiseAbs().maxCoeff() < 1e-12);
  }
}

TEST_CASE("the number of threads does not change a bit of a batch") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points();
  const BatchOptions options = {.threads = 1, .tangents = {"C_R"}};
  const BatchTrajectories alone = integrate_batch(card, points, kTimes, options);
  for (const int threads : {0, 2, 5}) {
    BatchOptions shared = options;
    shared.threads = threads;
    const BatchTrajectories batch = integrate_batch(card, points, kTimes, shared);
    CHECK(same_bits(batch.states, alone.states));
    CHECK(same_bits(batch.tangents[0], alone.tangents[0]));
  }
}

TEST_CASE("the tangents of a batch are the sensitivities of the reference integrator") {
  // Six directions: more than one pass of the kernels; `a` acts through derived masses and inertias too.
  const std::vector<std::string> free = {"C_D90", "C_R", "a", "ux(0)", "wy(0)", "C_w"};
  const ParametricModel card = falling_card(free);
  Eigen::MatrixXd points(3, 6);
  points << 0.61, 1.21, 0.035, 0.05, 2.0, 2.0,  //
      0.81, 0.91, 0.03, 0.02, 1.0, 2.5,         //
      1.00, 1.50, 0.04, 0.00, 0.0, 1.5;
  const std::array times = {0.05, 0.15};
  const BatchTrajectories batch = integrate_batch(card, points, times, {.step = 2e-4, .tangents = free});
  Integrator reference(card, {}, true);
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const Trajectory trajectory = reference(point(points, n), times);
    for (std::size_t j = 0; j < free.size(); ++j) {
      const Eigen::MatrixXd expected = trajectory.sensitivities[j].transpose();
      const Eigen::MatrixXd tangents = batch.tangents[j].middleCols(batch.column(n, 0), 2);
      // The error of the steps: (h / 2 ms)^4 of the states (rk4_test), times what a derivative makes of it.
      CHECK((tangents - expected).norm() < 1e-5 * expected.norm());
    }
  }
}

TEST_CASE("the tangents of a batch are the slopes of its states") {
  const ParametricModel card = falling_card(kFree);
  const double step = 1e-6;
  Eigen::MatrixXd points = card_points(3);
  points.row(1) = points.row(0);
  points.row(2) = points.row(0);
  points(1, 1) += step;
  points(2, 1) -= step;
  const BatchTrajectories batch = integrate_batch(card, points, std::array{0.1}, {.tangents = {"C_R"}});
  const Eigen::VectorXd slope = (batch.states.col(1) - batch.states.col(2)) / (2.0 * step);
  // Round-off eps/step = 2e-10 of the states, which are about as large as their slopes.
  CHECK((batch.tangents[0].col(0) - slope).norm() < 1e-7 * slope.norm());
}

TEST_CASE("a trajectory that ceases to exist does not harm those beside it") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points(20);
  Eigen::MatrixXd spoiled = points;
  spoiled(5, 2) = 1e200;  // its square overflows
  const BatchTrajectories clean = integrate_batch(card, points, kTimes, {.tangents = {"C_D90"}});
  const BatchTrajectories batch = integrate_batch(card, spoiled, kTimes, {.tangents = {"C_D90"}});
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const bool bad = n == 5;
    CHECK((batch.status[static_cast<std::size_t>(n)] == BatchStatus::not_finite) == bad);
    CHECK(batch.reached[n] == (bad ? 0.0 : 0.2));
    if (bad) continue;
    CHECK(same_bits(batch.states.middleCols(3 * n, 3), clean.states.middleCols(3 * n, 3)));
    CHECK(same_bits(batch.tangents[0].middleCols(3 * n, 3), clean.tangents[0].middleCols(3 * n, 3)));
  }
  CHECK(batch.states(7, batch.column(5, 0)) == 1e200);
  CHECK(batch.states.col(batch.column(5, 1)).array().isNaN().all());
  CHECK(batch.tangents[0].col(batch.column(5, 2)).array().isNaN().all());
}

TEST_CASE("models without kernels run in batches too, with tangents") {
  const ParametricModel card = falling_card({"C_R", "a", "wx(0)"});
  const std::vector<std::string> free = {"C_R", "a", "wx(0)"};
  const ParametricModel plain(std::make_shared<PlainModel>(card.shared_model()), card.fixed(), free);
  Eigen::MatrixXd points(9, 3);
  for (Eigen::Index n = 0; n < 9; ++n) points.row(n) << 1.0 + 0.1 * static_cast<double>(n), 0.035, 1.0;
  const BatchOptions options = {.threads = 2, .tangents = free};
  const BatchTrajectories by_kernel = integrate_batch(card, points, std::array{0.1}, options);
  const BatchTrajectories by_rhs = integrate_batch(plain, points, std::array{0.1}, options);
  CHECK(relative_difference(by_rhs.states, by_kernel.states) < 1e-12);
  for (std::size_t j = 0; j < free.size(); ++j) {
    // Derivatives of the law by other rules of differentiation.
    CHECK(relative_difference(by_rhs.tangents[j], by_kernel.tangents[j]) < 1e-10);
  }
}

TEST_CASE("an observer sees the trajectories of the batch") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points();
  const std::array times = {0.0, 0.05, 0.1};
  const BatchTrajectories batch = integrate_batch(card, points, times);
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(13, batch.states.cols());
  const auto observe = [&](Eigen::Index n, double t, std::span<const double> state) {
    const auto k = static_cast<Eigen::Index>(std::lround(t / 0.05));
    seen.col(batch.column(n, k)) = Eigen::Map<const Eigen::VectorXd>(state.data(), 13);
    return true;
  };
  const WatchedBatch watched =
      watch_batch(card, points, observe, {.step = 1e-3, .interval = 0.05, .end = 0.1, .threads = 2});
  CHECK((watched.reached.array() == 0.1).all());
  CHECK(relative_difference(seen, batch.states) < 1e-13);
}

TEST_CASE("an observer ends trajectories one by one, and their lanes take others") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points();
  std::vector<int> calls(static_cast<std::size_t>(points.rows()), 0);
  // Trajectory n ends at its call n % 7.
  const auto observe = [&](Eigen::Index n, double t, std::span<const double>) {
    const int call = calls[static_cast<std::size_t>(n)]++;
    CHECK_THAT(t, WithinAbs(0.01 * call, 1e-15));
    return call < n % 7;
  };
  const WatchedBatch watched =
      watch_batch(card, points, observe, {.step = 1e-3, .interval = 0.01, .end = 0.05, .threads = 1});
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const int last = std::min<int>(static_cast<int>(n % 7), 5);
    CHECK(calls[static_cast<std::size_t>(n)] == last + 1);
    CHECK_THAT(watched.reached[n], WithinAbs(0.01 * last, 1e-15));
    CHECK(watched.status[static_cast<std::size_t>(n)] ==
          (n % 7 < 6 ? BatchStatus::stopped : BatchStatus::done));
  }
}

TEST_CASE("what lanes carried before does not change a bit of what an observer sees") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points();
  const auto landing = [&](int threads) {
    Eigen::VectorXd depth = Eigen::VectorXd::Zero(points.rows());
    const WatchedBatch watched =
        watch_batch(card, points,
                    [&](Eigen::Index n, double, std::span<const double> state) {
                      depth[n] = state[2];
                      return state[2] > -0.1;
                    },
                    {.step = 1e-3, .interval = 2e-3, .end = 0.3, .threads = threads});
    Eigen::MatrixXd both(points.rows(), 2);
    both << depth, watched.reached;
    return both;
  };
  const Eigen::MatrixXd alone = landing(1);
  CHECK((alone.col(0).array() <= -0.1).all());
  CHECK(same_bits(landing(2), alone));
}

TEST_CASE("a watched trajectory that ceases to exist is reported, others go on") {
  const ParametricModel card = falling_card(kFree);
  Eigen::MatrixXd points = card_points(20);
  points(3, 2) = 1e200;
  const WatchedBatch watched =
      watch_batch(card, points, [](Eigen::Index, double, std::span<const double>) { return true; },
                  {.interval = 0.01, .end = 0.05});
  for (Eigen::Index n = 0; n < 20; ++n) {
    CHECK(watched.status[static_cast<std::size_t>(n)] ==
          (n == 3 ? BatchStatus::not_finite : BatchStatus::done));
    CHECK(watched.reached[n] == (n == 3 ? 0.0 : 0.05));
  }
}

TEST_CASE("what an observer throws passes through") {
  const ParametricModel card = falling_card(kFree);
  CHECK_THROWS_WITH(watch_batch(card, card_points(),
                                [](Eigen::Index n, double, std::span<const double>) -> bool {
                                  if (n == 40) throw std::runtime_error("enough");
                                  return true;
                                }),
                    "enough");
}

TEST_CASE("batches refuse points, names and options without meaning") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points(4);
  CHECK_THROWS_WITH(integrate_batch(card, points.leftCols(2), kTimes),
                    "the points have 2 columns; one for each of the 3 free coordinates was expected");
  Eigen::MatrixXd negative = points;
  negative(2, 0) = -1.0;
  CHECK_THROWS_WITH(integrate_batch(card, negative, kTimes), Catch::StartsWith("point 2: \"C_D90\" is -1"));
  CHECK_THROWS_WITH(integrate_batch(card, points, kTimes, {.tangents = {"C_T"}}),
                    "tangents by \"C_T\" were asked for; a free coordinate was expected");
  CHECK_THROWS_AS(integrate_batch(card, points, kTimes, {.step = -1.0}), samara::ArgumentError);
  CHECK_THROWS_WITH(integrate_batch(card, points, kTimes, {.threads = -1}),
                    "threads is -1; 0 or more was expected");
  CHECK_THROWS_AS(integrate_batch(card, points, std::array{1.0, 0.5}), samara::ArgumentError);
  CHECK_THROWS_AS(watch_batch(card, points, {}), samara::ArgumentError);
  const auto go_on = [](Eigen::Index, double, std::span<const double>) { return true; };
  CHECK_THROWS_WITH(watch_batch(card, points, go_on, {.interval = 0.0}),
                    "interval is 0; a positive finite number was expected");
  CHECK_THROWS_WITH(watch_batch(card, points, go_on, {.end = std::nan("")}),
                    "end is nan; a positive finite number was expected");
}

TEST_CASE("a batch of nothing is nothing") {
  const BatchTrajectories batch = integrate_batch(falling_card(kFree), Eigen::MatrixXd(0, 3), kTimes);
  CHECK(batch.states.cols() == 0);
  CHECK(batch.status.empty());
}

TEST_CASE("batches that take more steps than allowed are not integrated") {
  const ParametricModel card = falling_card(kFree);
  const Eigen::MatrixXd points = card_points(3);
  const auto expect_none = [](const auto& batch) {
    for (const BatchStatus status : batch.status) CHECK(status == BatchStatus::too_many_steps);
    CHECK(batch.reached.isZero(0.0));
  };
  const auto unseen = [](Eigen::Index, double, std::span<const double>) -> bool {
    throw std::runtime_error("the observer was called");
  };
  for (const double step : {1e-20, 1e-300}) {
    const BatchTrajectories batch = integrate_batch(card, points, kTimes, {.step = step});
    expect_none(batch);
    CHECK(batch.states.array().isNaN().all());
    expect_none(watch_batch(card, points, unseen, {.step = step}));
  }
  expect_none(integrate_batch(card, points, kTimes, {.step = 1e-3, .max_steps = 199}));
  CHECK(integrate_batch(card, points, kTimes, {.step = 1e-3, .max_steps = 200}).status[0] ==
        BatchStatus::done);
}
