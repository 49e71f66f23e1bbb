/// A miniature blimp, a tenth of a second seen: one and two seconds on, straights and spirals, in three splits of the
/// twelve flights. Each has four left out, a spiral among them (of the two that there are, one is fitted).
///
/// Errors and shares come from the flights of the fit: halves of each are predicted by a fit of the other halves.
/// There is one spiral among them, and a fit without it knows nothing of sideslip.
#include <array>
#include <map>

#include <fmt/format.h>

#include "cases.h"
#include "identification/blimp.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

using identification::BlimpFlight;
using identification::BlimpMoment;

const std::vector<std::vector<int>> kLeftOut = {
    {98, 126, 132, 138}, {120, 124, 130, 136}, {98, 122, 128, 134}};

AskedMoment asked(const BlimpMoment& moment) {
  AskedMoment result{.moment = {.cluster = moment.flight, .seen = moment.seen, .next = moment.next},
                     .time = moment.time};
  if (moment.model.allFinite()) result.model = moment.model;
  return result;
}

/// The first or the second half of each flight.
std::vector<BlimpFlight> halves_of(const std::vector<BlimpFlight>& flights, bool second) {
  std::vector<BlimpFlight> halves;
  for (BlimpFlight half : flights) {
    const Eigen::Index frames = half.capture.frame_count(), middle = frames / 2;
    half.capture =
        identification::frames_of(half.capture, second ? middle : 0, second ? frames - middle : middle,
                                  half.capture.times[second ? middle : 0]);
    halves.push_back(std::move(half));
  }
  return halves;
}

bool is_spiral(const std::vector<BlimpFlight>& flights, int number) {
  return std::ranges::any_of(
      flights, [&](const BlimpFlight& flight) { return flight.number == number && flight.is_spiral; });
}

struct Fits {
  identification::Coefficients all = {};
  std::array<identification::Coefficients, 2> without = {};  ///< the first halves, the second ones
};

}  // namespace

void blimp_cases(const Options& options) {
  std::map<std::string, double> cases;
  std::filesystem::path folder;
  for (const char* kind : {"straight", "spiral"}) {
    for (const double ahead : {1.0, 2.0}) {
      const std::string name = fmt::format("blimp_{}_{:.0f}s", kind, ahead);
      const auto found = identification::measured_set(options, name, "blimp-rgblimp-mocap");
      if (!found) continue;
      cases[name] = ahead;
      folder = *found;
    }
  }
  if (cases.empty()) return;
  const std::vector<BlimpFlight> flights = identification::read_blimp(
      folder, std::filesystem::path(SAMARA_EXAMPLES_DIR) / "captures" / "blimp.toml");
  std::map<std::string, std::vector<SplitScores>> scores;
  for (std::size_t split = 0; split < (options.quick ? 1 : kLeftOut.size()); ++split) {
    const auto [training, left_out] = identification::split_blimp(flights, kLeftOut[split]);
    Fits fits{.all = identification::values_of(identification::fit_blimp(training))};
    for (const bool second : {false, true}) {
      fits.without[second ? 1 : 0] =
          identification::values_of(identification::fit_blimp(halves_of(training, !second)));
    }
    for (const auto& [name, ahead] : cases) {
      std::vector<AskedMoment> moments;
      for (const bool second : {false, true}) {
        for (const BlimpMoment& moment :
             identification::blimp_moments(halves_of(training, second), fits.without[second ? 1 : 0], ahead))
          moments.push_back(asked(moment));
      }
      std::vector<AskedMoment> unseen;
      for (const BlimpMoment& moment : identification::blimp_moments(left_out, fits.all, ahead)) {
        if (is_spiral(flights, moment.flight) == name.starts_with("blimp_spiral"))
          unseen.push_back(asked(moment));
      }
      scores[name].push_back(score_split(fmt::format("{} split {}", name, split + 1), moments, unseen));
    }
  }
  for (const auto& [name, of_case] : scores) report(name, of_case);
}

}  // namespace samara::benchmarks::prediction
