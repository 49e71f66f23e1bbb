// Markov chains: estimates, the order that is selected, and what tells a chain that is right from one that only
// reproduces how often each symbol comes.
#include <array>
#include <cmath>

#include <catch2/catch.hpp>

#include "samara/base/errors.h"
#include "samara/motion/chains/chain_check.h"
#include "tests/error_text.h"

using namespace samara::motion;

namespace {

using Sequences = std::vector<std::vector<int>>;

/// A chain of second order over three symbols, in which the symbol before the last decides most.
double planted(int before, int last, int next) {
  const double swerve = next == before ? 0.7 : 0.15;
  const double stay = next == last ? 0.6 : 0.2;
  double sum = 0.0;
  for (int j = 0; j < 3; ++j) sum += (j == before ? 0.7 : 0.15) * (j == last ? 0.6 : 0.2);
  return swerve * stay / sum;
}

Sequences planted_runs(std::size_t runs, std::size_t length, std::uint64_t seed) {
  Sequences all;
  for (std::size_t n = 0; n < runs; ++n) {
    samara::Stream stream(seed, n);
    std::vector<int> run = {0, 1};
    while (run.size() < length) {
      double left = stream.uniform();
      int next = 0;
      while (next < 2 && (left -= planted(run[run.size() - 2], run.back(), next)) >= 0.0) ++next;
      run.push_back(next);
    }
    all.push_back(run);
  }
  return all;
}

double true_likelihood(const Sequences& runs) {
  double sum = 0.0, count = 0.0;
  for (const auto& run : runs) {
    for (std::size_t k = 2; k < run.size(); ++k) {
      sum += std::log(planted(run[k - 2], run[k - 1], run[k]));
      count += 1.0;
    }
  }
  return sum / count;
}

Eigen::VectorXd occupancy(const Sequences& runs) {
  Eigen::VectorXd counts = Eigen::VectorXd::Zero(3);
  for (const auto& run : runs) {
    for (const int symbol : run) counts[symbol] += 1.0;
  }
  return counts / counts.sum();
}

}  // namespace

TEST_CASE(
    "of a planted chain of second order that order is selected, and its likelihood reached within 0.01 "
    "nats") {
  for (const std::uint64_t seed : {3u, 4u, 5u}) {
    const Sequences runs = planted_runs(100, 200, seed);
    const OrderChoice choice = select_order(runs, 3);
    CHECK(choice.order == 2);
    CHECK(choice.fitted_runs == 50);
    REQUIRE(choice.scores.size() == 6);
    const Sequences fresh = planted_runs(100, 200, seed + 100);
    const MarkovChain chain = MarkovChain::fitted(runs, 3, choice.order);
    CHECK(true_likelihood(fresh) - chain.log_likelihood(fresh, 2) < 0.01);
    CHECK(true_likelihood(fresh) - MarkovChain::fitted(runs, 3, 1).log_likelihood(fresh, 2) > 0.1);
  }
}

TEST_CASE("a chain of too low an order has the right occupancy, and fails on run lengths and double steps") {
  const Sequences runs = planted_runs(100, 200, 11), fresh = planted_runs(100, 200, 12);
  const MarkovChain right = MarkovChain::fitted(runs, 3, 2), wrong = MarkovChain::fitted(runs, 3, 1);
  samara::Stream stream(7, 0);
  const Eigen::VectorXd seen = occupancy(fresh), own = occupancy({wrong.draw_sequence(20000, stream)});
  CHECK((seen - own).cwiseAbs().maxCoeff() < 0.02);
  const ChainCheck good = check(right, fresh), bad = check(wrong, fresh);
  CHECK(good.chi_square.maxCoeff() < 20.0);
  CHECK(good.two_steps < 5.0);
  CHECK(bad.chi_square.maxCoeff() > 100.0);
  CHECK(bad.two_steps > 10.0);
}

namespace {

/// As short as those of falls that are cut at few events.
Sequences short_draws(const MarkovChain& chain, std::uint64_t seed) {
  Sequences all;
  for (std::size_t n = 0; n < 300; ++n) {
    samara::Stream stream(seed, n);
    all.push_back(chain.draw_sequence(8, stream));
  }
  return all;
}

bool is_rejected(const MarkovChain& chain, const Sequences& seen, std::uint64_t seed) {
  const ChainCheck worth = check(chain, seen, seed);
  for (Eigen::Index k = 0; k < worth.freedom.size(); ++k)
    REQUIRE((worth.freedom[k] > 0) == std::isfinite(worth.chi_square[k]));
  return worth.chi_square.maxCoeff() > worth.largest_95;
}

}  // namespace

