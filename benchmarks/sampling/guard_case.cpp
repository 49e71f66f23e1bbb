#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "cases.h"
#include "guard_families.h"
#include "samara/base/parallel.h"
#include "samara/codebooks/build/build.h"
#include "samara/codebooks/query/query.h"
#include "samara/io/checksum.h"
#include "samara/pgd/tensors/random.h"

// Functions made to deceive: what counts is that no certificate states what independent points refute.

namespace samara::benchmarks {

namespace {

constexpr double kTolerance = 1e-2;

codebooks::Plan plan_of(const GuardedFunction& f, std::uint64_t seed, long max_calls) {
  std::string inputs, box;
  for (int k = 0; k < f.dimensions; ++k) {
    inputs += fmt::format("{}x{} = \"1\"", k == 0 ? "" : ", ", k);
    box += fmt::format("x{} = [0, 1]\n", k);
  }
  const std::string text = fmt::format(
      "[command]\nrun = [\"guard\"]\ninputs = {{ {} }}\noutputs = {{ f = \"1\" }}\n[box]\n{}"
      "[tolerance]\nrelative = {}\n[builder]\nseed = {}\nmax_calls = {}\n",
      inputs, box, kTolerance, seed % 1'000'000'007, max_calls);
  return codebooks::parse_plan(text, f.family);
}

/// What became of one build, and what is true.
struct Verdict {
  bool met = false;
  double stated = 0.0;  ///< share of the box that the certificate leaves
  double share = 0.0;   ///< of fresh points above the tolerance
  double worst = 0.0;   ///< of fresh points and the feature's own place, over the tolerance
  double calls = 0.0;
  std::string status;
  bool is_false() const { return met && share > stated; }
  /// Wrong by far, in a share that 2,000 points do not miss by bad luck.
  bool is_grossly_false() const { return met && share > 2e-3 && worst > 3.0; }
};

Verdict judged(const GuardedFunction& f, std::uint64_t seed, long max_calls, int points) {
  const pgd::PointsFunction function = [&](const Eigen::MatrixXd& x, Eigen::MatrixXd& values) {
    for (Eigen::Index j = 0; j < x.cols(); ++j)
      values(0, j) = f.value({x.col(j).data(), static_cast<std::size_t>(x.rows())});
  };
  const codebooks::BuildResult result = codebooks::build(plan_of(f, seed, max_calls), function);
  const codebooks::Certificate& certificate = *result.book.certificate();
  Verdict verdict{.met = result.met,
                  .calls = result.book.build().evaluations,
                  .status = to_string(result.book.build().status)};
  verdict.stated = codebooks::share_above(*certificate.wrong_points, certificate.points);
  if (!result.met) return verdict;
  codebooks::Query query(result.book);
  pgd::Random random(~seed);
  std::vector<double> x(static_cast<std::size_t>(f.dimensions)), errors;
  double lowest = 0.0, highest = 0.0;
  const auto compare = [&] {
    Eigen::VectorXd value(1);
    query.values(x, value);
    const double exact = f.value(x);
    lowest = errors.empty() ? exact : std::min(lowest, exact);
    highest = errors.empty() ? exact : std::max(highest, exact);
    errors.push_back(std::abs(value[0] - exact));
  };
  for (int j = 0; j < points; ++j) {
    for (double& value : x) value = random.uniform();
    compare();
  }
  for (const std::vector<double>& place : f.places) {
    x = place;
    compare();
  }
  const double limit = kTolerance * (highest - lowest);
  const auto above =
      std::count_if(errors.begin(), errors.begin() + points, [&](double e) { return e > limit; });
  verdict.share = static_cast<double>(above) / points;
  verdict.worst = *std::ranges::max_element(errors) / limit;
  return verdict;
}

struct Task {
  GuardedFunction function;
  std::uint64_t seed = 0;
};

std::vector<Verdict> judge_all(const std::vector<Task>& tasks, long max_calls, int points) {
  std::vector<Verdict> verdicts(tasks.size());
  parallel_for(tasks.size(), [&](std::size_t i) {
    verdicts[i] = judged(tasks[i].function, tasks[i].seed, max_calls, points);
  });
  return verdicts;
}

/// One line a family on stderr.
void tell(const std::vector<Task>& tasks, const std::vector<Verdict>& verdicts) {
  struct Count {
    int runs = 0, met = 0, wrong = 0, gross = 0;
    double calls = 0.0;
    std::map<std::string, int> statuses;
  };
  std::map<std::string, Count> families;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    Count& count = families[tasks[i].function.family];
    ++count.runs;
    count.met += verdicts[i].met ? 1 : 0;
    count.wrong += verdicts[i].is_false() ? 1 : 0;
    count.gross += verdicts[i].is_grossly_false() ? 1 : 0;
    count.calls += verdicts[i].calls;
    ++count.statuses[verdicts[i].status];
  }
  for (const auto& [family, count] : families) {
    std::string statuses;
    for (const auto& [status, number] : count.statuses) statuses += fmt::format(" {} {}", status, number);
    fmt::print(stderr, "{:<14} {:4} runs, {:4} met, {} false, {} grossly, {:.0f} calls on average;{}\n",
               family, count.runs, count.met, count.wrong, count.gross, count.calls / count.runs, statuses);
  }
}

/// The commit, so that nobody chooses.
std::uint64_t seed_of_commit() {
  const char* commit = std::getenv("SAMARA_COMMIT");
  return io::fnv1a(commit == nullptr ? "" : commit);
}

double share_of(const std::vector<Verdict>& verdicts, bool (Verdict::*holds)() const) {
  const auto count = std::ranges::count_if(verdicts, [&](const Verdict& v) { return (v.*holds)(); });
  return static_cast<double>(count) / static_cast<double>(verdicts.size());
}

}  // namespace

void run_guard(const Options& options) {
  const int runs = options.quick ? 90 : 1000;
  constexpr int kPoints = 100'000;
  pgd::Random random(seed_of_commit());
  if (options.wants("guard")) {
    const std::vector<std::string>& families = guard_families();
    std::vector<Task> tasks;
    for (int i = 0; i < runs; ++i) {
      const std::string& family = families[static_cast<std::size_t>(i) % families.size()];
      const std::uint64_t seed = random.bits();
      tasks.push_back({guarded_function(family, seed, kTolerance), seed});
    }
    const std::vector<Verdict> verdicts = judge_all(tasks, 10'000, kPoints);
    tell(tasks, verdicts);
    double smooth = 0.0, smooth_met = 0.0;
    for (std::size_t i = 0; i < tasks.size(); ++i) {
      if (tasks[i].function.has_feature) continue;
      smooth += 1.0;
      smooth_met += verdicts[i].met ? 1.0 : 0.0;
    }
    const double false_share = share_of(verdicts, &Verdict::is_false);
    print({kSampling, "guard", "runs", static_cast<double>(runs)});
    print({kSampling, "guard", "false_claims", std::round(false_share * runs)});
    print({kSampling, "guard", "false_share", false_share});
    print({kSampling, "guard", "false_fraction", share_of(verdicts, &Verdict::is_grossly_false)});
    print({kSampling, "guard", "met_fraction", smooth_met / smooth});
    print({kSampling, "guard", "calls_over_before", calls_over_before()});
  }
  if (options.wants("oblique_peaks")) {
    const int peaks = options.quick ? 10 : 40;
    for (const long max_calls : {2'500L, 100'000L}) {
      std::vector<Task> tasks;
      for (int i = 0; i < peaks; ++i) {
        const GuardedFunction peak = oblique_peak(random.bits());
        const int builds = max_calls > 2'500 || options.quick ? 1 : 4;
        for (int k = 0; k < builds; ++k) tasks.push_back({peak, random.bits()});
      }
      const std::vector<Verdict> verdicts = judge_all(tasks, max_calls, kPoints);
      tell(tasks, verdicts);
      const std::string with = fmt::format("_{}_calls", max_calls);
      const auto met = std::ranges::count_if(verdicts, &Verdict::met);
      const auto wrong = std::ranges::count_if(
          verdicts, [](const Verdict& v) { return v.met && (v.worst > 3.0 || v.is_false()); });
      print({kSampling, "oblique_peaks", "runs" + with, static_cast<double>(verdicts.size())});
      print({kSampling, "oblique_peaks", "met" + with, static_cast<double>(met)});
      print({kSampling, "oblique_peaks", "false_claims" + with, static_cast<double>(wrong)});
    }
  }
}

}  // namespace samara::benchmarks
