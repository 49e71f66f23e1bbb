#include "samara/identification/fit/motion_forecasts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace samara::identification {

namespace {

constexpr std::size_t kSlots = 10;

AskedMoment asked(const CapturePrediction& one, const Quantity& quantity, Eigen::Index frame, int cluster) {
  AskedMoment moment{.moment = {.cluster = cluster, .seen = seen_of(one, quantity)},
                     .time = one.times[frame]};
  moment.moment.next = one.truth(frame, quantity.columns);
  const Eigen::RowVectorXd model = one.model.rows() > frame
                                       ? Eigen::RowVectorXd(one.model(frame, quantity.columns))
                                       : Eigen::RowVectorXd();
  if (model.size() > 0 && model.allFinite()) moment.model = model;
  return moment;
}

}  // namespace

SeenMotion seen_of(const CapturePrediction& one, const Quantity& quantity) {
  SeenMotion seen{.times = one.seen.times, .positions = one.seen.positions(Eigen::all, quantity.columns)};
  if (one.seen.rates.size() > 0) seen.rates = one.seen.rates(Eigen::all, quantity.columns);
  seen.up = quantity.up;
  return seen;
}

MotionForecasts::MotionForecasts(std::span<const Quantity> compared,
                                 std::span<const CapturePrediction> predictions,
                                 const PredictionOptions& prediction)
    : compared_(compared.begin(), compared.end()), prediction_(prediction), trained_(compared.size()) {
  for (std::size_t q = 0; q < compared_.size(); ++q) {
    if (compared_[q].is_attitude || compared_[q].period != 0.0 || predictions.empty()) continue;
    std::vector<std::vector<AskedMoment>> moments(kSlots);
    for (const CapturePrediction& one : predictions) {
      for (Eigen::Index frame = 0; frame < one.times.size(); ++frame)
        moments[slot_of(one.times[frame])].push_back(asked(one, compared_[q], frame, one.cluster));
    }
    for (const std::vector<AskedMoment>& slot : moments)
      trained_[q].push_back(TrainedForecasts::train(slot, compared_[q].components));
  }
}

std::size_t MotionForecasts::slot_of(double time) const {
  const double part = (time - prediction_.span) / prediction_.ahead;
  constexpr double kRounding = 1e-6;
  const double slot = std::ceil(static_cast<double>(kSlots) * part - kRounding) - 1.0;
  return static_cast<std::size_t>(std::clamp(slot, 0.0, static_cast<double>(kSlots - 1)));
}

std::vector<SaidForecast> MotionForecasts::say(std::size_t quantity, const CapturePrediction& one,
                                               Eigen::Index frame) const {
  if (trained_[quantity].empty()) return {};
  const TrainedForecasts& trained = trained_[quantity][slot_of(one.times[frame])];
  return trained.say(asked(one, compared_[quantity], frame, -1));
}

std::string MotionForecasts::shares(std::size_t quantity) const {
  if (trained_[quantity].empty()) return {};
  std::string shares;
  for (const auto& [predictor, share] : trained_[quantity].back().shares()) {
    constexpr double kShown = 0.005;
    if (share >= kShown) shares += fmt::format("{}{:.2f} {}", shares.empty() ? "" : ", ", share, predictor);
  }
  if (shares.empty()) return {};
  return fmt::format("the mixture of {}, {:.4g} s ahead: {}", compared_[quantity].name, prediction_.ahead,
                     shares);
}

}  // namespace samara::identification
