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

/// A place in space, whose z is up.
void add_components(const PredictedOutputs& predicted, Quantity& quantity) {
  std::vector<int> found;
  for (const char* name : {"x", "y", "z"}) {
    const auto place = std::ranges::find_if(quantity.columns, [&](int column) {
      return predicted.outputs[static_cast<std::size_t>(column)].name == name;
    });
    if (place != quantity.columns.end()) found.push_back(static_cast<int>(place - quantity.columns.begin()));
  }
  if (quantity.unit != "m" || found.size() != 3 || quantity.columns.size() != 3) return;
  quantity.components.level = {found[0], found[1]};
  quantity.up = found[2];
}

/// The model, every baseline, and what training makes of them.
struct Predictor {
  std::string name = "model";
  std::optional<Baseline> baseline = {};  ///< empty: the model, or a forecast that was trained
  bool is_trained = false;
};

std::vector<Predictor> all_predictors() {
  std::vector<Predictor> all(1);
  for (const Baseline baseline : all_baselines())
    all.push_back({.name = to_string(baseline), .baseline = baseline});
  // In the order of TrainedForecasts::say().
  for (const char* name : {kMixtureOfBaselines, kAutoregression, kMixture})
    all.push_back({.name = name, .is_trained = true});
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
        last_.emplace_back(p.name, at_end(q, prediction), q.unit);
        all_.emplace_back(p.name, fmt::format("{}, up to {:.4g} s ahead", q.name, reach), q.unit);
      }
    }
  }

  /// @param distances frame by frame, of one capture
  /// @param last of them; may be empty
  /// @param cluster of the capture
  void add(std::size_t quantity, std::size_t predictor, const std::vector<double>& distances,
           const std::vector<double>& last, int cluster) {
    all_[quantity * predictors_ + predictor].add(distances, cluster);
    last_[quantity * predictors_ + predictor].add(last, cluster);
  }

  /// One number of a distribution that was forecast.
  /// @param cluster of the capture
  void add_forecast(std::size_t quantity, std::size_t predictor, bool is_last, const NormalMixture& part,
                    double measured, int cluster) {
    all_[quantity * predictors_ + predictor].add_forecast(part, measured, cluster);
    if (is_last) last_[quantity * predictors_ + predictor].add_forecast(part, measured, cluster);
  }

  /// @param file of the capture
  /// @param capture whose they are; empty: of all
  void add_scores(const std::string& file, const std::string& capture,
                  std::vector<PredictionScore>& scores) const {
    for (std::size_t first = 0; first < all_.size(); first += predictors_) {
      for (const auto& tallies : {last_, all_})
        add_group(file, capture, std::span(tallies).subspan(first, predictors_), scores);
    }
  }

 private:
  static void add_group(const std::string& file, const std::string& capture,
                        std::span<const PredictionTally> tallies, std::vector<PredictionScore>& scores) {
    std::vector<PredictionScore> group;
    double least = std::numeric_limits<double>::infinity();
    // One that gives no forecast where others do may have left out what is hard: the best is one of those that give
    // most.
    int most = 0;
    for (const PredictionTally& tally : tallies) most = std::max(most, tally.score().count);
    for (const PredictionTally& tally : tallies) {
      PredictionScore score = tally.score();
      score.capture = capture;
      score.file = file;
      // Only where sensors measure it, or something is up, or captures have trained it is there such a predictor.
      if (score.count > 0 || is_always_there(score.predictor)) group.push_back(score);
      if (score.count > 0 && score.count == most) least = std::min(least, score.median);
    }
    if (std::isinf(least)) return;
    for (PredictionScore& score : group) {
      score.best = score.count > 0 && score.count == most && score.median == least;
    }
    if (capture.empty()) add_differences(tallies, group);
    for (PredictionScore& score : group) scores.push_back(std::move(score));
  }

  static bool is_always_there(const std::string& predictor) {
    return predictor != to_string(Baseline::measured_velocity) &&
           predictor != to_string(Baseline::point_with_drag) && predictor != kMixtureOfBaselines &&
           predictor != kAutoregression && predictor != kMixture;
  }

  /// How much worse each is than the plain baseline with the least median of those that say most.
  static void add_differences(std::span<const PredictionTally> tallies, std::vector<PredictionScore>& group) {
    const PredictionTally* best = nullptr;
    const auto rank = [](const PredictionScore& score) { return std::pair(-score.count, score.median); };
    for (const PredictionTally& tally : tallies) {
      const PredictionScore score = tally.score();
      if (!is_plain(score.predictor) || score.count == 0) continue;
      if (best == nullptr || rank(score) < rank(best->score())) best = &tally;
    }
    if (best == nullptr) return;
    for (PredictionScore& score : group) {
      const auto tally = std::ranges::find_if(
          tallies, [&](const PredictionTally& one) { return one.score().predictor == score.predictor; });
      const PredictionTally::Difference difference = tally->behind(*best);
      score.behind_best = difference.value;
      score.behind_best_error = difference.error;
    }
  }

  std::size_t predictors_;
  std::vector<PredictionTally> all_, last_;  ///< quantities x predictors
};

