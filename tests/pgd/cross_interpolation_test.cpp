#include "samara/pgd/cross/cross_interpolation.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include <catch2/catch.hpp>

#include "random_tensor.h"
#include "samara/base/errors.h"
#include "samara/pgd/cross/entry_table.h"

using namespace samara::pgd;
using Catch::Matchers::Contains;
using samara::Termination;

namespace {

/// Node i of n equidistant ones of [0, 1].
double node(int i, int n) {
  return n > 1 ? static_cast<double>(i) / (n - 1) : 0.0;
}

/// A function on equidistant nodes of the unit cube that keeps a list of the entries it was asked for.
class Sampled {
 public:
  using Value = std::function<double(int output, const std::vector<double>& x)>;
  Sampled(std::vector<int> sizes, int outputs, Value value)
      : sizes_(std::move(sizes)), outputs_(outputs), value_(std::move(value)) {}
  Sampled(std::vector<int> sizes, std::function<double(const std::vector<double>&)> value)
      : Sampled(std::move(sizes), 1, [value](int, const std::vector<double>& x) { return value(x); }) {}

  CrossResult interpolate(const CrossOptions& options) {
    asked_.clear();
    repeated_ = 0;
    return samara::pgd::interpolate(
        [this](const IndexBatch& entries, Eigen::MatrixXd& values) {
          for (Eigen::Index j = 0; j < entries.cols(); ++j) {
            const std::vector<int> index(entries.col(j).begin(), entries.col(j).end());
            if (!asked_.insert(index).second) ++repeated_;
            for (int m = 0; m < outputs_; ++m) values(m, j) = at(m, index);
          }
        },
        outputs_, sizes_, options);
  }

  double at(int output, const std::vector<int>& index) const {
    std::vector<double> x(index.size());
    for (std::size_t k = 0; k < x.size(); ++k) x[k] = node(index[k], sizes_[k]);
    return value_(output, x);
  }
  /// Largest difference over the outputs at one entry.
  double error(const TensorTrain& train, const std::vector<int>& index) const {
    std::vector<int> entry = {0};
    entry.insert(entry.end(), index.begin(), index.end());
    double largest = 0.0;
    for (int m = 0; m < outputs_; ++m) {
      entry[0] = m;
      largest = std::max(largest, std::abs(train.entry(entry) - at(m, index)));
    }
    return largest;
  }
  double grid_error(const TensorTrain& train) const {
    double largest = 0.0;
    for_every_entry(sizes_,
                    [&](const std::vector<int>& index) { largest = std::max(largest, error(train, index)); });
    return largest;
  }
  /// Errors at random entries that do not depend on those of the builder.
  Eigen::VectorXd fresh_errors(const TensorTrain& train, int count, std::uint64_t seed) const {
    Random random(seed);
    Eigen::VectorXd errors(count);
    std::vector<int> index(sizes_.size());
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < index.size(); ++k) index[k] = random.below(sizes_[k]);
      errors[i] = error(train, index);
    }
    return errors;
  }

  const std::vector<int>& sizes() const { return sizes_; }
  const std::set<std::vector<int>>& asked() const { return asked_; }
  int repeated() const { return repeated_; }

 private:
  std::vector<int> sizes_;
  int outputs_;
  Value value_;
  std::set<std::vector<int>> asked_;
  int repeated_ = 0;
};

double sum(const std::vector<double>& x) {
  double total = 0.0;
  for (const double value : x) total += value;
  return total;
}

Sampled rational(std::vector<int> sizes) {
  return {std::move(sizes), [](const std::vector<double>& x) { return 1.0 / (1.0 + sum(x)); }};
}

/// Smooth but for a block of `width`^3 nodes (of 20^3) in which it is larger by one.
Sampled with_block(int width) {
  return {{20, 20, 20}, [width](const std::vector<double>& x) {
            const auto inside = [&](std::size_t k, int first) {
              const int i = static_cast<int>(std::lround(19.0 * x[k]));
              return i >= first && i < first + width;
            };
            return 1.0 / (1.0 + sum(x)) + (inside(0, 7) && inside(1, 3) && inside(2, 11) ? 1.0 : 0.0);
          }};
}

/// Without structure: no rank below the full one helps.
Sampled noise(std::vector<int> sizes) {
  return {std::move(sizes), [](const std::vector<double>& x) {
            double key = 0.0;
            for (const double value : x) key = 1000.0 * key + 999.0 * value;
            return Random(static_cast<std::uint64_t>(std::llround(key))).normal();
          }};
}

}  // namespace

