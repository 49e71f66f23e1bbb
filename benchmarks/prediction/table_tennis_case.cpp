/// Table tennis balls: 0.15 s seen of a flight, and 0.15 s on, without labels of the spin. Labelled flights by fifths
/// that a fit of the others predicts, and those with labels of other rows by a fit of all labelled ones, in three
/// splits into fifths with the seeds 1 to 3. Of the fits from the two optima that are known the one with the lower cost
/// counts, as in the benchmark `identification`.
///
/// Errors and shares of each come from the flights of its fit, of which each half is predicted by a fit of the other.
#include <array>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "cases.h"
#include "identification/table_tennis.h"
#include "samara/pgd/tensors/random.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

using identification::FlightMoment;
using samara::identification::Capture;
using samara::identification::FitResult;

constexpr const char* kCase = "table_tennis";
constexpr int kLeastFrames = 12;
constexpr int kSplits = 3;
constexpr std::size_t kFolds = 5;
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr std::array kStarts = {identification::RotationStart{-81.0 * kDegree, 0.5},
                                identification::RotationStart{-7.0 * kDegree, 0.5}};

/// Chosen without the flights that are left out.
FitResult fit_of(const std::vector<Capture>& flights) {
  FitResult best;
  for (const identification::RotationStart& start : kStarts) {
    FitResult result = identification::fit_labelled(flights, start);
    if (best.captures.empty() || result.cost < best.cost) best = std::move(result);
  }
  return best;
}

std::vector<AskedMoment> asked(const std::vector<Capture>& flights, const FitResult& fitted) {
  std::vector<AskedMoment> result;
  for (const FlightMoment& moment : identification::flight_moments(flights, fitted, {})) {
    AskedMoment one{.moment = {.cluster = std::stoi(moment.number),
                               .seen = {.times = moment.seen.times,
                                        .positions = identification::positions_of(moment.seen),
                                        .up = 2},
                               .next = moment.next},
                    .time = moment.time};
    if (moment.model.allFinite()) one.model = moment.model;
    result.push_back(std::move(one));
  }
  return result;
}

/// Each half by a fit of the other.
std::vector<AskedMoment> training_of(const std::vector<Capture>& flights) {
  std::vector<Capture> halves[2];
  for (std::size_t k = 0; k < flights.size(); ++k) halves[k % 2].push_back(flights[k]);
  std::vector<AskedMoment> moments = asked(halves[0], fit_of(halves[1]));
  for (AskedMoment& moment : asked(halves[1], fit_of(halves[0]))) moments.push_back(std::move(moment));
  return moments;
}

}  // namespace

void table_tennis_case(const Options& options) {
  const auto folder = identification::measured_set(options, kCase, "table-tennis-ball-spin");
  if (!folder) return;
  const identification::Flights flights = identification::read_flights(
      *folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "table_tennis.toml", kLeastFrames);
  const std::vector<Capture>& labelled = flights.labelled;
  const std::vector<AskedMoment> of_shifted = asked(flights.shifted, fit_of(labelled));
  const std::vector<AskedMoment> of_labelled = training_of(labelled);
  std::vector<SplitScores> splits;
  for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed) {
    pgd::Random random(static_cast<std::uint64_t>(seed));
    std::vector<std::size_t> order(labelled.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    for (std::size_t k = order.size() - 1; k > 0; --k)
      std::swap(order[k], order[static_cast<std::size_t>(random.below(static_cast<int>(k) + 1))]);
    std::vector<Questioned> parts = {{of_labelled, of_shifted}};
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      std::vector<Capture> fitted, left_out;
      for (std::size_t k = 0; k < order.size(); ++k)
        (k % kFolds == fold ? left_out : fitted).push_back(labelled[order[k]]);
      parts.push_back({training_of(fitted), asked(left_out, fit_of(fitted))});
    }
    splits.push_back(score_split(fmt::format("{} split {}", kCase, seed), parts));
  }
  report(kCase, splits);
}

}  // namespace samara::benchmarks::prediction
