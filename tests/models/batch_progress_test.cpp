#include <array>
#include <atomic>
#include <limits>
#include <memory>
#include <set>
#include <thread>

#include <catch2/catch.hpp>

#include "falling_card.h"
#include "samara/models/batch/batch.h"
#include "samara/models/batch/watch_batch.h"

using namespace samara::models;
using samara::Progress;

namespace {

/// Cards enough for hundreds of tasks.
const Eigen::MatrixXd kCards = Eigen::VectorXd::LinSpaced(4000, 0.4, 1.4);

Eigen::Index count(const std::vector<BatchStatus>& status, BatchStatus wanted) {
  return std::ranges::count(status, wanted);
}

/// Cancels at once, or at the first report of something finished, however slow the machine is; fails if it is
/// asked again.
class Canceller {
 public:
  explicit Canceller(bool at_once) : at_once_(at_once) {}
  bool operator()(const Progress& progress) {
    CHECK_FALSE(*has_cancelled_);
    *has_cancelled_ = at_once_ || progress.fraction > 0.0;
    return !*has_cancelled_;
  }
  bool has_cancelled() const { return *has_cancelled_; }

 private:
  bool at_once_;
  std::shared_ptr<bool> has_cancelled_ = std::make_shared<bool>(false);  // callbacks are copied
};

bool no_row_is_finite(const Eigen::MatrixXd& columns) {
  return !columns.array().isFinite().any();
}

}  // namespace

TEST_CASE("a batch reports its progress from the calling thread, and progress changes nothing") {
  const ParametricModel card = falling_card({"C_D90"});
  constexpr std::array kTimes = {0.05};
  std::vector<double> fractions;
  // By one thread, so that the first report comes before anything is done.
  BatchOptions options = {.step = 5e-4, .threads = 1};
  const BatchTrajectories silent = integrate_batch(card, kCards, kTimes, options);
  const std::thread::id caller = std::this_thread::get_id();
  options.progress = [&](const Progress& progress) {
    CHECK(std::this_thread::get_id() == caller);
    CHECK(progress.stage == "integrating");
    fractions.push_back(progress.fraction);
    return true;
  };
  const BatchTrajectories batch = integrate_batch(card, kCards, kTimes, options);
  REQUIRE(!fractions.empty());
  CHECK(fractions.front() == 0.0);
  CHECK(std::ranges::is_sorted(fractions));
  CHECK(fractions.back() <= 1.0);
  CHECK(count(batch.status, BatchStatus::done) == kCards.rows());
  CHECK(batch.states == silent.states);
}

TEST_CASE("a batch that is cancelled keeps what was finished and nothing of the rest") {
  const ParametricModel card = falling_card({"C_D90"});
  constexpr std::array kTimes = {0.0, 0.05, 0.1};
  for (const bool at_once : {true, false}) {
    const Canceller cancel(at_once);
    BatchOptions options = {.step = 1e-4, .threads = 1, .tangents = {"C_D90"}};
    options.progress = cancel;
    const BatchTrajectories batch = integrate_batch(card, kCards, kTimes, options);
    CHECK(cancel.has_cancelled());
    CHECK(count(batch.status, BatchStatus::cancelled) > 0);
    CHECK(count(batch.status, BatchStatus::cancelled) + count(batch.status, BatchStatus::done) ==
          kCards.rows());
    CHECK((count(batch.status, BatchStatus::done) > 0) == !at_once);
    for (Eigen::Index n = 0; n < kCards.rows(); ++n) {
      const bool done = batch.status[static_cast<std::size_t>(n)] == BatchStatus::done;
      const Eigen::Index first = batch.column(n, 0);
      CHECK(batch.reached[n] == (done ? 0.1 : 0.0));
      CHECK(batch.states.middleCols(first, 3).allFinite() == done);
      CHECK(batch.tangents[0].middleCols(first, 3).allFinite() == done);
      if (!done) CHECK(no_row_is_finite(batch.states.middleCols(first, 3)));
    }
  }
}

TEST_CASE("a watched batch that is cancelled says of each trajectory how far it came") {
  const ParametricModel card = falling_card({"C_D90"});
  std::vector<double> seen(static_cast<std::size_t>(kCards.rows()), 0.0);
  const BatchObserver observer = [&](Eigen::Index n, double t, std::span<const double>) {
    seen[static_cast<std::size_t>(n)] = t;
    return true;
  };
  const Canceller cancel(false);
  WatchOptions options = {.step = 1e-4, .end = 0.1, .threads = 1};
  options.progress = cancel;
  const WatchedBatch batch = watch_batch(card, kCards, observer, options);
  CHECK(cancel.has_cancelled());
  CHECK(count(batch.status, BatchStatus::cancelled) > 0);
  CHECK(count(batch.status, BatchStatus::done) > 0);
  for (Eigen::Index n = 0; n < kCards.rows(); ++n) {
    CHECK(batch.reached[n] == seen[static_cast<std::size_t>(n)]);
    CHECK((batch.status[static_cast<std::size_t>(n)] == BatchStatus::done) == (batch.reached[n] >= 0.0999));
  }
}

TEST_CASE("what a progress callback throws passes through a batch") {
  BatchOptions options = {.threads = 2};
  options.progress = [](const Progress&) -> bool { throw std::runtime_error("no more"); };
  CHECK_THROWS_WITH(integrate_batch(falling_card({"C_D90"}), kCards, std::array{0.05}, options), "no more");
}