TEST_CASE("a function of low rank is recovered exactly from far fewer entries than the grid has") {
  struct Case {
    std::vector<int> sizes;
    double share;  ///< of the grid that may be asked for
  };
  // Rank 3 needs about (3 + random pivots) fibres on either side of a core and 200 guard entries: some
  // 2 * 10 * n * 10 entries in the middle of five modes.
  for (const Case& c : {Case{{40}, 1.0},
                        {{100, 100}, 0.25},
                        {{30, 20, 40}, 0.35},
                        {{12, 12, 12, 12, 12}, 0.04},
                        {{15, 1, 30, 1, 20}, 0.6}}) {
    for (const int outputs : {1, 4}) {
      std::vector<int> all = {outputs};
      all.insert(all.end(), c.sizes.begin(), c.sizes.end());
      const SeparatedTensor exact = random_tensor(all, 3, 17);
      Sampled function(c.sizes, outputs, [&](int m, const std::vector<double>& x) {
        std::vector<int> index = {m};
        for (std::size_t k = 0; k < x.size(); ++k)
          index.push_back(static_cast<int>(std::lround(x[k] * (c.sizes[k] - 1))));
        return exact.entry(index);
      });
      const CrossResult result = function.interpolate({.tolerance = 1e-8});
      CAPTURE(c.sizes, outputs, result.message);
      CHECK(result.status == Termination::converged);
      // Round-off of entries of size `largest`, amplified by the coefficients of the maximal volume
      // submatrices, which are at most rank times their bound per mode.
      CHECK(function.fresh_errors(result.train, 2000, 3).maxCoeff() < 1e-11 * result.largest);
      CHECK(static_cast<double>(result.evaluations) <= c.share * result.grid_size);
      // Only the outputs are kept whole.
      const std::vector<int> ranks = result.train.ranks();
      CHECK(ranks[0] == outputs);
      for (std::size_t k = 1; k < ranks.size(); ++k) CHECK(ranks[k] <= 3);
    }
  }
}

TEST_CASE("smooth functions meet the tolerance at fresh entries") {
  const auto wave = [](const std::vector<double>& x) { return std::sin(5.0 * sum(x)); };
  const auto bump = [](const std::vector<double>& x) { return std::exp(-3.0 * x[0] * x[1] * x[2]); };
  for (Sampled function : {rational({30, 30, 30}), rational({9, 9, 9, 9, 9}), Sampled({14, 14, 14, 14}, wave),
                           Sampled({30, 30, 30}, bump)}) {
    for (const double tolerance : {1e-4, 1e-8}) {
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        const CrossResult result = function.interpolate({.tolerance = tolerance, .seed = seed});
        CAPTURE(function.sizes(), tolerance, seed, result.message);
        CHECK(result.status == Termination::converged);
        CHECK(result.guard_error <= tolerance);
        CHECK(static_cast<double>(result.evaluations) < 0.5 * result.grid_size);
        // The guard has seen 200 entries, these are ten times as many: their largest error may be somewhat
        // larger, but a smooth error has no lonely peaks.
        CHECK(function.fresh_errors(result.train, 2000, 100 + seed).maxCoeff() <= 3.0 * tolerance);
      }
    }
  }
}

TEST_CASE("at kinks and narrow peaks the tolerance holds for almost all entries") {
  // |x + y - z| has full rank on the grid, and the peaks cover a few nodes: the interpolation stops when the
  // guard no longer finds the entries that it represents badly. If more than a share p of all entries misses
  // the tolerance, 200 guard entries all pass with a probability below (1 - p)^200: 8e-4 for p = 3.5 %.
  const auto peak = [](double width) {
    return [width](const std::vector<double>& x) {
      // Not aligned with the axes, along which it would be a product.
      const double a = x[0] - 0.3, b = x[1] - 0.7, c = x[2] - 0.6, d = a + b + c;
      return std::exp(-(a * a + b * b + c * c + 3.0 * d * d) / (2.0 * width * width));
    };
  };
  for (Sampled function :
       {Sampled({30, 30}, [](const std::vector<double>& x) { return std::abs(x[0] + x[1] - 1.0); }),
        Sampled({20, 20, 20}, [](const std::vector<double>& x) { return std::abs(x[0] + x[1] - x[2]); }),
        Sampled({20, 20, 20}, peak(0.2)), Sampled({20, 20, 20}, peak(0.1)),
        Sampled({20, 20, 20}, peak(0.05))}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const double tolerance = 1e-4;
      const CrossResult result = function.interpolate({.tolerance = tolerance, .seed = seed});
      CAPTURE(function.sizes(), seed, result.message);
      if (result.status != Termination::converged) continue;
      const Eigen::VectorXd errors = function.fresh_errors(result.train, 4000, 50 + seed);
      CHECK(static_cast<double>((errors.array() > tolerance).count()) / 4000.0 < 0.035);
    }
  }
  // A kink along a grid line costs nothing: the function is a product.
  Sampled aligned({30, 30}, [](const std::vector<double>& x) { return std::abs(x[0] - 0.5); });
  const CrossResult result = aligned.interpolate({.tolerance = 1e-12});
  CHECK(result.status == Termination::converged);
  CHECK(result.train.ranks() == std::vector<int>{1, 1});
  CHECK(aligned.grid_error(result.train) < 1e-14);
}

