#include "samara/identification/following/follower.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/identification/following/forecast_component.h"
#include "samara/identification/following/smoother.h"
#include "samara/identification/following/start_search.h"

namespace samara::identification {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
/// Of standard errors: hypotheses that differ by less are one.
constexpr double kMerged = 0.3;
/// Hypotheses that are less likely than the best by this factor are dropped.
constexpr double kLeastWeight = 1e-4;
/// After so many outliers in a row the motion is lost, and a start is looked for again.
constexpr int kLostAfter = 6;

FollowedState state_of(const FollowedModel& model, const Hypothesis& hypothesis, double time) {
  return {.time = time,
          .weight = std::exp(hypothesis.log_weight),
          .states = hypothesis.point.head(model.states()),
          .coefficients = hypothesis.point.tail(model.coefficients()),
          .covariance = hypothesis.covariance};
}

}  // namespace

std::string to_string(FollowStatus status) {
  switch (status) {
    case FollowStatus::starting:
      return "starting";
    case FollowStatus::following:
      return "following";
    case FollowStatus::outlier:
      return "outlier";
    case FollowStatus::blind:
      return "blind";
    case FollowStatus::lost:
      return "lost";
  }
  return "";
}

struct Follower::Impl {
  Impl(std::shared_ptr<const models::Model> equations, const FollowOptions& options)
      : model(std::move(equations), options), filter(model), merge_error(model.errors()) {
    for (const SeenOutput& output : model.measured()) measured.push_back(output.name);
    if (model.attitude_is_measured()) {
      for (Eigen::Index part = 0; part < 4; ++part) {
        const auto state = static_cast<std::size_t>(*model.attitude() + part);
        measured.push_back(model.equations().model().info().states[state].name);
      }
    }
    frame.values.setConstant(std::ssize(model.measured()), kNothing);
  }

