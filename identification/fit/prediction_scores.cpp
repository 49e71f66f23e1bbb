#include "samara/identification/fit/prediction_scores.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include <fmt/format.h>

#include "samara/identification/problem/fit_problem.h"
#include "samara/identification/smoothing/continuous_angles.h"
#include "samara/identification/smoothing/smoothing.h"

namespace samara::identification {

namespace {

/// A frame counts as the last one ahead if it lies within this part of the way from its end.
constexpr double kAtEnd = 0.1;

/// The name of all outputs of the unit together; empty where each is one by itself.
std::string name_together(const std::string& unit, const std::vector<models::FamilyOutput>& outputs) {
  if (unit == "m") return "position";
  if (std::ranges::count(outputs, unit, &models::FamilyOutput::unit) < 2) return {};
  return unit == "m/s" ? "velocity" : unit == "rad/s" ? "angular velocity" : "";
}

/// The model, and every baseline.
struct Predictor {
  std::optional<Baseline> baseline = {};  ///< empty: the model

  std::string name() const { return baseline ? to_string(*baseline) : "model"; }
};

std::vector<Predictor> all_predictors() {
  std::vector<Predictor> all(1);
  for (const Baseline baseline : all_baselines()) all.push_back({.baseline = baseline});
  return all;
}

/// The name of a quantity in the last frame of all.
std::string at_end(const Quantity& quantity, const PredictionOptions& prediction) {
  return fmt::format("{}, {:.4g} s ahead", quantity.name, prediction.ahead);
}

/// What every predictor makes of every quantity.
class Tallies {
 public:
  /// @param reach s, to which there are frames
  Tallies(const std::vector<Predictor>& predictors, const std::vector<Quantity>& compared,
          const PredictionOptions& prediction, double reach)
      : predictors_(predictors.size()) {
    for (const Quantity& q : compared) {
      for (const Predictor& p : predictors) {
        last_.emplace_back(p.name(), at_end(q, prediction), q.unit);
        all_.emplace_back(p.name(), fmt::format("{}, up to {:.4g} s ahead", q.name, reach), q.unit);
      }
    }
  }

  /// @param distances frame by frame, of one capture
  /// @param last of them; may be empty
  void add(std::size_t quantity, std::size_t predictor, const std::vector<double>& distances,
           const std::vector<double>& last) {
    all_[quantity * predictors_ + predictor].add(distances);
    last_[quantity * predictors_ + predictor].add(last);
  }

  /// @param capture whose they are; empty: of all
  void add_scores(const std::string& capture, std::vector<PredictionScore>& scores) const {
    for (std::size_t first = 0; first < all_.size(); first += predictors_) {
      for (const auto& tallies : {last_, all_})
        add_group(capture, std::span(tallies).subspan(first, predictors_), scores);
    }
  }

 private:
  static void add_group(const std::string& capture, std::span<const PredictionTally> tallies,
                        std::vector<PredictionScore>& scores) {
    std::vector<PredictionScore> group;
    double least = std::numeric_limits<double>::infinity();
    for (const PredictionTally& tally : tallies) {
      PredictionScore score = tally.score();
      score.capture = capture;
      // Only where sensors measure it is there such a predictor.
      const bool is_absent = score.predictor == to_string(Baseline::measured_velocity) && score.count == 0;
      if (!is_absent) group.push_back(score);
      if (score.count > 0) least = std::min(least, score.median);
    }
    if (std::isinf(least)) return;
    for (PredictionScore& score : group) {
      score.best = score.count > 0 && score.median == least;
      scores.push_back(std::move(score));
    }
  }