TEST_CASE("no entry is asked for twice and all are counted") {
  for (Sampled function : {rational({20, 20, 20}), noise({8, 9, 7}), rational({5}), rational({3, 4})}) {
    const CrossResult result = function.interpolate({.tolerance = 1e-9, .max_sweeps = 6});
    CAPTURE(function.sizes(), result.message);
    CHECK(function.repeated() == 0);
    CHECK(result.evaluations == static_cast<long>(function.asked().size()));
    double grid = 1.0;
    for (const int n : function.sizes()) grid *= n;
    CHECK(result.grid_size == grid);
    CHECK(static_cast<double>(result.evaluations) <= grid);
  }
}

TEST_CASE("constants and zero have rank one and need one sweep") {
  for (const double value : {0.0, -3.5}) {
    Sampled function({15, 12, 10}, 2,
                     [&](int m, const std::vector<double>&) { return m == 0 ? value : 0.0; });
    const CrossResult result = function.interpolate({.tolerance = 1e-10});
    CHECK(result.status == Termination::converged);
    CHECK(result.sweeps == 1);
    CHECK(result.largest == std::abs(value));
    CHECK(result.train.ranks() == std::vector<int>{2, 1, 1});
    CHECK(function.grid_error(result.train) <= 1e-15 * std::abs(value));
  }
}

TEST_CASE("a function below the tolerance is taken for zero or better") {
  Sampled function({15, 12, 10}, [](const std::vector<double>& x) { return 1e-9 * std::sin(9.0 * sum(x)); });
  const CrossResult result = function.interpolate({.tolerance = 1e-6});
  CHECK(result.status == Termination::converged);
  CHECK(function.grid_error(result.train) <= 1e-6);
}

TEST_CASE("pivots of a similar function save evaluations") {
  Sampled function = rational({30, 30, 30, 30});
  Sampled changed({30, 30, 30, 30}, [](const std::vector<double>& x) {
    return 1.0 / (1.05 + 0.98 * x[0] + x[1] + 1.03 * x[2] + x[3]);
  });
  const CrossResult first = function.interpolate({.tolerance = 1e-7});
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const CrossResult cold = changed.interpolate({.tolerance = 1e-7, .seed = seed});
    const CrossResult warm = changed.interpolate({.tolerance = 1e-7, .seed = seed, .start = first.pivots});
    CAPTURE(cold.message, warm.message);
    REQUIRE(cold.status == Termination::converged);
    REQUIRE(warm.status == Termination::converged);
    CHECK(warm.sweeps < cold.sweeps);
    CHECK(warm.evaluations < cold.evaluations);
    CHECK(changed.fresh_errors(warm.train, 2000, seed).maxCoeff() <= 3e-7);
  }
}

TEST_CASE("what the pivots missed is found with the probability that the guard's size promises") {
  // A block of m^3 of 20^3 entries is missed by g guard entries with a probability of at most
  // (1 - m^3 / 20^3)^g, less where a fibre of the pivots meets it:
  //   m = 5: 1.6 %, g = 200:  4 %     g = 1000: 1.5e-7
  //   m = 3: 0.34 %, g = 200: 51 %    g = 5000: 4.6e-8
  // No result may be silently wrong more often: "converged" with an error beyond 3 tolerances.
  const double tolerance = 1e-4;
  const auto silently_wrong = [&](int width, int guard_entries, int seeds) {
    Sampled function = with_block(width);
    int count = 0;
    for (int seed = 1; seed <= seeds; ++seed) {
      const CrossResult result = function.interpolate(
          {.tolerance = tolerance, .guard_entries = guard_entries, .seed = static_cast<std::uint64_t>(seed)});
      if (result.status == Termination::converged && function.grid_error(result.train) > 3.0 * tolerance)
        ++count;
    }
    return count;
  };
  CHECK(silently_wrong(6, 200, 10) == 0);
  CHECK(silently_wrong(5, 1000, 10) == 0);
  CHECK(silently_wrong(3, 5000, 10) == 0);
  // Binomial with 50 trials: mean 25.5, three standard deviations 10.6.
  CHECK(silently_wrong(3, 200, 50) <= 36);
}

