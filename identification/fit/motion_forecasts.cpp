#include "samara/identification/fit/motion_forecasts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "samara/base/parallel.h"
#include "samara/identification/smoothing/medians.h"

namespace samara::identification {

namespace {

/// Times ahead that are this share of what was asked count as it.
constexpr double kReached = 0.9;

AskedMoment asked(const CapturePrediction& one, const Quantity& quantity, Eigen::Index frame, int cluster) {
  AskedMoment moment{.moment = {.cluster = cluster, .seen = seen_of(one, quantity)},
                     .time = one.times[frame]};
  moment.moment.next = one.truth(frame, quantity.columns);
  const Eigen::RowVectorXd model = one.model.rows() > frame
                                       ? Eigen::RowVectorXd(one.model(frame, quantity.columns))
                                       : Eigen::RowVectorXd();
  if (model.size() > 0 && model.allFinite()) moment.model = model;
  moment.for_autoregression_only = one.model.size() == 0;
  return moment;
}

/// s, of a frame beyond the last one seen.
double ahead_of(const CapturePrediction& one, Eigen::Index frame) {
  return one.times[frame] - one.seen.times[one.seen.times.size() - 1];
}

/// s, the shortest between frames of a capture that the model predicts: spans that only teach are many and short.
double shortest_interval(std::span<const CapturePrediction> predictions) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const CapturePrediction& one : predictions) {
    if (one.model.size() > 0) shortest = std::min(shortest, median_interval(one.seen.times));
  }
  return shortest;
}

/// A frame of a prediction.
struct FrameAhead {
  std::size_t prediction;
  Eigen::Index frame;
};

/// Of many horizons, those that others can be told from.
void thin_out(std::map<long, std::vector<FrameAhead>>& frames) {
  constexpr int kNear = 16;
  constexpr double kFarther = 1.0 + 1.0 / 7.0;
  long kept = 0;
  int count = 0;
  for (auto one = frames.begin(); one != frames.end();) {
    const bool is_last = std::next(one) == frames.end();
    if (count < kNear || is_last || static_cast<double>(one->first) >= kFarther * static_cast<double>(kept)) {
      kept = one->first;
      ++count;
      ++one;
    } else {
      one = frames.erase(one);
    }
  }
}

/// Frames by how many of the shortest intervals they lie ahead.
std::map<long, std::vector<FrameAhead>> frames_by_horizon(std::span<const CapturePrediction> predictions) {
  std::map<long, std::vector<FrameAhead>> frames;
  const double interval = shortest_interval(predictions);
  for (std::size_t k = 0; k < predictions.size(); ++k) {
    for (Eigen::Index frame = 0; frame < predictions[k].times.size(); ++frame)
      frames[std::lround(ahead_of(predictions[k], frame) / interval)].push_back({k, frame});
  }
  const auto count = [&](const std::vector<FrameAhead>& of_horizon) {
    return std::ranges::count_if(
        of_horizon, [&](const FrameAhead& one) { return predictions[one.prediction].model.size() > 0; });
  };
  std::ptrdiff_t most = 0;
  for (const auto& [horizon, of_horizon] : frames) most = std::max(most, count(of_horizon));
  std::erase_if(frames, [&](const auto& of_horizon) { return 2 * count(of_horizon.second) < most; });
  thin_out(frames);
  return frames;
}

/// The last frame whose place was seen.
Eigen::Index last_seen(const SeenMotion& seen) {
  Eigen::Index last = seen.positions.rows() - 1;
  while (last > 0 && !seen.positions.row(last).allFinite()) --last;
  return last;
}

/// Of two predictors of one place, the second's part.
SaidForecast between(const SaidForecast& one, const SaidForecast& other, double part) {
  if (!one.mean.allFinite() || one.parts.empty()) return other;
  if (!other.mean.allFinite() || other.parts.empty()) return one;
  SaidForecast said{.predictor = one.predictor, .mean = (1.0 - part) * one.mean + part * other.mean};
  for (std::size_t c = 0; c < one.parts.size(); ++c) {
    const NormalMixture &a = one.parts[c], &b = other.parts[c];
    said.parts.push_back({(1.0 - part) * a.weights + part * b.weights,
                          (1.0 - part) * a.means + part * b.means,
                          (1.0 - part) * a.deviations + part * b.deviations});
  }
  return said;
}

}  // namespace

SeenMotion seen_of(const CapturePrediction& one, const Quantity& quantity) {
  SeenMotion seen{.times = one.seen.times, .positions = one.seen.positions(Eigen::all, quantity.columns)};
  if (one.seen.rates.size() > 0) seen.rates = one.seen.rates(Eigen::all, quantity.columns);
  if (quantity.components.level.size() == 2) seen.views = one.seen.views;
  seen.up = quantity.up;
  seen.net_weight = quantity.net_weight;
  return seen;
}

MotionForecasts::MotionForecasts(std::span<const Quantity> compared,
                                 std::span<const CapturePrediction> predictions,
                                 const PredictionOptions& prediction)
    : compared_(compared.begin(), compared.end()), prediction_(prediction), trained_(compared.size()) {
  const std::map<long, std::vector<FrameAhead>> frames = frames_by_horizon(predictions);
  for (std::size_t q = 0; q < compared_.size(); ++q) {
    if (compared_[q].is_attitude || compared_[q].period != 0.0 || frames.empty()) continue;
    trained_[q].resize(frames.size());
    parallel_for(frames.size(), [&](std::size_t h) {
      // Moments hold copies of what was seen: those of one horizon at a time.
      const std::vector<FrameAhead>& of_horizon =
          std::next(frames.begin(), static_cast<std::ptrdiff_t>(h))->second;
      std::vector<AskedMoment> moments;
      double sum = 0.0;
      for (const auto& [k, frame] : of_horizon) {
        moments.push_back(asked(predictions[k], compared_[q], frame, predictions[k].cluster));
        sum += ahead_of(predictions[k], frame);
      }
      trained_[q][h] = {.ahead = sum / static_cast<double>(of_horizon.size()),
                        .trained = TrainedForecasts::train(moments, compared_[q].components)};
    });
  }
}