TEST_CASE(
    "of short sequences lengths of runs reject an exact chain one time in twenty, and nearly always one of "
    "too low an order") {
  Eigen::Matrix4d stays = Eigen::Matrix4d::Constant(1e4);
  stays.diagonal().setConstant(7e4);
  const Sequences planted_long = planted_runs(100, 2000, 21);
  const MarkovChain second = MarkovChain::fitted(planted_long, 3, 2);
  const MarkovChain first = MarkovChain::fitted(planted_long, 3, 1);
  constexpr int kTimes = 60;
  int of_stays = 0, of_second = 0, of_first = 0;
  for (int k = 0; k < kTimes; ++k) {
    const auto seed = static_cast<std::uint64_t>(1000 + k);
    const MarkovChain exact = MarkovChain::of_counts(stays);
    of_stays += is_rejected(exact, short_draws(exact, seed), seed + 500) ? 1 : 0;
    const Sequences seen = short_draws(second, seed);
    of_second += is_rejected(second, seen, seed + 500) ? 1 : 0;
    of_first += is_rejected(first, seen, seed + 500) ? 1 : 0;
  }
  // 3 of 60 are expected; more than 8 come by chance one time in 250.
  CHECK(of_stays <= 8);
  CHECK(of_second <= 8);
  CHECK(of_stays + of_second >= 1);
  CHECK(of_first >= 54);
}

TEST_CASE("lengths of runs of which few are expected are taken together, for fewer degrees of freedom") {
  // Runs of the first symbol hardly go on; those of the second are of any length.
  const MarkovChain chain = MarkovChain::of_counts((Eigen::Matrix2d() << 3e3, 9e4, 3e4, 7e4).finished());
  const ChainCheck worth = check(chain, short_draws(chain, 5));
  CHECK(worth.freedom[0] == 1);
  CHECK(worth.freedom[1] == 4);
  // F_1(x) F_4(x) = 0.95: beyond either's own 95 % point, 3.841 and 9.488.
  CHECK(worth.largest_95 > 9.488);
  CHECK(worth.largest_95 < 9.7);
  const ChainCheck none = check(chain, {{0, 1, 0, 1}});
  CHECK(none.freedom.maxCoeff() == 0);
  CHECK(std::isnan(none.largest_95));
}

