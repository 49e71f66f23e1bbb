#include "samara/identification/forecasts/trained_forecasts.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace samara::identification {

namespace {

constexpr double kSilence = std::numeric_limits<double>::quiet_NaN();

std::span<const Eigen::MatrixXd> baselines_of(const std::vector<Eigen::MatrixXd>& said) {
  return std::span(said).subspan(1, all_baselines().size());
}

/// Those that take part: all but those that give no forecast in most moments.
std::vector<std::size_t> speakers(std::span<const Eigen::MatrixXd> said,
                                  const std::vector<Eigen::Index>& rows) {
  std::vector<std::size_t> result;
  for (std::size_t m = 0; m < said.size(); ++m) {
    const auto spoken =
        std::ranges::count_if(rows, [&](Eigen::Index row) { return said[m].row(row).allFinite(); });
    if (2 * spoken > std::ssize(rows)) result.push_back(m);
  }
  return result;
}

/// Shares of all, from those rows.
Eigen::VectorXd shares_of(std::span<const Eigen::MatrixXd> said, const Eigen::MatrixXd& measured,
                          const std::vector<Eigen::Index>& rows) {
  Eigen::VectorXd shares = Eigen::VectorXd::Zero(std::ssize(said));
  const std::vector<std::size_t> taking_part = speakers(said, rows);
  if (taking_part.empty()) return shares;
  std::vector<Eigen::MatrixXd> parts;
  for (const std::size_t m : taking_part) parts.emplace_back(said[m](rows, Eigen::all));
  const Eigen::VectorXd found = convex_shares(parts, measured(rows, Eigen::all));
  for (std::size_t k = 0; k < taking_part.size(); ++k)
    shares[static_cast<Eigen::Index>(taking_part[k])] = found[static_cast<Eigen::Index>(k)];
  return shares;
}

/// Predictors whose disagreement says how well the motion is foreseen: polynomials of the whole span but the
/// line, and the point, stray far where nothing is wrong.
Eigen::VectorXd disagreement_of(const std::vector<Eigen::MatrixXd>& said) {
  std::vector<Eigen::MatrixXd> compared = {said.front(), said.back()};
  for (const Baseline baseline :
       {Baseline::straight_line, Baseline::constant_velocity, Baseline::constant_acceleration}) {
    const auto place = std::ranges::find(all_baselines(), baseline) - all_baselines().begin();
    compared.push_back(said[static_cast<std::size_t>(place) + 1]);
  }
  return disagreement(compared);
}

constexpr double kLeastFeature = 1e-9;

/// Speed and acceleration in one frame, and how far predictors lie apart, as logarithms.
Eigen::RowVectorXd features_of(const SeenMotion& seen, double disagreement) {
  const Eigen::MatrixXd rates = recent_rates(seen);
  Eigen::RowVectorXd features(3);
  features << rates.row(0).norm(), rates.row(1).norm(), disagreement;
  features = (features.array() + kLeastFeature).log();
  return features.array().isNaN().select(0.0, features);
}

/// Of how large errors are (ErrorDistribution), as logarithms: speed, novelty, and how far predictors lie apart, which
/// the mixture alone knows.
/// @param disagreement unknown where 0: fewer than two predictors give a forecast
Eigen::RowVectorXd signs_of(const SeenMotion& seen, double novelty, double disagreement) {
  Eigen::RowVectorXd signs(3);
  signs << std::log(recent_rates(seen).row(0).norm() + kLeastFeature), std::log(novelty + kLeastFeature),
      disagreement > 0.0 ? std::log(disagreement) : kSilence;
  return signs;
}

/// One row of what some predictors say, by shares; those that give no forecast leave theirs to the others.
Eigen::RowVectorXd mixed(const std::vector<Eigen::MatrixXd>& said, const std::vector<std::size_t>& which,
                         const Eigen::VectorXd& shares, Eigen::Index row) {
  std::vector<Eigen::MatrixXd> rows;
  for (const std::size_t m : which) rows.emplace_back(said[m].row(row));
  return weighted(rows, shares).row(0);
}

Eigen::RowVectorXd silent(Eigen::Index count) {
  return Eigen::RowVectorXd::Constant(count, kSilence);
}

/// s, from the last frame seen to what is asked.
double way_of(const AskedMoment& asked) {
  const Eigen::VectorXd& times = asked.moment.seen.times;
  return times.size() > 0 ? asked.time - times[times.size() - 1] : kSilence;
}

/// What the predictors that are not mixtures say: model, baselines, and in the last place the autoregression, which
/// gives none here; a row a moment.
std::vector<Eigen::MatrixXd> said_by_baselines(std::span<const AskedMoment> moments) {
  const std::size_t count = all_baselines().size() + 2;
  const Eigen::Index columns = moments.empty() ? 0 : moments.front().moment.seen.positions.cols();
  std::vector<Eigen::MatrixXd> said(count, Eigen::MatrixXd(std::ssize(moments), columns));
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const TrainingMoment& moment = moments[k].moment;
    const double time = moments[k].time;
    const Eigen::RowVectorXd& model = moments[k].model;
    said.front().row(row) = model.size() == columns ? model : silent(columns);
    for (std::size_t b = 0; b < all_baselines().size(); ++b)
      said[b + 1].row(row) =
          predict(all_baselines()[b], moment.seen, Eigen::VectorXd::Constant(1, time)).row(0);
    said.back().row(row) = silent(columns);
  }
  return said;
}

}  // namespace

