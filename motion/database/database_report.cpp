#include "samara/motion/database/database_report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/motion/chains/chain_check.h"

namespace samara::motion {

namespace {

constexpr int kKindCount = static_cast<int>(kEventKinds);

/// Segments of each kind, and steady ones, whose kind would be round-off.
struct KindCounts {
  std::array<int, kEventKinds> kinds = {};
  int steady = 0;
};

KindCounts kind_counts(const MotionDatabase& database) {
  KindCounts counts;
  for (const MotionSegment& segment : database.segments)
    ++(segment.is_steady ? counts.steady : counts.kinds[static_cast<std::size_t>(segment.kind)]);
  return counts;
}

double median_duration_of(const MotionDatabase& database) {
  std::vector<double> durations;
  for (const MotionSegment& segment : database.segments) durations.push_back(segment.duration);
  const auto middle = durations.begin() + static_cast<std::ptrdiff_t>(durations.size() / 2);
  std::ranges::nth_element(durations, middle);
  return *middle;
}

/// Of chains of the order that was chosen and of the first, fitted to one half of the runs: what they are worth on the
/// other.
struct KindChecks {
  ChainCheck chosen, first;
};

KindChecks checks_of(const MotionDatabase& database, const OrderChoice& choice) {
  const RunHalves halves = halves_of(database.kind_sequences(), kMostKindOrder);
  const auto worth = [&](int order) {
    return check(MarkovChain::fitted(halves.fit, kKindCount, order), halves.held_out);
  };
  return {worth(choice.order), worth(1)};
}

double largest_of(const Eigen::VectorXd& values) {
  double most = std::numeric_limits<double>::quiet_NaN();
  for (const double value : values) {
    if (std::isfinite(value)) most = std::fmax(most, value);
  }
  return most;
}

std::string check_text(const char* name, const ChainCheck& worth) {
  const double largest = largest_of(worth.chi_square);
  const std::string run_lengths = std::isfinite(largest)
                                      ? fmt::format("{:8.4g} (95 %: {:4.3g})", largest, worth.largest_95)
                                      : "too few to tell";
  return fmt::format("  {:<13} run lengths {}   two events on {:6.3g} standard errors\n", name, run_lengths,
                     worth.two_steps);
}

nlohmann::ordered_json check_json(const ChainCheck& worth) {
  const auto number_or_null = [](double value) {
    return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json object = {
      {"chi_square", nlohmann::ordered_json::array()},
      {"degrees_of_freedom", std::vector<int>(worth.freedom.begin(), worth.freedom.end())},
      {"largest_95", number_or_null(worth.largest_95)},
      {"two_steps", worth.two_steps}};
  for (const double value : worth.chi_square) object["chi_square"].push_back(number_or_null(value));
  return object;
}

std::string chain_text(const MotionDatabase& database, const OrderChoice& choice) {
  if (choice.scores.empty()) return "too few runs are long enough to select the order of a chain\n";
  std::string text =
      fmt::format("chain of order {} (log-likelihood an event in {} runs left out, by order:", choice.order,
                  choice.held_out_runs);
  for (const OrderScore& score : choice.scores) text += fmt::format(" {:.3f}", score.log_likelihood);
  text += ")\n";
  const KindChecks checks = checks_of(database, choice);
  text +=
      "beside runs left out: largest chi-square of lengths of runs of a kind (in brackets its 95 % point for "
      "an exact chain; up to twice that for one fitted to as many runs), and how far the shares two "
      "events on are off at most\n";
  text += check_text(fmt::format("order {}", choice.order).c_str(), checks.chosen);
  if (choice.order != 1) text += check_text("first order", checks.first);
  text += "what follows what, first order, with 95 % intervals\n";
  const Eigen::MatrixXd counts = MarkovChain::fitted(database.kind_sequences(), kKindCount, 1).counts();
  for (int i = 0; i < kKindCount; ++i) {
    text += fmt::format("  {:<7}", event_kind_names()[static_cast<std::size_t>(i)]);
    for (int j = 0; j < kKindCount; ++j) {
      const Chance chance = dirichlet_chance(counts(i, j), counts.row(i).sum(), kKindCount);
      text += fmt::format("  {} {:.2f} ({:.2f} to {:.2f})", event_kind_names()[static_cast<std::size_t>(j)],
                          chance.probability, chance.lower, chance.upper);
    }
    text += "\n";
  }
  return text;
}

}  // namespace

std::string database_text(const MotionDatabase& database, const MotionGraph& graph, const KindChain& kinds) {
  std::string text = fmt::format("{} segments of {} runs, {:.4g} s in the median:", database.segment_count(),
                                 database.runs.size(), median_duration_of(database));
  const KindCounts seen = kind_counts(database);
  for (std::size_t k = 0; k < kEventKinds; ++k)
    text += fmt::format(" {} {}", seen.kinds[k], event_kind_names()[k]);
  if (seen.steady > 0) text += fmt::format(" {} steady", seen.steady);
  text += "\nthreshold  share in the largest component    edges\n";
  for (const ThresholdPoint& point : graph.curve) {
    text += fmt::format("{:9.4g}  {:30.3f}  {:>7}{}\n", point.threshold, point.share, point.edges,
                        point.threshold == graph.threshold ? "  chosen" : "");
  }
  text += fmt::format("{} segments are kept, {} pruned\n", graph.kept, graph.pruned);
  if (2 * graph.kept < database.segment_count())
    text +=
        "fewer than half of the segments hang together: what goes on by this graph shows few of these "
        "motions; "
        "sweep more densely, or a box of one kind of motion\n";
  return text + chain_text(database, kinds.choice);
}

std::string database_json(const MotionDatabase& database, const MotionGraph& graph, const KindChain& kinds) {
  nlohmann::ordered_json object = {{"schema", "samara-motions/1"},
                                   {"model", database.model},
                                   {"coefficients", database.coefficient_names},
                                   {"runs", database.runs.size()},
                                   {"segments", database.segment_count()},
                                   {"median_duration", median_duration_of(database)}};
  const KindCounts seen = kind_counts(database);
  for (std::size_t k = 0; k < kEventKinds; ++k) object["kinds"][event_kind_names()[k]] = seen.kinds[k];
  object["steady"] = seen.steady;
  object["threshold"] = graph.threshold;
  object["threshold_curve"] = nlohmann::ordered_json::array();
  for (const ThresholdPoint& point : graph.curve)
    object["threshold_curve"].push_back(
        {{"threshold", point.threshold}, {"share", point.share}, {"edges", point.edges}});
  object["kept"] = graph.kept;
  object["pruned"] = graph.pruned;
  object["chain"] = {{"order", kinds.choice.order}, {"scores", nlohmann::ordered_json::array()}};
  for (const OrderScore& score : kinds.choice.scores) {
    object["chain"]["scores"].push_back(
        {{"order", score.order}, {"log_likelihood", score.log_likelihood}, {"error", score.error}});
  }
  if (!kinds.choice.scores.empty()) {
    const KindChecks checks = checks_of(database, kinds.choice);
    object["chain"]["held_out"] = check_json(checks.chosen);
    object["chain"]["held_out_first_order"] = check_json(checks.first);
  }
  object["chain"]["first_order"] = nlohmann::ordered_json::array();
  const Eigen::MatrixXd counts = MarkovChain::fitted(database.kind_sequences(), kKindCount, 1).counts();
  for (int i = 0; i < kKindCount; ++i) {
    for (int j = 0; j < kKindCount; ++j) {
      const Chance chance = dirichlet_chance(counts(i, j), counts.row(i).sum(), kKindCount);
      object["chain"]["first_order"].push_back({{"from", event_kind_names()[static_cast<std::size_t>(i)]},
                                                {"to", event_kind_names()[static_cast<std::size_t>(j)]},
                                                {"probability", chance.probability},
                                                {"interval", {chance.lower, chance.upper}}});
    }
  }
  return object.dump(2) + "\n";
}

}  // namespace samara::motion
