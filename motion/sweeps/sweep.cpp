#include "samara/motion/sweeps/sweep.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/models/batch/watch_batch.h"
#include "samara/motion/sweeps/lyapunov_exponents.h"
#include "samara/motion/sweeps/sweep_checkpoint.h"
#include "samara/motion/sweeps/sweep_file.h"

namespace samara::motion {

namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Falls that are run together, between two looks at the checkpoint.
constexpr Eigen::Index kChunk = 1024;

FallStatus status_of(models::BatchStatus status) {
  switch (status) {
    case models::BatchStatus::done:
      return FallStatus::done;
    case models::BatchStatus::stopped:
      return FallStatus::landed;
    case models::BatchStatus::not_finite:
      return FallStatus::not_finite;
    case models::BatchStatus::too_many_steps:
      return FallStatus::too_many_steps;
    case models::BatchStatus::cancelled:
      return FallStatus::cancelled;
  }
  return FallStatus::not_finite;
}

/// Falls of some lanes: frames are gathered, and become features when a fall ends.
class Falls {
 public:
  Falls(const SweepPlan& plan, const models::ParametricModel& model, const Eigen::MatrixXd& lanes)
      : plan_(plan), model_(model), lanes_(lanes), states_(model.model().info()) {
    const auto count = static_cast<std::size_t>(lanes.rows());
    open_.resize(count);
    features.resize(count);
    exponents.setConstant(lanes.rows(), kUnknown);
    landing.setConstant(lanes.rows(), 3, kUnknown);
    // What watch_batch does with the end.
    frames_ = static_cast<Eigen::Index>(std::ceil(plan.until / plan.interval * (1.0 - 1e-12))) + 1;
    if (plan.keep_trajectories)
      trajectories.assign(count, Eigen::MatrixXd::Constant(frames_, model.state_count(), kUnknown));
  }

  /// @returns whether the fall goes on
  bool see(Eigen::Index n, double t, std::span<const double> state) {
    Open& fall = open_[static_cast<std::size_t>(n)];
    if (!fall.record) {
      fall.record = std::make_unique<RecordBuilder>(states_, static_cast<std::size_t>(frames_));
      fall.start = fall.last = states_.position(state);
      fall.last_time = t;
    }
    if (plan_.keep_trajectories) {
      trajectories[static_cast<std::size_t>(n)].row(static_cast<Eigen::Index>(fall.record->count())) =
          Eigen::Map<const Eigen::RowVectorXd>(state.data(), static_cast<Eigen::Index>(state.size()));
    }
    fall.record->add(t, state);
    const bool goes_on = !lands(n, t, state);
    if (!goes_on || t >= plan_.until * (1.0 - 1e-12)) finish(n);
    return goes_on;
  }

  std::vector<Features> features;
  Eigen::VectorXd exponents;
  Eigen::MatrixX3d landing;
  std::vector<Eigen::MatrixXd> trajectories;

 private:
  struct Open {
    std::unique_ptr<RecordBuilder> record;
    Eigen::Vector3d start, last;
    double last_time = 0.0;
  };

  bool lands(Eigen::Index n, double t, std::span<const double> state) {
    if (!plan_.height) return false;
    Open& fall = open_[static_cast<std::size_t>(n)];
    const Eigen::Vector3d here = states_.position(state);
    const double ground = fall.start.z() - *plan_.height;
    if (here.z() > ground) {
      fall.last = here;
      fall.last_time = t;
      return false;
    }
    const double share = (fall.last.z() - ground) / (fall.last.z() - here.z());
    const Eigen::Vector3d place = fall.last + share * (here - fall.last) - fall.start;
    landing.row(n) << place.x(), place.y(), fall.last_time + share * (t - fall.last_time);
    return true;
  }

  void finish(Eigen::Index n) {
    Open& fall = open_[static_cast<std::size_t>(n)];
    const Eigen::VectorXd q = lanes_.row(n);
    const std::vector<double> parameters = model_.parameters({q.data(), static_cast<std::size_t>(q.size())});
    const MotionRecord record = fall.record->record(MotionStates::body_length(model_.model(), parameters));
    fall.record.reset();
    FeatureOptions options;
    // A fall that landed early has settled at the same share of its time.
    const double time = record.times[record.frame_count() - 1];
    options.settle = plan_.settle * std::min(1.0, time / plan_.until);
    if (std::isfinite(exponents[n])) options.exponent = exponents[n];
    const double kept = static_cast<double>(record.frame_count()) * (1.0 - plan_.settle / plan_.until);
    if (kept < static_cast<double>(kFewestFrames) + 2.0) return;
    features[static_cast<std::size_t>(n)] = motion::features(record, options);
  }