/// What repeats goes on where it was seen to jump: baselines are polynomials.
void unwrap(const std::vector<Quantity>& compared, SeenMotion& seen) {
  for (const Quantity& q : compared) {
    if (q.period == 0.0) continue;
    for (const int column : q.columns)
      seen.positions.col(column) = unwrapped(seen.times, seen.positions.col(column), q.period);
  }
}

/// What trained forecasts say of one capture: distances of those that are nothing else, and distributions.
void tally_trained(const CapturePrediction& one, const std::vector<Predictor>& predictors,
                   std::size_t quantity, const Quantity& compared, const PredictionOptions& prediction,
                   std::span<Tallies* const> tallies) {
  const Eigen::Index frames = one.times.size();
  std::vector<std::vector<double>> all(predictors.size()), last(predictors.size());
  for (Eigen::Index frame = 0; frame < frames; ++frame) {
    const bool is_last = frame + 1 == frames && reaches_end(one, prediction);
    const Eigen::RowVectorXd truth = one.truth(frame, compared.columns);
    const std::vector<SaidForecast> said = one.trained->say(quantity, one, frame);
    for (std::size_t p = 0; p < said.size(); ++p) {
      if (predictors[p].is_trained) {
        const std::vector<double> distance = prediction_distances(said[p].mean, truth);
        all[p].insert(all[p].end(), distance.begin(), distance.end());
        if (is_last) last[p] = distance;
      }
      for (std::size_t c = 0; c < said[p].parts.size(); ++c) {
        for (Tallies* const each : tallies)
          each->add_forecast(quantity, p, is_last, said[p].parts[c], truth[static_cast<Eigen::Index>(c)],
                             one.cluster);
      }
    }
  }
  for (std::size_t p = 0; p < predictors.size(); ++p) {
    for (Tallies* const each : tallies) {
      if (predictors[p].is_trained) each->add(quantity, p, all[p], last[p], one.cluster);
    }
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

/// What the model or a baseline says of a capture: outputs and attitudes.
std::pair<Eigen::MatrixXd, Eigen::MatrixX4d> said_by(const Predictor& predictor, const CapturePrediction& one,
                                                     const std::vector<Quantity>& compared) {
  if (!predictor.baseline) return {one.model, one.model_attitude};
  Eigen::MatrixXd values = predict(*predictor.baseline, one.seen, one.times);
  for (const Quantity& q : compared) {
    // Components of a point with drag belong together.
    if (*predictor.baseline != Baseline::point_with_drag || q.is_attitude) continue;
    const Eigen::MatrixXd point = predict(*predictor.baseline, seen_of(one, q), one.times);
    for (std::size_t c = 0; c < q.columns.size(); ++c)
      values.col(q.columns[c]) = point.col(static_cast<Eigen::Index>(c));
  }
  return {values, predict_turn(*predictor.baseline, one.turn, one.times)};
}

/// Mean over components; NaN where no distribution was said.
double crps_of(const SaidForecast& said, const Eigen::RowVectorXd& truth) {
  double sum = 0.0;
  for (std::size_t c = 0; c < said.parts.size(); ++c)
    sum += crps(said.parts[c], truth[static_cast<Eigen::Index>(c)]);
  return said.parts.empty() ? std::nan("") : sum / static_cast<double>(said.parts.size());
}

/// @param tallies to which the capture adds: of all, and its own
void tally(const CapturePrediction& one, const std::vector<Predictor>& predictors,
           const std::vector<Quantity>& compared, const PredictionOptions& prediction,
           std::span<Tallies* const> tallies) {
  const Eigen::Index frames = one.times.size();
  for (std::size_t p = 0; p < predictors.size(); ++p) {
    if (predictors[p].is_trained) continue;
    const auto [values, attitudes] = said_by(predictors[p], one, compared);
    for (std::size_t k = 0; k < compared.size(); ++k) {
      const auto all = distances_of(one, compared[k], values, attitudes, frames);
      const auto last =
          distances_of(one, compared[k], values, attitudes, reaches_end(one, prediction) ? 1 : 0);
      for (Tallies* const each : tallies) each->add(k, p, all, last, one.cluster);
    }
  }
  for (std::size_t k = 0; one.trained && k < compared.size(); ++k)
    tally_trained(one, predictors, k, compared[k], prediction, tallies);
}

}  // namespace

double net_weight(const models::TrajectoryFamily& family, const FitOptions& held) {
  const auto value_of = [&](const std::string& name) -> std::optional<double> {
    for (const auto& values : {held.unknowns.fixed, family.info().fixed}) {
      if (const auto found = values.find(name); found != values.end()) return found->second;
    }
    const models::ParametricModel* const equations = family.equations();
    if (equations == nullptr) return {};
    const auto& parameters = equations->model().info().parameters;
    const auto found = std::ranges::find(parameters, name, &models::ParameterInfo::name);
    const bool is_free =
        std::ranges::count(family.info().coordinates, name, &models::FamilyCoordinate::name) > 0;
    return found == parameters.end() || is_free ? std::nullopt : found->default_value;
  };
  const double g = value_of("g").value_or(kStandardG);
  for (const auto& [own, displaced] : {std::pair{"density", "fluid_density"}, {"mass", "displaced_mass"}}) {
    const std::optional<double> body = value_of(own), fluid = value_of(displaced);
    if (!body || !fluid) continue;
    const double beside = own == std::string("mass") ? value_of("offset_mass").value_or(0.0) : 0.0;
    return g * (1.0 - *fluid / (*body + beside));
  }
  return g;
}

std::vector<Quantity> quantities(const models::TrajectoryFamily& family, const PredictedOutputs& predicted,
                                 const FitOptions& held) {
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
                        period_of(output, held),
                        {static_cast<int>(o)}});
    }
  }
  for (Quantity& quantity : result) {
    add_components(predicted, quantity);
    quantity.net_weight = net_weight(family, held);
  }
  if (!predicted.attitude.empty()) result.push_back({.name = "attitude", .unit = "rad", .is_attitude = true});
  return result;
}

