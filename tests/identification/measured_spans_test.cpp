/// What the benchmark `identification` reaches on measurements that the project may not contain: a smaller
/// share of them, with a margin.
#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "identification/april_paper.h"
#include "identification/falling_paper.h"
#include "identification/real_data.h"
#include "identification/settling_plates.h"
#include "measured_data.h"
#include "samara/identification/fit/fit.h"

using namespace samara::benchmarks::identification;
using samara::identification::Baseline;
using samara::identification::FitResult;

TEST_CASE("falling paper: the body predicts drops that it has not seen better than polynomials") {
  const auto folder = measured_data("falling-paper-cambridge");
  if (folder.empty()) return;
  const auto drops = paper_drops(folder);
  CHECK(drops.size() == 85);
  const PaperSplit spans = split(drops, 5, 20, 1);
  const auto body = paper_family();
  auto options = paper_options();
  options.starts.rounds = 1;
  const FitResult fitted = samara::identification::fit(*body, captures_of(spans.fitted), options);
  const Prediction unseen = predict_unseen(*body, options, values_of(fitted), spans.unseen);
  // 2.8 mm for 20 drops; 3.5 mm was found by an independent trial.
  CHECK(median_of(window_misfits(fitted)) < 3.5e-3);
  CHECK(median_of(unseen.errors) < 0.85 * median_of(baseline_errors(Baseline::quadratic, spans.unseen)));
  CHECK(median_of(unseen.errors) < 0.75 * median_of(baseline_errors(Baseline::cubic, spans.unseen)));
  // Against the straight line it takes the benchmark's twenty drops to tell.
  CHECK(rms_of(unseen.errors) < 0.85 * rms_of(baseline_errors(Baseline::quadratic, spans.unseen)));
}

TEST_CASE("settling plates: drops left out flutter like the ones fitted") {
  const auto folder = measured_data("settling-plates-water-cardiff");
  if (folder.empty()) return;
  const PlateKind& kind = plate_kind("POM");
  const auto drops = plate_drops(folder, kind);
  CHECK(drops.size() == 35);
  const auto all = measured_flutter(drops, kind);
  // 4.1 cm/s and 2.06 Hz were found by an independent trial.
  CHECK(std::abs(all.fall_speed / 0.041 - 1.0) < 0.03);
  CHECK(std::abs(all.frequency / 2.06 - 1.0) < 0.05);

  SECTION("and so does a plate with the coefficients of the benchmark") {
    const auto simulated = simulated_flutter(
        kind, {{"C_D0", 1.253}, {"C_D90", 13.36}, {"C_R", 0.9072}, {"C_T", 2.579}, {"C_w", 0.9195}});
    REQUIRE(simulated);
    CHECK(std::abs(simulated->fall_speed / all.fall_speed - 1.0) < 0.05);
    CHECK(std::abs(simulated->frequency / all.frequency - 1.0) < 0.05);
    CHECK(std::abs(simulated->amplitude / all.amplitude - 1.0) < 0.15);
  }
}

TEST_CASE("rough poses of a paper card: a report, and no number for what they do not determine") {
  const auto folder = measured_data("paper-6dof-apriltag");
  if (folder.empty()) return;
  const auto spans = april_windows(folder);
  CHECK(spans.size() > 8);
  const FitResult fitted = samara::identification::fit(*april_family(kAprilSize), spans, april_options());
  INFO(fitted.message);
  REQUIRE_FALSE(fitted.captures.empty());
  CHECK_FALSE(fitted.message.empty());
  const auto verdicts = april_verdicts(fitted, april_variants(spans, true));
  CHECK(verdicts.size() == 5);
  for (const AprilVerdict& v : verdicts) {
    CHECK(std::isfinite(v.value));
    CHECK_FALSE(v.words.empty());
  }
  // One drop, a card of unknown size, and every other angle wrong: whatever looks well determined (C_D0, to 6
  // % by the scatter between spans) is another number without one of the cameras.
  CHECK(std::ranges::none_of(verdicts, &AprilVerdict::identified));
}