  const SweepPlan& plan_;
  const models::ParametricModel& model_;
  const Eigen::MatrixXd& lanes_;
  MotionStates states_;
  std::vector<Open> open_;
  Eigen::Index frames_ = 0;
};

PatternLabel label_of(const Features& features, FallStatus status, const PatternThresholds& thresholds) {
  if (status == FallStatus::not_finite) return {Pattern::unresolved, 0.0, "the fall is not finite"};
  if (status == FallStatus::too_many_steps)
    return {Pattern::unresolved, 0.0, "the fall takes too many steps"};
  if (!features.knows(Feature::fall)) return {Pattern::unresolved, 0.0, "the fall is too short"};
  return label(features, thresholds);
}

/// Progress of a part as progress of the whole.
ProgressCallback within(const ProgressCallback& whole, double from, double to) {
  if (!whole) return {};
  return [&whole, from, to](const Progress& part) {
    return whole({"falls", from + (to - from) * part.fraction});
  };
}

/// The falls of some lanes. @returns false if they were cancelled; then nothing was appended
bool append_lanes(const SweepPlan& plan, const models::ParametricModel& model, const Eigen::MatrixXd& lanes,
                  Eigen::Index first, const ProgressCallback& progress, int threads, Sweep& sweep) {
  Falls falls(plan, model, lanes);
  const double share = plan.spread ? 0.7 : 0.0;  // of the time that the exponents take
  bool cancelled = false;
  const ProgressCallback counted = !progress ? ProgressCallback() : [&](const Progress& part) {
    cancelled = cancelled || !progress(part);
    return !cancelled;
  };
  if (plan.spread)
    falls.exponents = lyapunov_exponents(plan, lanes, first, threads, within(counted, 0.0, share));
  if (cancelled) return false;
  const models::WatchedBatch batch = watch_batch(
      model, lanes, [&](Eigen::Index n, double t, std::span<const double> x) { return falls.see(n, t, x); },
      {.step = plan.step,
       .interval = plan.interval,
       .end = plan.until,
       .threads = threads,
       .progress = within(counted, share, 1.0)});
  for (const models::BatchStatus status : batch.status) {
    if (status == models::BatchStatus::cancelled) return false;
  }
  const Eigen::Index before = sweep.fall_count();
  sweep.reached.conservativeResize(before + lanes.rows());
  sweep.landing.conservativeResize(before + lanes.rows(), Eigen::NoChange);
  sweep.reached.tail(lanes.rows()) = batch.reached;
  sweep.landing.bottomRows(lanes.rows()) = falls.landing;
  for (Eigen::Index n = 0; n < lanes.rows(); ++n) {
    const auto k = static_cast<std::size_t>(n);
    sweep.status.push_back(status_of(batch.status[k]));
    sweep.features.push_back(falls.features[k]);
    sweep.labels.push_back(label_of(falls.features[k], sweep.status.back(), plan.thresholds));
    if (plan.keep_trajectories) sweep.trajectories.push_back(std::move(falls.trajectories[k]));
  }
  return true;
}

/// What an earlier run of the same plan has left.
Sweep take_up(const SweepPlan& plan, const std::filesystem::path& checkpoint) {
  codebooks::check_checkpoint_path(checkpoint, kSweepCheckpoint);
  if (!codebooks::is_checkpoint(checkpoint)) return empty_sweep(plan);
  Sweep kept = load_sweep(checkpoint);
  if (kept.plan_text != plan.text)
    throw InputError(checkpoint.string(),
                     "the checkpoint belongs to another plan, expected one of this plan");
  const Sweep own = empty_sweep(plan);
  if (kept.generator != own.generator)
    throw InputError(checkpoint.string(),
                     fmt::format("the checkpoint is of {}, expected one of {}: others may fall otherwise",
                                 kept.generator, own.generator));
  if (kept.model_text != own.model_text)
    throw InputError(checkpoint.string(),
                     fmt::format("the checkpoint is of another model \"{}\", whose equations or "
                                 "parameters differ, expected one of this model",
                                 kept.model));
  return kept;
}

}  // namespace

std::string model_text(const models::ModelInfo& info) {
  std::string text = info.equations + "\n";
  for (const models::ParameterInfo& p : info.parameters) {
    const std::string value = p.default_value ? fmt::format("{}", *p.default_value) : "";
    text += fmt::format("{} [{}] {}\n", p.name, p.unit, p.derived.empty() ? value : p.derived);
  }
  for (const models::StateInfo& s : info.states)
    text += fmt::format("{}(0) [{}] {}\n", s.name, s.unit, s.default_initial);
  return text;
}

std::string to_string(FallStatus status) {
  switch (status) {
    case FallStatus::done:
      return "done";
    case FallStatus::landed:
      return "landed";
    case FallStatus::not_finite:
      return "not_finite";
    case FallStatus::too_many_steps:
      return "too_many_steps";
    case FallStatus::cancelled:
      return "cancelled";
    case FallStatus::inherited:
      return "inherited";
  }
  throw ArgumentError("no such status of a fall");
}