bool reaches_end(const CapturePrediction& one, const PredictionOptions& prediction) {
  const double end = prediction.span + prediction.ahead;
  return one.times[one.times.size() - 1] >= end - kAtEnd * prediction.ahead;
}

double reach_of(const std::vector<CapturePrediction>& predictions, const PredictionOptions& prediction) {
  double reach = 0.0;
  for (const CapturePrediction& one : predictions) {
    if (reaches_end(one, prediction)) return prediction.ahead;
    reach = std::max(reach, one.times[one.times.size() - 1] - prediction.span);
  }
  return reach;
}

Scores scores_of(const std::vector<Quantity>& compared, std::vector<CapturePrediction> predictions,
                 const PredictionOptions& prediction) {
  const std::vector<Predictor> predictors = all_predictors();
  Tallies all(predictors, compared, prediction, reach_of(predictions, prediction));
  // Captures of several files may have one id.
  std::vector<std::pair<std::pair<std::string, std::string>, Tallies>> motions;
  for (CapturePrediction& one : predictions) {
    unwrap(compared, one.seen);
    const std::pair motion(one.file, one.motion);
    if (motions.empty() || motions.back().first != motion)
      motions.emplace_back(motion,
                           Tallies(predictors, compared, prediction, reach_of(predictions, prediction)));
    Tallies* const tallies[] = {&all, &motions.back().second};
    tally(one, predictors, compared, prediction, tallies);
  }
  Scores scores;
  all.add_scores("", "", scores.all);
  for (const auto& [motion, of_motion] : motions)
    of_motion.add_scores(motion.first, motion.second, scores.by_capture);
  return scores;
}

std::vector<ForecastError> forecast_errors(const std::vector<Quantity>& compared,
                                           std::vector<CapturePrediction> predictions,
                                           const PredictionOptions& prediction) {
  const std::vector<Predictor> predictors = all_predictors();
  std::vector<ForecastError> errors;
  for (CapturePrediction& one : predictions) {
    unwrap(compared, one.seen);
    if (!reaches_end(one, prediction)) continue;
    const Eigen::Index last = one.times.size() - 1;
    for (std::size_t q = 0; q < compared.size(); ++q) {
      const std::vector<SaidForecast> trained =
          one.trained ? one.trained->say(q, one, last) : std::vector<SaidForecast>{};
      for (std::size_t p = 0; p < predictors.size(); ++p) {
        if (predictors[p].is_trained && p >= trained.size()) continue;
        const Eigen::RowVectorXd truth =
            trained.empty() ? Eigen::RowVectorXd() : Eigen::RowVectorXd(one.truth(last, compared[q].columns));
        std::vector<double> distances;
        if (predictors[p].is_trained) {
          distances = prediction_distances(trained[p].mean, truth);
        } else {
          const auto [values, attitudes] = said_by(predictors[p], one, compared);
          distances = distances_of(one, compared[q], values, attitudes, 1);
        }
        for (const double distance : distances) {
          errors.push_back({.file = one.file,
                            .motion = one.motion,
                            .part = one.part,
                            .quantity = at_end(compared[q], prediction),
                            .unit = compared[q].unit,
                            .predictor = predictors[p].name,
                            .distance = distance,
                            .crps = p < trained.size() ? crps_of(trained[p], truth) : std::nan("")});
        }
      }
    }
  }
  return errors;
}

}  // namespace samara::identification