  void check(double next, std::span<const double> values) const {
    if (!std::isfinite(next) || next < 0.0)
      throw ArgumentError(
          fmt::format("the time of a frame is {} s; a finite time from 0 on was expected", next));
    if (next <= time) {
      throw ArgumentError(
          fmt::format("a frame at {} s follows one at {} s; a later one was expected", next, time));
    }
    if (values.size() != measured.size()) {
      throw ArgumentError(
          fmt::format("{} values were given for a frame; {} were expected", values.size(), measured.size()));
    }
    int missing = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (std::isinf(values[k]))
        throw ArgumentError(
            fmt::format("\"{}\" is infinite at {} s; a number, or NaN where it was not seen, was "
                        "expected",
                        measured[k], next));
      if (k >= model.measured().size() && std::isnan(values[k])) ++missing;
    }
    if (!model.attitude_is_measured()) return;
    const std::span<const double> attitude = values.last(4);
    const bool is_zero = std::ranges::all_of(attitude, [](double part) { return part == 0.0; });
    if (is_zero || (missing > 0 && missing < 4)) {
      throw ArgumentError(
          fmt::format("the attitude at {} s {}; four numbers, not all 0, or four times NaN was expected",
                      next, is_zero ? "has the length 0" : "lacks some of its four numbers"));
    }
  }

  void read_frame(double next, std::span<const double> values) {
    frame.time = next;
    frame.count = 0;
    for (Eigen::Index k = 0; k < frame.values.size(); ++k) {
      frame.values[k] = values[static_cast<std::size_t>(k)];
      if (!std::isnan(frame.values[k])) ++frame.count;
    }
    if (!model.attitude_is_measured()) return;
    for (Eigen::Index part = 0; part < 4; ++part)
      frame.attitude[part] = values[values.size() - 4 + static_cast<std::size_t>(part)];
    if (!frame.attitude.hasNaN()) frame.count += 3;
  }

  double state_time() const { return time - filter.lead(); }

  /// s, the middle of the intervals between the first frames.
  double frame_interval() const {
    std::vector<double> intervals;
    for (std::size_t k = 1; k < first_frames.size(); ++k)
      intervals.push_back(first_frames[k].time - first_frames[k - 1].time);
    if (intervals.empty()) return 0.0;
    std::ranges::nth_element(intervals, intervals.begin() + std::ssize(intervals) / 2);
    return intervals[intervals.size() / 2];
  }

  void start() {
    if (filter.interval() == 0.0) filter.set_interval(frame_interval());
    hypotheses = find_starts(model, first_frames, filter, been);
    const double lead = filter.lead();
    std::erase_if(hypotheses, [&](Hypothesis& hypothesis) {
      if (model.options().remember) hypothesis.records = start_records(model, hypothesis, first_frames, lead);
      const double begin = first_frames.front().time - lead;
      const double duration = state_time() - begin;
      if (duration > 0.0 && !filter.predict(hypothesis, begin, duration)) return true;
      if (model.options().remember) end_start_records(hypothesis);
      return !hypothesis.covariance.allFinite();
    });
    if (hypotheses.empty()) {  // perhaps the first of these frames is wrong
      first_frames.erase(first_frames.begin());
      return;
    }
    first_frames.clear();
    outliers_in_row = 0;
    settle_weights();
  }

  /// Weights that sum to 1, the most likely first; the unlikely dropped.
  void settle_weights() {
    double highest = -std::numeric_limits<double>::infinity();
    for (const Hypothesis& hypothesis : hypotheses) highest = std::max(highest, hypothesis.log_weight);
    double sum = 0.0;
    const double least = highest + std::log(kLeastWeight);
    std::erase_if(hypotheses, [&](const Hypothesis& h) { return !(h.log_weight >= least); });
    for (const Hypothesis& hypothesis : hypotheses) sum += std::exp(hypothesis.log_weight - highest);
    for (Hypothesis& hypothesis : hypotheses) hypothesis.log_weight -= highest + std::log(sum);
    // Few, and mostly in order already: sorted in place, which allocates nothing.
    for (std::size_t k = 1; k < hypotheses.size(); ++k) {
      for (std::size_t n = k; n > 0 && hypotheses[n].log_weight > hypotheses[n - 1].log_weight; --n)
        std::swap(hypotheses[n], hypotheses[n - 1]);
    }
  }

  void merge() {
    for (std::size_t a = 0; a < hypotheses.size(); ++a) {
      for (std::size_t b = hypotheses.size(); b-- > a + 1;) {
        model.minus(hypotheses[b].point, hypotheses[a].point, merge_error);
        const auto deviations = hypotheses[a].covariance.diagonal().array().max(0.0).sqrt();
        if (!(merge_error.array().abs() <= kMerged * deviations + 1e-12).all()) continue;
        const double both = std::exp(hypotheses[a].log_weight) + std::exp(hypotheses[b].log_weight);
        hypotheses[a].log_weight = std::log(both);
        for (std::size_t n = b; n + 1 < hypotheses.size(); ++n) std::swap(hypotheses[n], hypotheses[n + 1]);
        hypotheses.pop_back();
      }
    }
  }

  /// All hypotheses to the frame, and through it.
  FollowedFrame take_in(double before) {
    FollowedFrame result{.status = frame.count > 0 ? FollowStatus::following : FollowStatus::blind,
                         .values = frame.count};
    const double lead = filter.lead();
    double density = 0.0, highest = -std::numeric_limits<double>::infinity();
    bool most_likely = true;
    for (Hypothesis& hypothesis : hypotheses) {
      FrameRecord record;
      Eigen::MatrixXd* transition = nullptr;
      if (model.options().remember) {
        record.transition.resize(model.errors(), model.errors());
        transition = &record.transition;
      }
      bool is_finite = filter.predict(hypothesis, before - lead, frame.time - before, transition);
      if (model.options().remember) {
        record.time = frame.time - lead;
        record.expected = hypothesis.point;
        record.expected_covariance = hypothesis.covariance;
      }
      if (is_finite && frame.count > 0) {
        const HypothesisFilter::Update update = filter.update(hypothesis, frame.time - lead, frame);
        is_finite = update.is_finite && hypothesis.covariance.allFinite();
        if (is_finite) {
          hypothesis.log_weight += update.log_likelihood;
          if (most_likely) {
            result.innovation_squared = update.innovation_squared;
            if (update.is_outlier) result.status = FollowStatus::outlier;
          }
          most_likely = false;
        }
      }
      if (!is_finite) {
        hypothesis.log_weight = -std::numeric_limits<double>::infinity();
        continue;
      }
      highest = std::max(highest, hypothesis.log_weight);
      if (model.options().remember) {
        record.point = hypothesis.point;
        record.covariance = hypothesis.covariance;
        hypothesis.records.push_back(std::move(record));
      }
    }
    for (const Hypothesis& hypothesis : hypotheses) density += std::exp(hypothesis.log_weight - highest);
    if (!std::isfinite(highest)) {
      keep_past();
      hypotheses.clear();
    } else {
      if (frame.count > 0) result.log_likelihood = highest + std::log(density);
      settle_weights();
      merge();
    }
    outliers_in_row = result.status == FollowStatus::outlier     ? outliers_in_row + 1
                      : result.status == FollowStatus::following ? 0
                                                                 : outliers_in_row;
    return result;
  }

  FollowedFrame add(double next, std::span<const double> values) {
    check(next, values);
    const double before = time;
    time = next;
    read_frame(next, values);
    FollowedFrame result;
    if (hypotheses.empty()) {
      result.status = frame.count > 0 ? FollowStatus::starting : FollowStatus::blind;
      result.values = frame.count;
      if (frame.count > 0) first_frames.push_back(frame);
      if (std::ssize(first_frames) >= model.options().start_frames && frame.count > 0) start();
      if (!hypotheses.empty()) result.status = FollowStatus::following;
    } else {
      result = take_in(before);
      if (hypotheses.empty() || outliers_in_row >= kLostAfter) {
        result.status = FollowStatus::lost;
        keep_past();
        hypotheses.clear();
        first_frames.clear();
        outliers_in_row = 0;
      }
    }
    if (!hypotheses.empty()) been.add(hypotheses.front().point);
    result.hypotheses = static_cast<int>(hypotheses.size());
    return result;
  }

  /// Before a motion is let go.
  void keep_past() {
    if (!model.options().remember || hypotheses.empty()) return;
    for (FollowedState& state : smooth(model, hypotheses.front().records))
      finished.push_back(std::move(state));
  }

  FollowedModel model;
  HypothesisFilter filter;
  std::vector<std::string> measured;
  std::vector<SeenFrame> first_frames;  ///< with something seen, while a start is looked for
  SeenFrame frame;                      ///< the last one
  std::vector<Hypothesis> hypotheses;
  StateRanges been;
  Eigen::VectorXd merge_error;
  double time = -1.0;
  int outliers_in_row = 0;
  std::vector<FollowedState> finished;  ///< smoothed, before the motion was lost
};