  std::size_t predictors_;
  std::vector<PredictionTally> all_, last_;  ///< quantities x predictors
};

/// Only where the last frame lies near the end of the way does its distance count as one there.
bool reaches_end(const CapturePrediction& one, const PredictionOptions& prediction) {
  const double end = prediction.span + prediction.ahead;
  return one.times[one.times.size() - 1] >= end - kAtEnd * prediction.ahead;
}

/// What repeats goes on where it was seen to jump: baselines are polynomials.
void unwrap(const std::vector<Quantity>& compared, SeenMotion& seen) {
  for (const Quantity& q : compared) {
    if (q.period == 0.0) continue;
    for (const int column : q.columns)
      seen.positions.col(column) = unwrapped(seen.times, seen.positions.col(column), q.period);
  }
}

/// The same points of a circle of length `period`, where they are nearest to others.
Eigen::MatrixXd nearest(const Eigen::MatrixXd& points, const Eigen::MatrixXd& others, double period) {
  if (period == 0.0) return points;
  return others + (points - others).unaryExpr([&](double d) { return std::remainder(d, period); });
}

/// Distances of one quantity in the last frames of a capture that was predicted.
std::vector<double> distances_of(const CapturePrediction& one, const Quantity& quantity,
                                 const Eigen::MatrixXd& predicted, const Eigen::MatrixX4d& attitudes,
                                 Eigen::Index frames) {
  if (quantity.is_attitude)
    return turn_distances(attitudes.bottomRows(frames), one.truth_attitude.bottomRows(frames));
  const Eigen::MatrixXd guess = predicted(Eigen::all, quantity.columns).bottomRows(frames);
  const Eigen::MatrixXd truth = one.truth(Eigen::all, quantity.columns).bottomRows(frames);
  return prediction_distances(guess, nearest(truth, guess, quantity.period));
}

/// What a predictor says of a capture: outputs and attitudes.
std::pair<Eigen::MatrixXd, Eigen::MatrixX4d> said_by(const Predictor& predictor,
                                                     const CapturePrediction& one) {
  if (!predictor.baseline) return {one.model, one.model_attitude};
  return {predict(*predictor.baseline, one.seen, one.times),
          predict_turn(*predictor.baseline, one.turn, one.times)};
}

/// @param tallies to which the capture adds: of all, and its own
void tally(const CapturePrediction& one, const std::vector<Predictor>& predictors,
           const std::vector<Quantity>& compared, const PredictionOptions& prediction,
           std::span<Tallies* const> tallies) {
  const Eigen::Index frames = one.times.size();
  for (std::size_t p = 0; p < predictors.size(); ++p) {
    const auto [values, attitudes] = said_by(predictors[p], one);
    for (std::size_t k = 0; k < compared.size(); ++k) {
      const auto all = distances_of(one, compared[k], values, attitudes, frames);
      const auto last =
          distances_of(one, compared[k], values, attitudes, reaches_end(one, prediction) ? 1 : 0);
      for (Tallies* const each : tallies) each->add(k, p, all, last);
    }
  }
}

}  // namespace

std::vector<Quantity> quantities(const PredictedOutputs& predicted, const FitOptions& options) {
  std::vector<Quantity> result;
  for (std::size_t o = 0; o < predicted.outputs.size(); ++o) {
    const models::FamilyOutput& output = predicted.outputs[o];
    const std::string together = name_together(output.unit, predicted.outputs);
    const auto found = std::ranges::find(result, together, &Quantity::name);
    if (!together.empty() && found != result.end()) {
      found->columns.push_back(static_cast<int>(o));
    } else {
      result.push_back({together.empty() ? output.name : together,
                        output.unit,
                        period_of(output, options),
                        {static_cast<int>(o)}});
    }
  }
  if (!predicted.attitude.empty()) result.push_back({.name = "attitude", .unit = "rad", .is_attitude = true});
  return result;
}

double reach_of(const std::vector<CapturePrediction>& predictions, const PredictionOptions& prediction) {
  double reach = 0.0;
  for (const CapturePrediction& one : predictions)
    reach = std::max(reach, one.times[one.times.size() - 1] - prediction.span);
  return reach >= (1.0 - kAtEnd) * prediction.ahead ? prediction.ahead : reach;
}

Scores scores_of(const std::vector<Quantity>& compared, std::vector<CapturePrediction> predictions,
                 const PredictionOptions& prediction) {
  const std::vector<Predictor> predictors = all_predictors();
  Tallies all(predictors, compared, prediction, reach_of(predictions, prediction));
  std::vector<std::pair<std::string, Tallies>> motions;
  for (CapturePrediction& one : predictions) {
    unwrap(compared, one.seen);
    if (motions.empty() || motions.back().first != one.motion)
      motions.emplace_back(one.motion,
                           Tallies(predictors, compared, prediction, reach_of(predictions, prediction)));
    Tallies* const tallies[] = {&all, &motions.back().second};
    tally(one, predictors, compared, prediction, tallies);
  }
  Scores scores;
  all.add_scores("", scores.all);
  for (const auto& [motion, of_motion] : motions) of_motion.add_scores(motion, scores.by_capture);
  return scores;
}

std::vector<ForecastError> forecast_errors(const std::vector<Quantity>& compared,
                                           std::vector<CapturePrediction> predictions,
                                           const PredictionOptions& prediction) {
  std::vector<ForecastError> errors;
  for (CapturePrediction& one : predictions) {
    unwrap(compared, one.seen);
    if (!reaches_end(one, prediction)) continue;
    for (const Predictor& predictor : all_predictors()) {
      const auto [values, attitudes] = said_by(predictor, one);
      for (const Quantity& q : compared) {
        for (const double distance : distances_of(one, q, values, attitudes, 1)) {
          errors.push_back({.file = one.file,
                            .motion = one.motion,
                            .part = one.part,
                            .quantity = at_end(q, prediction),
                            .unit = q.unit,
                            .predictor = predictor.name(),
                            .distance = distance});
        }
      }
    }
  }
  return errors;
}

}  // namespace samara::identification