bool is_plain(const std::string& predictor) {
  return predictor == kMixtureOfBaselines ||
         std::ranges::any_of(all_baselines(), [&](Baseline one) { return to_string(one) == predictor; });
}

std::vector<Eigen::MatrixXd> TrainedForecasts::heard_by_mixtures(const AskedMoment& asked,
                                                                 std::vector<Eigen::MatrixXd> said) const {
  constexpr double kBeyond = 2.0;
  for (std::size_t b = 0; b < gains_.size(); ++b) {
    const double gain = noise_gain(all_baselines()[b], asked.moment.seen, asked.time);
    if (gain > kBeyond * gains_[b]) said[b + 1].setConstant(kSilence);
  }
  const double way = way_of(asked);
  if (way > kBeyond * longest_way_ || kBeyond * way < shortest_way_) said.back().setConstant(kSilence);
  return said;
}

TrainedForecasts TrainedForecasts::train(std::span<const AskedMoment> moments, const Components& components) {
  std::vector<TrainingMoment> seen;
  for (const AskedMoment& one : moments) seen.push_back(one.moment);
  return train(moments, components, Autoregression::fit(seen, components));
}

TrainedForecasts TrainedForecasts::train(std::span<const AskedMoment> all_moments,
                                         const Components& components, const Autoregression& autoregression) {
  TrainedForecasts result;
  result.components_ = components;
  result.autoregression_ = autoregression;
  std::vector<AskedMoment> moments;
  std::vector<Eigen::Index> all, asked;
  for (const AskedMoment& one : all_moments) {
    if (one.for_autoregression_only) continue;
    if (one.model.size() > 0) asked.push_back(std::ssize(all));
    all.push_back(std::ssize(all));
    moments.push_back(one);
  }
  std::vector<Eigen::MatrixXd> said = said_by_baselines(moments);
  for (const Eigen::Index row : all) {
    const TrainingMoment& one = moments[static_cast<std::size_t>(row)].moment;
    said.back().row(row) = autoregression.predict_without(one.cluster, one.seen, one.known);
  }
  result.gains_.assign(all_baselines().size(), 0.0);
  result.shortest_way_ = std::numeric_limits<double>::infinity();
  for (const AskedMoment& one : moments) {
    for (std::size_t b = 0; b < result.gains_.size(); ++b) {
      const double gain = noise_gain(all_baselines()[b], one.moment.seen, one.time);
      if (gain > result.gains_[b]) result.gains_[b] = gain;
    }
    result.longest_way_ = std::max(result.longest_way_, way_of(one));
    result.shortest_way_ = std::min(result.shortest_way_, way_of(one));
  }
  Eigen::MatrixXd measured(std::ssize(moments), said.front().cols());
  std::vector<int> of_all;  // clusters
  for (const Eigen::Index row : all) {
    const AskedMoment& one = moments[static_cast<std::size_t>(row)];
    measured.row(row) = one.moment.next;
    of_all.push_back(one.moment.cluster);
  }
  result.of_baselines_ = shares_of(baselines_of(said), measured, all);
  result.mixed_ = speakers(said, asked);
  const Eigen::VectorXd disagreements = disagreement_of(said);
  // Shares from moments in which all of these give a forecast.
  std::vector<Eigen::MatrixXd> errors;
  std::vector<Eigen::RowVectorXd> features;
  std::vector<int> clusters;
  for (const Eigen::Index row : asked) {
    Eigen::MatrixXd error(std::ssize(result.mixed_), measured.cols());
    for (std::size_t m = 0; m < result.mixed_.size(); ++m)
      error.row(static_cast<Eigen::Index>(m)) = said[result.mixed_[m]].row(row) - measured.row(row);
    if (!error.allFinite()) continue;
    errors.push_back(error);
    const TrainingMoment& moment = moments[static_cast<std::size_t>(row)].moment;
    features.push_back(features_of(moment.seen, disagreements[row]));
    clusters.push_back(moment.cluster);
  }
  Eigen::MatrixXd rows(std::ssize(features), 3);
  for (std::size_t k = 0; k < features.size(); ++k) rows.row(static_cast<Eigen::Index>(k)) = features[k];
  result.shares_ = LocalShares::fit(errors, rows, clusters);
  std::vector<TrainingMoment> seen;
  for (const AskedMoment& one : moments) seen.push_back(one.moment);
  result.novelty_ = Novelty::fit(seen, components);
  Eigen::MatrixXd of_one = Eigen::MatrixXd::Constant(std::ssize(all), 3, kSilence), of_mixed = of_one;
  Eigen::MatrixXd of_mixture = Eigen::MatrixXd::Constant(std::ssize(all), measured.cols(), kSilence);
  // Where the model has little to say, the mixture says without it what it would say with it.
  constexpr double kLittle = 0.1;
  const bool has_model = !result.mixed_.empty() && result.mixed_.front() == 0;
  const bool counts_without = result.is_mixed() && (!has_model || result.shares_.of_all()[0] < kLittle);
  for (const Eigen::Index row : all) {
    const TrainingMoment& one = seen[static_cast<std::size_t>(row)];
    const double novelty = result.novelty_.without(one.cluster, one.seen);
    of_one.row(row) = signs_of(one.seen, novelty, kSilence);
    of_mixed.row(row) = signs_of(one.seen, novelty, disagreements[row]);
    if (!result.is_mixed() || (moments[static_cast<std::size_t>(row)].model.size() == 0 && !counts_without))
      continue;
    const Eigen::VectorXd shares =
        result.shares_.without(one.cluster, features_of(one.seen, disagreements[row]));
    of_mixture.row(row) = measured.row(row) - mixed(said, result.mixed_, shares, row);
  }
  const auto add_errors = [&](const Eigen::MatrixXd& missed, const Eigen::MatrixXd& signs) {
    result.errors_.push_back(ErrorDistribution::fit(missed, components, signs, of_all));
  };
  for (std::size_t m = 0; m + 1 < said.size(); ++m) add_errors(measured - said[m], of_one);
  add_errors(measured - weighted(baselines_of(said), result.of_baselines_), of_one);
  add_errors(measured - said.back(), of_one);
  add_errors(of_mixture, of_mixed);
  return result;
}