Follower::Follower(std::shared_ptr<const models::Model> model, const FollowOptions& options)
    : impl_(std::make_unique<Impl>(std::move(model), options)) {}
Follower::~Follower() = default;
Follower::Follower(Follower&&) noexcept = default;
Follower& Follower::operator=(Follower&&) noexcept = default;

const std::vector<std::string>& Follower::measured() const {
  return impl_->measured;
}

FollowedFrame Follower::add(double time, std::span<const double> values) {
  return impl_->add(time, values);
}

bool Follower::is_following() const {
  return !impl_->hypotheses.empty();
}

double Follower::time() const {
  return impl_->time;
}

FollowedState Follower::state() const {
  if (!is_following()) throw ArgumentError("the state of a motion was asked for before its start was found");
  return state_of(impl_->model, impl_->hypotheses.front(), impl_->state_time());
}

std::vector<FollowedState> Follower::states() const {
  std::vector<FollowedState> result;
  for (const Hypothesis& hypothesis : impl_->hypotheses)
    result.push_back(state_of(impl_->model, hypothesis, impl_->state_time()));
  return result;
}

const std::vector<std::string>& Follower::error_names() const {
  return impl_->model.error_names();
}

Eigen::VectorXd Follower::deviations(const FollowedState& state) const {
  const FollowedModel& model = impl_->model;
  Eigen::VectorXd point(model.size());
  point << state.states, state.coefficients;
  Eigen::MatrixXd by_errors(model.size(), model.errors());
  model.times_plus(Eigen::MatrixXd::Identity(model.size(), model.size()), point, by_errors);
  return (by_errors * state.covariance).cwiseProduct(by_errors).rowwise().sum().array().max(0.0).sqrt();
}

Forecast Follower::forecast(std::span<const double> times, const std::vector<std::string>& outputs) const {
  Impl& run = *impl_;
  Forecast result{.times = Eigen::Map<const Eigen::VectorXd>(times.data(), std::ssize(times))};
  std::vector<SeenOutput> seen;
  if (outputs.empty()) seen = run.model.measured();
  for (const std::string& name : outputs) {
    const auto measured = std::ranges::find(run.model.measured(), name, &SeenOutput::name);
    seen.push_back(measured != run.model.measured().end() ? *measured : run.model.output(name));
  }
  for (const SeenOutput& output : seen) result.outputs.push_back(output.name);
  double last = run.time;
  for (const double time : times) {
    if (!std::isfinite(time) || time < last) {
      throw ArgumentError(fmt::format(
          "a forecast for {} s follows {} s; a finite time, not earlier, was expected", time, last));
    }
    last = time;
  }
  for (const Hypothesis& now : run.hypotheses)
    result.components.push_back(
        forecast_component(run.model, run.filter, now, run.state_time(), times, seen));
  return result;
}

std::vector<FollowedState> Follower::smoothed() const {
  if (!impl_->model.options().remember)
    throw ArgumentError(
        "a motion that was not remembered was to be smoothed; FollowOptions::remember was expected");
  std::vector<FollowedState> result = impl_->finished;
  if (impl_->hypotheses.empty()) return result;
  for (FollowedState& state : smooth(impl_->model, impl_->hypotheses.front().records))
    result.push_back(std::move(state));
  return result;
}

}  // namespace samara::identification
