#include "scored_split.h"

#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "cases.h"
#include "identification/real_data.h"
#include "samara/identification/fit/fit.h"

namespace samara::benchmarks::prediction {

using samara::identification::PredictionTally;
using samara::identification::SaidForecast;
using samara::identification::TrainedForecasts;

AskedMoment moment_of(const identification::Window& window, int cluster, const Eigen::VectorXd& known,
                      const Eigen::RowVectorXd& model, double net_weight) {
  return {.moment = {.cluster = cluster,
                     .seen = {.times = window.capture.times,
                              .positions = identification::positions_of(window.capture),
                              .up = 2,
                              .net_weight = net_weight},
                     .known = known,
                     .next = window.next},
          .time = window.next_time,
          .model = model.allFinite() ? model : Eigen::RowVectorXd()};
}

identification::Coefficients coefficients_of(const samara::models::TrajectoryFamily& family,
                                             const samara::identification::FitOptions& options,
                                             const std::vector<identification::Window>& windows,
                                             std::size_t stride) {
  std::vector<samara::identification::Capture> fitted;
  for (std::size_t k = 0; k < windows.size(); k += stride) fitted.push_back(windows[k].capture);
  const auto result = samara::identification::fit(family, fitted, options);
  fmt::print(stderr, "  {} windows fitted in {:.1f} s\n", fitted.size(), result.seconds);
  return identification::values_of(result);
}

namespace {

constexpr const char* kOurs = samara::identification::kMixture;
constexpr const char* kWithoutBody = "mixture without the body";

/// The same moments with a straight line in the place of the body: what a mixture reaches that knows none.
std::vector<AskedMoment> without_body(std::vector<AskedMoment> moments) {
  for (AskedMoment& asked : moments) {
    if (asked.model.size() == 0) continue;
    const Eigen::MatrixXd line =
        samara::identification::predict(samara::identification::Baseline::straight_line, asked.moment.seen,
                                        Eigen::VectorXd::Constant(1, asked.time));
    if (line.allFinite()) asked.model = line.row(0);
  }
  return moments;
}

constexpr const char* kPlacesAlone = "mixture of places alone";

/// The same moments without views: what a mixture reaches that sees places alone.
std::vector<AskedMoment> without_views(std::vector<AskedMoment> moments) {
  for (AskedMoment& asked : moments) asked.moment.seen.views.resize(0, 0);
  return moments;
}

/// The plain baseline that is best by a score.
const PredictionScore& best_plain(const SplitScores& split, double PredictionScore::*score) {
  const PredictionScore* best = nullptr;
  for (const auto& [name, one] : split.of) {
    if (!samara::identification::is_plain(name) || one.count < split.of.at(kOurs).count) continue;
    if (best == nullptr || one.*score < best->*score) best = &one;
  }
  return *best;
}

void add_forecast(const SaidForecast& said, const samara::identification::TrainingMoment& moment,
                  PredictionTally& tally) {
  tally.add(samara::identification::prediction_distances(said.mean, moment.next), moment.cluster);
  for (std::size_t c = 0; c < said.parts.size(); ++c)
    tally.add_forecast(said.parts[c], moment.next[static_cast<Eigen::Index>(c)], moment.cluster);
}

/// What the mixture says, as another predictor.
void add_mixture(const std::string& as, const std::string& name, const TrainedForecasts& trained,
                 const std::vector<AskedMoment>& unseen, std::map<std::string, PredictionTally>& tallies) {
  PredictionTally& tally = tallies.try_emplace(as, as, name).first->second;
  for (const AskedMoment& asked : unseen) {
    for (const SaidForecast& said : trained.say(asked)) {
      if (said.predictor == kOurs) add_forecast(said, asked.moment, tally);
    }
  }
}

void add_scores(const std::string& name, const TrainedForecasts& trained,
                const std::vector<AskedMoment>& unseen, std::map<std::string, PredictionTally>& tallies) {
  for (const AskedMoment& asked : unseen) {
    for (const SaidForecast& said : trained.say(asked))
      add_forecast(said, asked.moment,
                   tallies.try_emplace(said.predictor, said.predictor, name).first->second);
  }
}

}  // namespace

SplitScores score_split(const std::string& name, const std::vector<Questioned>& parts) {
  std::map<std::string, PredictionTally> tallies;
  for (const Questioned& part : parts) {
    const TrainedForecasts trained = TrainedForecasts::train(part.training, kInSpace);
    fmt::print(stderr, "{}: {} moments, {} in training;", name, part.unseen.size(), part.training.size());
    for (const auto& share : trained.shares()) fmt::print(stderr, " {:.2f} {}", share.share, share.predictor);
    const auto& correction = trained.autoregression().correction();
    fmt::print(stderr, "; correction: length {}, ridge {}\n", correction.length(), correction.ridge());
    add_scores(name, trained, part.unseen, tallies);
    add_mixture(kWithoutBody, name,
                TrainedForecasts::train(without_body(part.training), kInSpace, trained.autoregression()),
                without_body(part.unseen), tallies);
    if (!trained.autoregression().turning().sees_views()) continue;
    add_mixture(kPlacesAlone, name, TrainedForecasts::train(without_views(part.training), kInSpace),
                without_views(part.unseen), tallies);
  }
  SplitScores result;
  for (const auto& [predictor, tally] : tallies) {
    const PredictionScore score = tally.score();
    result.of[predictor] = score;
    if (score.count == 0) continue;
    fmt::print(
        stderr,
        "  {:22} median {:6.2f} mm, rms {:6.2f} mm, crps {:6.2f} mm, {:.2f} in 50 %, {:.2f} +- {:.2f} in "
        "90 %\n",
        predictor, 1e3 * score.median, 1e3 * score.rms, 1e3 * score.crps, score.coverage50, score.coverage90,
        score.coverage90_error);
  }
  const PredictionScore& best = best_plain(result, &PredictionScore::median);
  const auto behind = tallies.at(kOurs).behind(tallies.at(best.predictor));
  fmt::print(stderr, "  median less that of {}: {:.2f} +- {:.2f} mm\n", best.predictor, 1e3 * behind.value,
             1e3 * behind.error);
  const auto by_body = tallies.at(kOurs).behind(tallies.at(kWithoutBody));
  fmt::print(stderr, "  median less that of the {}: {:.2f} +- {:.2f} mm\n", kWithoutBody, 1e3 * by_body.value,
             1e3 * by_body.error);
  return result;
}

void report(const std::string& test_case, const std::vector<SplitScores>& splits, const std::string& suffix) {
  /// @returns the split in which ours is worst
  const auto worst_by = [&](const std::string& metric, double PredictionScore::*score) -> const SplitScores& {
    Measurement worst{kBench, test_case, metric + suffix, 0.0, "m", "best_plain"};
    const SplitScores* where = nullptr;
    for (const SplitScores& split : splits) {
      const double ours = split.of.at(kOurs).*score;
      const double ratio = best_plain(split, score).*score / ours;
      if (worst.ratio && ratio >= *worst.ratio) continue;
      worst.value = ours;
      worst.ratio = ratio;
      where = &split;
    }
    print(worst);
    return *where;
  };
  const SplitScores& by_median = worst_by("median", &PredictionScore::median);
  worst_by("rms", &PredictionScore::rms);
  const SplitScores& by_crps = worst_by("crps", &PredictionScore::crps);
  // What the body brings, beside what training motions do without it: of the splits of ours, as ratios to ours.
  const auto beside = [&](const char* metric, const SplitScores& split, const char* predictor,
                          double PredictionScore::*score) {
    const double value = split.of.at(predictor).*score;
    print({kBench, test_case, metric + suffix, value, "m", kOurs, split.of.at(kOurs).*score / value});
  };
  beside("median_without_body", by_median, kWithoutBody, &PredictionScore::median);
  beside("crps_without_body", by_crps, kWithoutBody, &PredictionScore::crps);
  beside("median_autoregression", by_median, samara::identification::kAutoregression,
         &PredictionScore::median);
  beside("median_body", by_median, "model", &PredictionScore::median);
  if (by_median.of.contains(kPlacesAlone))
    beside("median_places_alone", by_median, kPlacesAlone, &PredictionScore::median);
  const PredictionScore* farthest = nullptr;
  double sum = 0.0;
  for (const SplitScores& split : splits) {
    const PredictionScore& here = split.of.at(kOurs);
    sum += here.coverage90;
    if (farthest == nullptr || std::abs(here.coverage90 - 0.9) > std::abs(farthest->coverage90 - 0.9))
      farthest = &here;
  }
  print({kBench, test_case, "coverage90" + suffix, farthest->coverage90});
  if (std::isfinite(farthest->coverage90_error))
    print({kBench, test_case, "coverage90_error" + suffix, farthest->coverage90_error});
  if (splits.size() > 1)
    print({kBench, test_case, "coverage90_mean" + suffix, sum / static_cast<double>(splits.size())});
}

}  // namespace samara::benchmarks::prediction
