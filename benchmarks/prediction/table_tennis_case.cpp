/// Table tennis balls: the first 0.15 s of a flight are seen, and 0.15 s on, without labels of the spin. Fifths of the
/// flights are predicted by the others, in three splits with the seeds 1 to 3. Coefficients come from those that are
/// labelled; labels of some flights stand in other rows. Of the fits from the two optima that are known the one with
/// the lower cost counts, as in the benchmark `identification`.
///
/// Errors and shares come from all along the flights that are not asked about: of the labelled ones each half by a fit
/// of the other.
#include <algorithm>
#include <array>
#include <iterator>
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
using identification::Flights;
using samara::identification::Capture;
using samara::identification::FitResult;

constexpr const char* kCase = "table_tennis";
constexpr int kLeastFrames = 12;
constexpr int kSplits = 3;
constexpr std::size_t kFolds = 5;
constexpr Eigen::Index kTrainingStride = 4;  // frames
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

/// @param stride as of flight_moments()
std::vector<AskedMoment> asked(const std::vector<Capture>& flights, const FitResult& fitted,
                               Eigen::Index stride) {
  std::vector<AskedMoment> result;
  for (const FlightMoment& moment : identification::flight_moments(flights, fitted, {}, stride)) {
    AskedMoment one;
    one.moment.cluster = std::stoi(moment.number);
    one.moment.seen.times = moment.seen.times;
    one.moment.seen.positions = identification::positions_of(moment.seen);
    one.moment.seen.up = 2;
    one.moment.next = moment.next;
    one.time = moment.time;
    if (moment.model.allFinite()) one.model = moment.model;
    result.push_back(std::move(one));
  }
  return result;
}

/// Some flights asked about, by others.
Questioned questioned(const Flights& others, const Flights& left_out) {
  std::vector<Capture> halves[2];
  for (std::size_t k = 0; k < others.labelled.size(); ++k) halves[k % 2].push_back(others.labelled[k]);
  const FitResult of_all = fit_of(others.labelled);
  Questioned result;
  const auto add = [](std::vector<AskedMoment>& to, std::vector<AskedMoment> moments) {
    std::ranges::move(moments, std::back_inserter(to));
  };
  for (const std::size_t half : {0, 1})
    add(result.training, asked(halves[half], fit_of(halves[1 - half]), kTrainingStride));
  add(result.training, asked(others.shifted, of_all, kTrainingStride));
  for (const std::vector<Capture>* flights : {&left_out.labelled, &left_out.shifted})
    add(result.unseen, asked(*flights, of_all, 0));
  return result;
}

/// The fifths of a random order, and the rest.
struct Dealt {
  std::vector<Capture> others[kFolds], left_out[kFolds];
};
Dealt dealt(const std::vector<Capture>& flights, pgd::Random& random) {
  const std::vector<std::size_t> order = identification::random_order(flights.size(), random);
  Dealt result;
  for (std::size_t k = 0; k < order.size(); ++k) {
    for (std::size_t fold = 0; fold < kFolds; ++fold)
      (k % kFolds == fold ? result.left_out : result.others)[fold].push_back(flights[order[k]]);
  }
  return result;
}

}  // namespace

void table_tennis_case(const Options& options) {
  const auto folder = identification::measured_set(options, kCase, "table-tennis-ball-spin");
  if (!folder) return;
  const Flights flights = identification::read_flights(
      *folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "table_tennis.toml", kLeastFrames);
  std::vector<SplitScores> splits;
  for (int seed = 1; seed <= (options.quick ? 1 : kSplits); ++seed) {
    pgd::Random random(static_cast<std::uint64_t>(seed));
    const Dealt labelled = dealt(flights.labelled, random), shifted = dealt(flights.shifted, random);
    std::vector<Questioned> parts;
    for (std::size_t fold = 0; fold < kFolds; ++fold) {
      parts.push_back(questioned({labelled.others[fold], shifted.others[fold]},
                                 {labelled.left_out[fold], shifted.left_out[fold]}));
    }
    splits.push_back(score_split(fmt::format("{} split {}", kCase, seed), parts));
  }
  report(kCase, splits);
}

}  // namespace samara::benchmarks::prediction
