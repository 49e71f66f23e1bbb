/// Table tennis balls: 0.15 s seen of a flight, and 0.15 s on, without labels of the spin. Labelled flights by thirds
/// that a fit of the others predicts, and those with labels of other rows by a fit of all labelled ones, in three
/// splits into thirds with the seeds 1 to 3.
///
/// Errors and shares of each come from the flights of its fit, of which each half is predicted by a fit of the other.
#include <numbers>

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
constexpr std::size_t kThirds = 3;
/// The lower of the two optima that are known (see the benchmark `identification`).
constexpr identification::RotationStart kStart = {-81.0 * std::numbers::pi / 180.0, 0.5};

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
  std::vector<AskedMoment> moments = asked(halves[0], identification::fit_labelled(halves[1], kStart));
  for (AskedMoment& moment : asked(halves[1], identification::fit_labelled(halves[0], kStart)))
    moments.push_back(std::move(moment));
  return moments;
}

}  // namespace

void table_tennis_case(const Options& options) {
  const auto folder = identification::measured_set(options, kCase, "table-tennis-ball-spin");
  if (!folder) return;
  const identification::Flights flights = identification::read_flights(
      *folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "table_tennis.toml", kLeastFrames);
  const std::vector<Capture>& labelled = flights.labelled;
  const std::vector<AskedMoment> of_shifted =
      asked(flights.shifted, identification::fit_labelled(labelled, kStart));
  const std::vector<AskedMoment> of_labelled = training_of(labelled);
  std::vector<SplitScores> splits;
  for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed) {
    pgd::Random random(static_cast<std::uint64_t>(seed));
    std::vector<std::size_t> order(labelled.size());
    for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
    for (std::size_t k = order.size() - 1; k > 0; --k)
      std::swap(order[k], order[static_cast<std::size_t>(random.below(static_cast<int>(k) + 1))]);
    std::vector<Questioned> parts = {{of_labelled, of_shifted}};
    for (std::size_t third = 0; third < kThirds; ++third) {
      std::vector<Capture> fitted, left_out;
      for (std::size_t k = 0; k < order.size(); ++k)
        (k % kThirds == third ? left_out : fitted).push_back(labelled[order[k]]);
      parts.push_back({training_of(fitted), asked(left_out, identification::fit_labelled(fitted, kStart))});
    }
    splits.push_back(score_split(fmt::format("{} split {}", kCase, seed), parts));
  }
  report(kCase, splits);
}

}  // namespace samara::benchmarks::prediction