std::vector<SaidForecast> MotionForecasts::say(std::size_t quantity, const CapturePrediction& one,
                                               Eigen::Index frame) const {
  const std::vector<Horizon>& horizons = trained_[quantity];
  if (horizons.empty()) return {};
  const double ahead = ahead_of(one, frame);
  const AskedMoment moment = asked(one, compared_[quantity], frame, -1);
  constexpr double kSame = 1e-6;
  const auto nearest =
      std::ranges::min_element(horizons, {}, [&](const Horizon& h) { return std::abs(h.ahead - ahead); });
  const auto far = std::ranges::find_if(horizons, [&](const Horizon& h) { return h.ahead > ahead; });
  const bool is_outside = far == horizons.begin() || far == horizons.end();
  if (is_outside || std::abs(nearest->ahead - ahead) < kSame * ahead) return nearest->trained.say(moment);
  const auto near = std::prev(far);
  const double part = (ahead - near->ahead) / (far->ahead - near->ahead);
  const SeenMotion& seen = moment.moment.seen;
  const Eigen::Index frame_of_last = last_seen(seen);
  const Eigen::RowVectorXd last = seen.positions.row(frame_of_last);
  const double unseen = seen.times[seen.times.size() - 1] - seen.times[frame_of_last];
  const auto velocity_to = [&](const Horizon& horizon) {
    const TrainingMoment& from = moment.moment;
    const Eigen::RowVectorXd there = horizon.trained.autoregression().predict(from.seen, from.known);
    return Eigen::RowVectorXd((there - last) / (unseen + horizon.ahead));
  };
  const Eigen::RowVectorXd place =
      last + (unseen + ahead) * ((1.0 - part) * velocity_to(*near) + part * velocity_to(*far));
  std::vector<SaidForecast> said = near->trained.say(moment, place);
  const std::vector<SaidForecast> farther = far->trained.say(moment, place);
  for (std::size_t p = 0; p < said.size(); ++p) said[p] = between(said[p], farther[p], part);
  return said;
}

std::vector<double> MotionForecasts::horizons(std::size_t quantity) const {
  std::vector<double> ahead;
  for (const Horizon& one : trained_[quantity]) ahead.push_back(one.ahead);
  return ahead;
}

std::vector<std::string> MotionForecasts::lacks(double reach) const {
  std::map<std::string, std::string> names;  // by what is said of them
  for (std::size_t q = 0; q < compared_.size(); ++q) {
    if (compared_[q].is_attitude || compared_[q].period != 0.0) continue;
    const auto reached = [&](bool (TrainedForecasts::*knows)() const) {
      double ahead = 0.0;
      for (const Horizon& one : trained_[q]) {
        if ((one.trained.*knows)()) ahead = one.ahead;
      }
      return ahead;
    };
    const double mixed = reached(&TrainedForecasts::is_mixed), banded = reached(&TrainedForecasts::has_band);
    std::string said;
    if (mixed == 0.0) {
      said = fmt::format(
          "says nothing: of no capture of the fit is there a forecast by a fit of others and what came after "
          "it; "
          "captures longer than the {:.4g} s that are seen were expected",
          prediction_.span);
    } else if (banded == 0.0) {
      said = "has no bands: of captures of the fit there are fewer than 3 forecasts";
    } else if (std::min(mixed, banded) < kReached * reach) {
      said = fmt::format(
          "has learned {:.4g} s ahead at most, and is asked {:.4g} s ahead: there its bands are those of "
          "nearer "
          "frames; captures of the fit that show as much after the {:.4g} s that are seen were expected",
          std::min(mixed, banded), reach, prediction_.span);
    }
    if (said.empty()) continue;
    std::string& of_these = names[said];
    of_these += (of_these.empty() ? "" : ", ") + compared_[q].name;
  }
  std::vector<std::string> sentences;
  for (const auto& [said, of_these] : names)
    sentences.push_back(fmt::format("the mixture of {} {}", of_these, said));
  return sentences;
}

std::string MotionForecasts::shares(std::size_t quantity) const {
  // The farthest of which anything was learned.
  const std::vector<Horizon>& horizons = trained_[quantity];
  const auto far = std::find_if(horizons.rbegin(), horizons.rend(),
                                [](const Horizon& one) { return one.trained.is_mixed(); });
  if (far == horizons.rend()) return {};
  std::string shares;
  for (const auto& [predictor, share] : far->trained.shares()) {
    constexpr double kShown = 0.005;
    if (share >= kShown) shares += fmt::format("{}{:.2f} {}", shares.empty() ? "" : ", ", share, predictor);
  }
  if (shares.empty()) return {};
  std::string views;
  if (!prediction_.views.empty() && compared_[quantity].components.level.size() == 2) {
    const bool sees = far->trained.autoregression().turning().sees_views();
    views = sees ? "; the autoregression looks at views" : "; the autoregression does not look at views";
  }
  const double ahead = far->ahead < kReached * prediction_.ahead ? far->ahead : prediction_.ahead;
  return fmt::format("the mixture of {}, {:.4g} s ahead: {}{}", compared_[quantity].name, ahead, shares,
                     views);
}

}  // namespace samara::identification