std::vector<int> Sweep::counts(Eigen::Index release) const {
  std::vector<int> all(kPatterns, 0);
  for (Eigen::Index n = 0; n < fall_count(); ++n) {
    if (release < 0 || release_of(n) == release)
      ++all[static_cast<std::size_t>(labels[static_cast<std::size_t>(n)].pattern)];
  }
  return all;
}

Eigen::Index Sweep::run_count() const {
  return fall_count() - std::ranges::count(status, FallStatus::inherited);
}

Sweep empty_sweep(const SweepPlan& plan) {
  Sweep sweep;
  sweep.model = plan.model->info().name;
  sweep.generator = fmt::format("samara {}", version());
  sweep.model_text = model_text(plan.model->info());
  sweep.plan_text = plan.text;
  const auto count = static_cast<Eigen::Index>(plan.axes.size());
  sweep.lower.resize(count);
  sweep.upper.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const SweepAxis& axis = plan.axes[static_cast<std::size_t>(k)];
    sweep.names.push_back(axis.name);
    sweep.units.push_back(axis.unit);
    if (plan.is_grid()) sweep.axes.push_back(axis.values);
    sweep.lower[k] = axis.lower;
    sweep.upper[k] = axis.upper;
  }
  sweep.points.resize(0, count);
  sweep.releases = plan.releases;
  sweep.thresholds = plan.thresholds;
  sweep.landing.resize(0, 3);
  if (plan.keep_trajectories) {
    const auto frames = static_cast<Eigen::Index>(std::ceil(plan.until / plan.interval * (1.0 - 1e-12))) + 1;
    sweep.times = plan.interval * Eigen::VectorXd::LinSpaced(frames, 0.0, static_cast<double>(frames - 1));
    for (const auto& state : plan.model->info().states) sweep.state_names.push_back(state.name);
  }
  return sweep;
}

bool append_falls(const SweepPlan& plan, const Eigen::MatrixXd& points, const SweepOptions& options,
                  Sweep& sweep) {
  if (points.rows() == 0) return true;
  const models::ParametricModel model = plan.parametric_model();
  const Eigen::MatrixXd lanes = plan.lane_points(points);
  // Its falls come after whole points.
  if (!append_lanes(plan, model, lanes, 0, options.progress, options.threads, sweep)) return false;
  sweep.points.conservativeResize(sweep.points.rows() + points.rows(), Eigen::NoChange);
  sweep.points.bottomRows(points.rows()) = points;
  sweep.round_of_point.resize(static_cast<std::size_t>(sweep.points.rows()), 0);
  return true;
}

SweepResult run_sweep(const SweepPlan& plan, const SweepOptions& options) {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point begin = Clock::now();
  const models::ParametricModel model = plan.parametric_model();
  const Eigen::MatrixXd points = plan.points();
  const Eigen::MatrixXd lanes = plan.lane_points(points);
  SweepResult result;
  result.sweep = take_up(plan, options.checkpoint);
  result.taken_up = result.sweep.fall_count();
  if (!result.sweep.rounds.empty()) {
    result.complete = true;
    result.falls_done = result.taken_up;
    result.message =
        fmt::format("{} falls, refined in {} rounds so far", result.taken_up, result.sweep.rounds.size() - 1);
    return result;
  }
  result.sweep.points = points;
  result.sweep.round_of_point.assign(static_cast<std::size_t>(points.rows()), 0);
  const auto keep =
      codebooks::told_once<>([&] { save_checkpoint(result.sweep, options.checkpoint); }, options.warning);
  Clock::time_point kept = begin;
  const double total = static_cast<double>(lanes.rows());
  bool goes_on = true;
  for (Eigen::Index first = result.taken_up; first < lanes.rows() && goes_on; first += kChunk) {
    const Eigen::Index count = std::min(kChunk, lanes.rows() - first);
    goes_on = append_lanes(plan, model, lanes.middleRows(first, count), first,
                           within(options.progress, static_cast<double>(first) / total,
                                  static_cast<double>(first + count) / total),
                           options.threads, result.sweep);
    const bool is_due = Clock::now() - kept > std::chrono::seconds(10);
    const bool is_last = first + count == lanes.rows();
    if (!options.checkpoint.empty() && !(goes_on && is_last) && (is_due || !goes_on)) {
      if (result.sweep.fall_count() > 0) keep();
      kept = Clock::now();
    }
  }
  result.falls_done = result.sweep.fall_count();
  result.complete = result.falls_done == lanes.rows();
  if (result.complete && !options.checkpoint.empty() && !options.keep_checkpoint) {
    std::error_code ignored;
    std::filesystem::remove(options.checkpoint, ignored);
  }
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  result.message = result.complete
                       ? fmt::format("all {} falls", result.falls_done)
                       : fmt::format("cancelled after {} of {} falls", result.falls_done, lanes.rows());
  return result;
}

}  // namespace samara::motion