TEST_CASE(
    "shares are those of Dirichlet's prior, and contexts that were hardly seen give way to shorter ones") {
  // 0 1 0 1 0 1, and once 0 0.
  const MarkovChain chain = MarkovChain::fitted({{0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, {0, 0}}, 2, 2);
  const std::vector<int> one = {1}, zero = {0}, rare = {0, 0};
  CHECK(chain.probability(one, 0) == Approx(5.5 / 6.0));
  CHECK(chain.probability(zero, 1) == Approx(6.5 / 8.0));
  // The context 0 0 was never followed by anything: that of 0 stands in.
  CHECK(chain.probability(rare, 1) == Approx(6.5 / 8.0));
  const Chance share = chain.chance(zero, 1);
  CHECK(share.lower < share.probability);
  CHECK(share.probability < share.upper);
  // The uniform distribution is beta (1, 1): no counts of three kinds, each 1/3, by beta (1/2, 1).
  const Chance unseen = dirichlet_chance(0.0, 0.0, 3.0);
  CHECK(unseen.probability == Approx(1.0 / 3.0));
  CHECK(unseen.lower == Approx(0.025 * 0.025));  // the quantile p^2 of beta (1/2, 1)
  CHECK(unseen.upper == Approx(0.975 * 0.975));
  double sum = 0.0;
  for (int next = 0; next < 2; ++next) sum += chain.probability(rare, next);
  CHECK(sum == Approx(1.0));
}

TEST_CASE("draws have the probabilities of the chain") {
  const MarkovChain chain = MarkovChain::of_counts((Eigen::Matrix2d() << 9.5, 29.5, 59.5, 19.5).finished());
  samara::Stream stream(1, 0);
  const std::vector<int> drawn = chain.draw_sequence(40000, stream);
  double from = 0.0, to = 0.0;
  for (std::size_t k = 1; k < drawn.size(); ++k) {
    from += drawn[k - 1] == 0;
    to += drawn[k - 1] == 0 && drawn[k] == 1;
  }
  // Four standard errors of a share of 3/4 among some 20,000.
  CHECK(to / from == Approx(0.75).margin(4.0 * std::sqrt(0.75 * 0.25 / from)));
  CHECK(chain.matrix()(0, 1) == Approx(0.75));
}

TEST_CASE("draws among some symbols have the probabilities of the chain given that it is one of them") {
  const MarkovChain chain =
      MarkovChain::of_counts((Eigen::Matrix3d() << 9.5, 29.5, 59.5, 1, 1, 1, 1, 1, 1).finished());
  const std::array<char, 3> without_last = {0, 0, 1}, only_last = {1, 1, 0}, all = {0, 0, 0};
  const std::vector<int> past = {0};
  samara::Stream stream(2, 0), plain(3, 0), same(3, 0);
  double second = 0.0;
  for (int k = 0; k < 20000; ++k) {
    const int drawn = chain.draw(past, without_last, stream);
    REQUIRE(drawn < 2);
    second += drawn;
    REQUIRE(chain.draw(past, only_last, stream) == 2);
    REQUIRE(chain.draw(past, all, same) == chain.draw(past, plain));
  }
  // 30 of 40, within four standard errors.
  CHECK(second / 20000.0 == Approx(0.75).margin(4.0 * std::sqrt(0.75 * 0.25 / 20000.0)));
}

TEST_CASE(
    "the source's chain has the smallest counts that give its printed digits, and its times to the end") {
  const SourceChain source = source_chain();
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::VectorXd p = source.counts.row(i) / source.counts.row(i).sum();
    CHECK((1000.0 * p.transpose() - 1000.0 * source.printed.row(i)).cwiseAbs().maxCoeff() < 0.5 + 1e-9);
  }
  const Absorption end = absorption(source.printed, {false, false, false, true});
  CHECK(end.fundamental(0, 0) == Approx(1.1820331).epsilon(1e-7));
  CHECK(end.fundamental(0, 1) == Approx(0.73757333).epsilon(1e-7));
  CHECK(end.fundamental(1, 2) == Approx(0.40052907).epsilon(1e-7));
  CHECK(end.times[0] == Approx(2.23095287).epsilon(1e-8));
  CHECK(end.times[1] == Approx(2.02127461).epsilon(1e-8));
  CHECK(end.times[2] == Approx(2.87356322).epsilon(1e-8));
  // SD to AZ rests on one observation.
  const Chance rare = MarkovChain::of_counts(source.counts).chance(std::vector<int>{0}, 2);
  CHECK(rare.lower < 0.01);
  CHECK(rare.upper > 0.15);
}

TEST_CASE("run lengths leave out runs that a sequence cuts") {
  const Eigen::VectorXd lengths = run_lengths({{1, 1, 0, 1, 1, 1, 0, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1}}, 1);
  CHECK(lengths == (Eigen::VectorXd(5) << 1, 0, 1, 0, 1).finished());
}

TEST_CASE("what is no chain is refused") {
  CHECK(error_text<samara::ArgumentError>([] {
          MarkovChain::fitted({{0, 4}}, 4, 1);
        }) == "a sequence has the symbol 4, expected one from 0 to 3");
  CHECK(error_text<samara::ArgumentError>([] { MarkovChain::fitted({{0}}, 4, 9); }).find("expected 0 to 8") !=
        std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] {
          select_order({{0, 1, 0, 1, 0, 1, 0}}, 2);
        }).find("expected two") != std::string::npos);
  CHECK(error_text<samara::ArgumentError>([] {
          absorption((Eigen::Matrix2d() << 1, 0, 0, 1).finished(), {false, true});
        }) == "from state 0 no end is ever reached");
  CHECK(error_text<samara::ArgumentError>([] {
          MarkovChain::of_counts((Eigen::Matrix2d() << 1, NAN, 0, 1).finished());
        }).find("finite") != std::string::npos);
}