std::vector<SaidForecast> TrainedForecasts::say(const AskedMoment& asked) const {
  return say(asked, autoregression_.predict(asked.moment.seen, asked.moment.known));
}

std::vector<SaidForecast> TrainedForecasts::say(const AskedMoment& asked,
                                                const Eigen::RowVectorXd& autoregression) const {
  std::vector<Eigen::MatrixXd> said = said_by_baselines(std::span(&asked, 1));
  said.back().row(0) = autoregression;
  std::vector<SaidForecast> forecasts;
  const double novelty = novelty_.at(asked.moment.seen);
  const Eigen::RowVectorXd of_one = signs_of(asked.moment.seen, novelty, kSilence);
  const auto add = [&](std::string predictor, const Eigen::RowVectorXd& mean,
                       const Eigen::RowVectorXd& signs) {
    const ErrorDistribution& errors = errors_[forecasts.size()];
    SaidForecast forecast{.predictor = std::move(predictor), .mean = mean};
    if (mean.allFinite() && errors.is_fitted()) {
      for (Eigen::Index c = 0; c < mean.size(); ++c)
        forecast.parts.push_back(errors.around(c, mean[c], signs));
    }
    forecasts.push_back(std::move(forecast));
  };
  add("model", said.front().row(0), of_one);
  for (std::size_t b = 0; b < all_baselines().size(); ++b)
    add(to_string(all_baselines()[b]), said[b + 1].row(0), of_one);
  const std::vector<Eigen::MatrixXd> heard = heard_by_mixtures(asked, said);
  const Eigen::RowVectorXd of_baselines = weighted(baselines_of(heard), of_baselines_).row(0);
  // Where none is as sure as in training, they are all that there is.
  add(kMixtureOfBaselines,
      of_baselines.allFinite() ? of_baselines : weighted(baselines_of(said), of_baselines_).row(0), of_one);
  add(kAutoregression, said.back().row(0), of_one);
  const double disagreement = disagreement_of(said)[0];
  const Eigen::VectorXd shares = shares_.at(features_of(asked.moment.seen, disagreement));
  Eigen::RowVectorXd mixture = silent(said.front().cols());
  if (shares.size() > 0) {
    const Eigen::VectorXd alike = Eigen::VectorXd::Ones(shares.size());
    mixture = mixed(heard, mixed_, shares, 0);
    if (!mixture.allFinite()) mixture = mixed(heard, mixed_, alike, 0);
    if (!mixture.allFinite()) mixture = mixed(said, mixed_, shares, 0);
  }
  add(kMixture, mixture, signs_of(asked.moment.seen, novelty, disagreement));
  return forecasts;
}

std::vector<TrainedForecasts::Share> TrainedForecasts::shares() const {
  std::vector<Share> shares;
  for (Eigen::Index k = 0; k < shares_.of_all().size(); ++k) {
    if (!(shares_.of_all()[k] > 0.0)) continue;
    const std::size_t m = mixed_[static_cast<std::size_t>(k)], count = all_baselines().size();
    shares.push_back({m == 0       ? "model"
                      : m <= count ? to_string(all_baselines()[m - 1])
                                   : kAutoregression,
                      shares_.of_all()[k]});
  }
  return shares;
}

}  // namespace samara::identification
