/// A miniature blimp: one and two seconds on, straights and spirals, in three splits of the twelve flights. Each has
/// four left out, a spiral among them (of the two that there are, one is fitted).
///
/// The body rests on all of the past: it is followed from the first frame on. Baselines see the last tenth of a second.
/// A moment is asked about every tenth of a second.
/// Errors, shares and the noise of the model come from the flights of the fit: they are dealt into parts, each of which
/// a fit of the others predicts. There is one spiral among them, and a fit without it knows nothing of sideslip: it is
/// dealt by quarters. Of straights it teaches the autoregression alone: on a spiral other predictors are good, and err
/// by more, and both would count in shares and bands. (Seen in the training: of straights there, predicted by shares of
/// others.) One spiral is too little to learn shares from, and of spirals straights teach all, too.
#include <map>

#include <fmt/format.h>

#include "cases.h"
#include "followed_blimp.h"
#include "identification/blimp.h"
#include "scored_split.h"

namespace samara::benchmarks::prediction {

namespace {

const std::vector<std::vector<int>> kLeftOut = {
    {98, 126, 132, 138}, {120, 124, 130, 136}, {98, 122, 128, 134}};
constexpr std::size_t kParts = 4;

/// A part of a flight.
BlimpFlight part_of(const BlimpFlight& flight, std::size_t part) {
  const auto border = [&](std::size_t k) {
    return static_cast<Eigen::Index>(k) * flight.capture.frame_count() / static_cast<Eigen::Index>(kParts);
  };
  BlimpFlight result = flight;
  result.capture = identification::frames_of(flight.capture, border(part), border(part + 1) - border(part),
                                             flight.capture.times[border(part)]);
  result.capture.id += fmt::format(", quarter {}", part + 1);
  return result;
}

/// Flights of the fit, or quarters of them, each with the coefficients of a fit of others.
BlimpAhead predicted_by_others(const std::vector<BlimpFlight>& training) {
  const auto spirals = std::ranges::count_if(training, &BlimpFlight::is_spiral);
  BlimpAhead all;
  for (std::size_t part = 0; part < kParts; ++part) {
    std::vector<BlimpFlight> others, here;
    std::size_t dealt = 0;
    for (const BlimpFlight& flight : training) {
      if (flight.is_spiral && spirals == 1) {
        for (std::size_t k = 0; k < kParts; ++k) (k == part ? here : others).push_back(part_of(flight, k));
      } else {
        (dealt++ % kParts == part ? here : others).push_back(flight);
      }
    }
    all.add(here, identification::values_of(identification::fit_blimp(others)));
  }
  return all;
}

/// What a fit of others predicts is a cluster: quarters of the spiral are four.
std::vector<AskedMoment> asked(const BlimpAhead& flights, double ahead,
                               const samara::identification::NoiseChoice& choice) {
  const std::vector<BlimpMoment> moments = identification::blimp_moments(flights.flights, ahead);
  const Eigen::MatrixX3d said = follow_blimp(flights, moments, ahead, choice);
  std::vector<AskedMoment> result;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    AskedMoment one{.moment = {.cluster = static_cast<int>(moments[k].flight),
                               .seen = moments[k].seen,
                               .next = moments[k].next},
                    .time = moments[k].time};
    if (const auto row = static_cast<Eigen::Index>(k); said.row(row).allFinite()) one.model = said.row(row);
    result.push_back(std::move(one));
  }
  return result;
}

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
    const identification::Coefficients of_all =
        identification::values_of(identification::fit_blimp(training));
    const BlimpAhead known = predicted_by_others(training);
    for (const auto& [name, ahead] : cases) {
      BlimpAhead unseen;
      for (const BlimpFlight& flight : left_out) {
        if (flight.is_spiral == name.starts_with("blimp_spiral")) unseen.add({flight}, of_all);
      }
      const auto choice = choose_blimp_noise(known, ahead);
      fmt::print(stderr,
                 "white noise in the rates of velocities {:.2g} m/s, of rates {:.2g} rad/s per sqrt(s)\n",
                 choice.velocity, choice.rate);
      std::vector<AskedMoment> taught = asked(known, ahead, choice);
      for (AskedMoment& one : taught) {
        one.for_autoregression_only = name.starts_with("blimp_straight") &&
                                      known.flights[static_cast<std::size_t>(one.moment.cluster)].is_spiral;
      }
      scores[name].push_back(
          score_split(fmt::format("{} split {}", name, split + 1), taught, asked(unseen, ahead, choice)));
    }
  }
  for (const auto& [name, of_case] : scores) report(name, of_case);
}

}  // namespace samara::benchmarks::prediction