TEST_CASE("a value that is not finite ends the interpolation and is named") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    // A whole layer, so that the first fibres meet it; in one of two outputs only.
    Sampled function({9, 11, 8}, 2, [&](int m, const std::vector<double>& x) {
      return m == 1 && x[0] == node(3, 9) ? bad : sum(x);
    });
    const CrossResult result = function.interpolate({});
    CHECK(result.status == Termination::not_finite);
    REQUIRE(result.bad_entry.size() == 3);
    CHECK(result.bad_entry[0] == 3);
    CHECK(function.asked().count(result.bad_entry) == 1);
    CHECK_THAT(result.message, Contains("not finite at entry (3, "));
  }
  // Found by the guard: single entries far from all fibres of a function of rank one.
  Sampled rare({30, 30, 30}, [](const std::vector<double>& x) {
    return x[0] > 0.6 && x[1] > 0.6 && x[2] > 0.6 ? std::nan("") : 1.0;
  });
  const CrossResult result = rare.interpolate({});
  CHECK(result.status == Termination::not_finite);
  CHECK(result.sweeps == 1);
  REQUIRE(result.bad_entry.size() == 3);
  for (const int i : result.bad_entry) CHECK(node(i, 30) > 0.6);
}

TEST_CASE("limits on sweeps, rank and evaluations end the interpolation with a status") {
  Sampled function = noise({20, 20, 20});
  const CrossResult sweeps = function.interpolate({.tolerance = 1e-3, .max_sweeps = 2});
  CHECK(sweeps.status == Termination::max_iterations);
  CHECK(sweeps.sweeps == 2);
  CHECK(sweeps.guard_error > 1e-3);
  CHECK_THAT(sweeps.message, Contains("after 2 sweeps") && Contains("> 0.001"));
  // The figure is an error at entries of the grid.
  CHECK(sweeps.guard_error <= function.grid_error(sweeps.train) * (1.0 + 1e-12));

  const CrossResult rank = function.interpolate({.tolerance = 1e-3, .max_rank = 5, .max_sweeps = 4});
  CHECK(rank.status == Termination::max_iterations);
  for (const int r : rank.train.ranks()) CHECK(r <= 5);

  const CrossResult evaluations = function.interpolate({.tolerance = 1e-3, .max_evaluations = 1500});
  CHECK(evaluations.status == Termination::max_calls);
  CHECK(evaluations.evaluations >= 1500);
  CHECK(static_cast<double>(evaluations.evaluations) < evaluations.grid_size);
  CHECK(evaluations.guard_error > 1e-3);

  // All entries suffice in the end: the grid is small, rank 20 is full.
  const CrossResult full = function.interpolate({.tolerance = 1e-3});
  CHECK(full.status == Termination::converged);
}

TEST_CASE("sets that begin larger than the ranks find them in one sweep, and no more than they need") {
  Sampled function = rational({15, 16, 17, 18});
  const CrossResult small = function.interpolate({.tolerance = 1e-7});
  const CrossResult large = function.interpolate({.tolerance = 1e-7, .first_pivots = 40, .growth = 1.0});
  CHECK(large.status == Termination::converged);
  CHECK(large.sweeps == 1);
  CHECK(small.sweeps > large.sweeps);
  for (std::size_t k = 0; k < large.train.ranks().size(); ++k)
    CHECK(large.train.ranks()[k] <= small.train.ranks()[k] + 4);
  CHECK(function.grid_error(large.train) <= 10.0 * 1e-7);
}

TEST_CASE("a table that may remember little evaluates again and gives the same") {
  long calls = 0;
  const EntryFunction function = [&](const IndexBatch& entries, Eigen::MatrixXd& values) {
    calls += entries.cols();
    for (Eigen::Index j = 0; j < entries.cols(); ++j)
      values.col(j) << entries(0, j) + 10.0 * entries(1, j), 7.0 - entries(0, j);
  };
  IndexBatch entries(2, 5);
  entries << 1, 2, 1, 3, 2,  //
      0, 4, 0, 1, 4;
  EntryTable all(function, 2, {5, 6});
  const Eigen::MatrixXd values = all.fetch(entries);
  CHECK(calls == 3);
  CHECK(all.fetch(entries) == values);
  CHECK(calls == 3);
  EntryTable none(function, 2, {5, 6}, 0);
  CHECK(none.fetch(entries) == values);
  CHECK(calls == 6);
  Eigen::MatrixXd visited = Eigen::MatrixXd::Zero(2, 5);
  none.visit(entries, [&](Eigen::Index j, const double* outputs) {
    visited.col(j) += Eigen::Map<const Eigen::Vector2d>(outputs);
  });
  CHECK(visited == values);
  CHECK(calls == 9);
  CHECK(none.evaluations() == 6);
}

TEST_CASE("the same seed gives the same train to the last bit, another one other entries") {
  Sampled function = rational({15, 16, 17, 18});
  const CrossResult a = function.interpolate({.tolerance = 1e-7, .seed = 4});
  const std::set<std::vector<int>> asked = function.asked();
  const CrossResult b = function.interpolate({.tolerance = 1e-7, .seed = 4});
  CHECK(function.asked() == asked);
  REQUIRE(a.train.ranks() == b.train.ranks());
  for (std::size_t k = 0; k < a.train.cores.size(); ++k)
    CHECK(a.train.cores[k].data == b.train.cores[k].data);
  CHECK(a.guard_error == b.guard_error);
  CHECK(a.message == b.message);
  function.interpolate({.tolerance = 1e-7, .seed = 5});
  CHECK(function.asked() != asked);
}

TEST_CASE("outputs that go together come from few entries where left sets are at few places") {
  // With every member of a left set at a place of its own, the blocks of the inner modes alone would take
  // rank * nodes * rank entries each.
  Sampled function({12, 12, 12, 12}, 40, [](int m, const std::vector<double>& x) {
    return std::cos((1.0 + 0.1 * m) * (x[0] + x[1] + x[2]) + (1.0 + 0.2 * m) * x[3]);
  });
  CrossOptions options{.tolerance = 1e-5, .guard_entries = 100, .first_pivots = 20, .growth = 1.0};
  const CrossResult by_size = function.interpolate(options);
  options.few_places = true;
  const CrossResult result = function.interpolate(options);
  CHECK(result.status == Termination::converged);
  CHECK(function.fresh_errors(result.train, 2000, 7).maxCoeff() <= 3e-5);
  const std::vector<int> ranks = result.train.ranks();
  CAPTURE(ranks, result.evaluations);
  CHECK(2.0 * static_cast<double>(result.evaluations) < 12.0 * (ranks[1] * ranks[2] + ranks[2] * ranks[3]));
  // Rows that are the largest of all need more of them, and span more.
  const std::vector<int> least = by_size.train.ranks();
  CAPTURE(least, by_size.evaluations);
  CHECK(by_size.status == Termination::converged);
  CHECK(by_size.evaluations > 2 * result.evaluations);
  CHECK(std::accumulate(least.begin(), least.end(), 0) <= std::accumulate(ranks.begin(), ranks.end(), 0));
}

TEST_CASE("an interpolation that goes on from any of its states gives the same to the last bit") {
  Sampled function = rational({15, 16, 17, 18});
  std::vector<CrossState> states;
  CrossOptions options{.tolerance = 1e-9, .first_pivots = 1};
  options.checkpoint = [&](CrossState& state) { states.push_back(state); };
  const CrossResult whole = function.interpolate(options);
  REQUIRE(states.size() >= 2);
  options.checkpoint = [](CrossState&) {};
  for (const CrossState& state : states) {
    options.state = state;
    const CrossResult rest = function.interpolate(options);
    CHECK(rest.message == whole.message);
    CHECK(rest.sweeps == whole.sweeps);
    CHECK(rest.evaluations == whole.evaluations);
    CHECK(rest.largest == whole.largest);
    REQUIRE(rest.train.ranks() == whole.train.ranks());
    for (std::size_t k = 0; k < whole.train.cores.size(); ++k)
      CHECK(rest.train.cores[k].data == whole.train.cores[k].data);
  }
  options.state = CrossState{};
  CHECK_THROWS_AS(function.interpolate(options), samara::ArgumentError);
}

TEST_CASE("pivots of another grid are refused") {
  const EntryFunction one = [](const IndexBatch&, Eigen::MatrixXd& values) { values.setOnes(); };
  const CrossResult other = rational({9, 9, 9}).interpolate({});
  CHECK_THROWS_AS(interpolate(one, 1, {9, 9}, {.start = other.pivots}), samara::ArgumentError);
  CHECK_THROWS_AS(interpolate(one, 1, {9, 3, 9}, {.start = other.pivots}), samara::ArgumentError);
  CHECK(interpolate(one, 1, {4, 9, 9}, {.start = other.pivots}).status == Termination::converged);
}
