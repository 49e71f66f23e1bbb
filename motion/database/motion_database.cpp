#include "samara/motion/database/motion_database.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/batch/watch_batch.h"
#include "samara/models/laws/registry.h"

namespace samara::motion {

namespace {

bool is_initial_value(const std::string& name) {
  return name.size() > 3 && name.ends_with("(0)");
}

/// What the falls of a sweep have in common, and which of its coordinates are coefficients.
struct Source {
  SweepPlan plan;
  models::ParametricModel model;
  std::vector<Eigen::Index> columns;  ///< of points, per coefficient
  std::vector<Eigen::Index> falls;    ///< those that were run
  Eigen::MatrixXd lanes;              ///< of these

  std::vector<double> parameters(Eigen::Index lane) const {
    const Eigen::VectorXd q = lanes.row(lane);
    return model.parameters({q.data(), static_cast<std::size_t>(q.size())});
  }
};

Source source_of(const Sweep& sweep) {
  SweepPlan plan = parse_sweep_plan(sweep.plan_text, "plan of the sweep");
  Source source = {plan, plan.parametric_model(), {}, {}, {}};
  const std::vector<std::string>& coefficients = plan.model->info().affine_in;
  for (std::size_t k = 0; k < sweep.names.size(); ++k) {
    const std::string& name = sweep.names[k];
    if (is_initial_value(name)) continue;
    if (std::ranges::find(coefficients, name) == coefficients.end()) {
      throw ArgumentError(
          fmt::format("the sweep changes {}, which is no coefficient of {}: a motion cannot go on as that of "
                      "another body; "
                      "coefficients are {}",
                      name, sweep.model, join(coefficients)));
    }
    source.columns.push_back(static_cast<Eigen::Index>(k));
  }
  for (Eigen::Index n = 0; n < sweep.fall_count(); ++n) {
    const FallStatus status = sweep.status[static_cast<std::size_t>(n)];
    if (status == FallStatus::done || status == FallStatus::landed) source.falls.push_back(n);
  }
  source.lanes = plan.lane_points(sweep.points)(source.falls, Eigen::all);
  return source;
}

/// What all lanes have: one coefficient of a disc may differ along and across it.
BodySymmetry common_symmetry(const Source& source) {
  BodySymmetry least = BodySymmetry::disc;
  for (Eigen::Index n = 0; n < source.lanes.rows(); ++n)
    least = std::min(least, MovingStates::of(*source.plan.model, source.parameters(n)).symmetry());
  return least;
}

/// Segments of one run, as they are found.
struct OpenRun {
  std::vector<MotionSegment> segments;
  std::vector<double> starts, ends, frames;
  std::vector<double> last_event;  // its state; empty before the first
};

/// Watches runs and cuts them at their events.
class Cutter {
 public:
  Cutter(const Sweep& sweep, const Source& source, const MotionDatabase& database, double step,
         long steps_per_frame)
      : sweep_(sweep),
        source_(source),
        database_(database),
        moving_(database.moving_states()),
        step_(step),
        steps_per_frame_(steps_per_frame),
        finders_(source.falls.size(), EventFinder(moving_, database.events)),
        runs_(source.falls.size()) {}

  bool see(Eigen::Index n, double t, std::span<const double> state) {
    const auto k = static_cast<std::size_t>(n);
    OpenRun& run = runs_[k];
    if (source_.plan.keep_trajectories && std::lround(t / step_) % steps_per_frame_ == 0)
      run.frames.insert(run.frames.end(), state.begin(), state.end());
    EventFinder& finder = finders_[k];
    if (finder.see(t, state)) add(run, finder, n);
    return t < sweep_.reached[source_.falls[k]] * (1.0 - 1e-9);
  }

  std::vector<OpenRun>& runs() { return runs_; }

 private:
  void add(OpenRun& run, const EventFinder& finder, Eigen::Index n) {
    const Event& event = finder.event();
    const double frame_time = step_ * static_cast<double>(steps_per_frame_);
    const auto frame_of = [&](double t) { return static_cast<Eigen::Index>(std::floor(t / frame_time)); };
    if (!event.is_first) {
      MotionSegment segment;
      segment.run = n;
      segment.begin = event.t - event.duration;
      segment.duration = event.duration;
      segment.first = frame_of(segment.begin);
      segment.last = frame_of(event.t);
      segment.kind = event.kind;
      segment.displacement = event.displacement;
      segment.is_steady = event.is_steady;
      if (!moving_.is_planar()) {
        const Eigen::Vector3d v = moving_.at(run.last_event).velocity;
        const double speed = std::hypot(v.x(), v.y());
        const double c = speed > 0.0 ? v.x() / speed : 1.0, s = speed > 0.0 ? v.y() / speed : 0.0;
        const Eigen::Vector3d& d = event.displacement;
        segment.displacement = {c * d.x() + s * d.y(), c * d.y() - s * d.x(), d.z()};
      }
      run.segments.push_back(segment);
      run.starts.insert(run.starts.end(), run.last_event.begin(), run.last_event.end());
      run.ends.insert(run.ends.end(), finder.state().begin(), finder.state().end());
    }
    run.last_event.assign(finder.state().begin(), finder.state().end());
  }

  const Sweep& sweep_;
  const Source& source_;
  const MotionDatabase& database_;
  MovingStates moving_;
  double step_;
  long steps_per_frame_;
  std::vector<EventFinder> finders_;
  std::vector<OpenRun> runs_;
};

void require_done(const models::WatchedBatch& batch) {
  if (std::ranges::find(batch.status, models::BatchStatus::cancelled) != batch.status.end())
    throw NoResultError("cancelled before the motions were cut into segments");
}

/// Of the settled parts of all falls, down to where they landed.
double mean_square_speed(const Sweep& sweep, const Source& source, const MotionDatabase& database,
                         const DatabaseOptions& options) {
  const MovingStates moving = database.moving_states();
  const auto count = source.lanes.rows();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(count), counts = Eigen::VectorXd::Zero(count);
  const models::WatchedBatch batch =
      watch_batch(source.model, source.lanes,
                  [&](Eigen::Index n, double t, std::span<const double> state) {
                    const auto k = static_cast<std::size_t>(n);
                    const double end = sweep.reached[source.falls[k]];
                    if (t >= database.runs[k].settle && t <= end) {
                      sums[n] += moving.at(state).velocity.squaredNorm();
                      counts[n] += 1.0;
                    }
                    return t < end;
                  },
                  {.step = source.plan.step,
                   .interval = source.plan.interval,
                   .end = source.plan.until,
                   .threads = options.threads,
                   .progress = options.progress});
  require_done(batch);
  double square = 0.0, frames = 0.0;
  for (Eigen::Index n = 0; n < count; ++n) {
    if (!std::isfinite(sums[n])) continue;
    square += sums[n];
    frames += counts[n];
  }
  if (!(frames > 0.0))
    throw ArgumentError("no fall of the sweep has a frame after its settle time, of which speeds are told");
  return square / frames;
}

MotionDatabase without_segments(const Sweep& sweep, const Source& source) {
  MotionDatabase database;
  database.model = sweep.model;
  for (const auto& [name, value] : source.plan.fixed) {
    if (!is_initial_value(name)) database.fixed[name] = value;
  }
  database.plan_text = sweep.plan_text;
  for (const auto& state : source.plan.model->info().states) database.state_names.push_back(state.name);
  const auto count = static_cast<Eigen::Index>(source.columns.size());
  database.lower.resize(count);
  database.upper.resize(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const Eigen::Index column = source.columns[static_cast<std::size_t>(k)];
    database.coefficient_names.push_back(sweep.names[static_cast<std::size_t>(column)]);
    database.coefficient_units.push_back(sweep.units[static_cast<std::size_t>(column)]);
    database.lower[k] = sweep.lower[column];
    database.upper[k] = sweep.upper[column];
  }
  for (const Eigen::Index fall : source.falls) {
    MotionRun run;
    run.fall = fall;
    run.coefficients = sweep.points.row(sweep.point_of(fall))(source.columns);
    run.pattern = sweep.labels[static_cast<std::size_t>(fall)].pattern;
    // A fall that landed early has settled at the same share of its time.
    run.settle = source.plan.settle * std::min(1.0, sweep.reached[fall] / source.plan.until);
    database.runs.push_back(std::move(run));
  }
  const double ratio = std::ceil(source.plan.interval / source.plan.step * (1.0 - 1e-12));
  database.step = source.plan.interval / ratio;
  database.frame_interval = source.plan.interval;
  database.settle = source.plan.settle;
  return database;
}

void gather(std::vector<OpenRun>& runs, MotionDatabase& database) {
  const auto states = static_cast<Eigen::Index>(database.state_names.size());
  std::vector<double> starts, ends, frames;
  for (OpenRun& run : runs) {
    database.run_first.push_back(static_cast<Eigen::Index>(frames.size()) / states);
    database.segments.insert(database.segments.end(), run.segments.begin(), run.segments.end());
    starts.insert(starts.end(), run.starts.begin(), run.starts.end());
    ends.insert(ends.end(), run.ends.begin(), run.ends.end());
    frames.insert(frames.end(), run.frames.begin(), run.frames.end());
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto matrix = [&](const std::vector<double>& values) -> Eigen::MatrixXd {
    return Eigen::Map<const Rows>(values.data(), static_cast<Eigen::Index>(values.size()) / states, states);
  };
  database.starts = matrix(starts);
  database.ends = matrix(ends);
  database.frames = matrix(frames);
}

}  // namespace

Eigen::Index MotionDatabase::next_of(Eigen::Index segment) const {
  const auto next = static_cast<std::size_t>(segment + 1);
  if (next >= segments.size() || segments[next].run != segments[next - 1].run) return -1;
  return segment + 1;
}

MovingStates MotionDatabase::moving_states() const {
  return {models::find_model(model)->info(), symmetry};
}

PatternThresholds MotionDatabase::thresholds() const {
  if (plan_text.empty()) return {};
  return parse_sweep_plan(plan_text, "the plan of the database").thresholds;
}

std::vector<std::vector<int>> MotionDatabase::kind_sequences() const {
  std::vector<std::vector<int>> sequences(runs.size());
  std::vector<int> stretch;
  for (std::size_t n = 0; n < segments.size(); ++n) {
    const MotionSegment& segment = segments[n];
    const double settled = runs[static_cast<std::size_t>(segment.run)].settle;
    const bool counts = segment.begin >= settled && !segment.is_steady;
    if (counts) stretch.push_back(static_cast<int>(segment.kind));
    const bool is_last = !counts || n + 1 == segments.size() || segments[n + 1].run != segment.run;
    if (!is_last) continue;
    std::vector<int>& longest = sequences[static_cast<std::size_t>(segment.run)];
    if (stretch.size() > longest.size()) longest = stretch;
    stretch.clear();
  }
  return sequences;
}

models::ParametricModel MotionDatabase::parametric_model() const {
  return {models::find_model(model), fixed, coefficient_names};
}

MotionDatabase build_database(const Sweep& sweep, const DatabaseOptions& options) {
  const Source source = source_of(sweep);
  MotionDatabase database = without_segments(sweep, source);
  if (source.falls.empty()) throw ArgumentError("no fall of the sweep was run to its end: it has no motions");
  database.symmetry = common_symmetry(source);
  database.body_length = MotionStates::body_length(*source.plan.model, source.parameters(0));
  const MovingStates moving = database.moving_states();
  database.events = event_options(mean_square_speed(sweep, source, database, options), database.body_length);
  Cutter cutter(sweep, source, database, database.step, std::lround(database.frame_interval / database.step));
  require_done(watch_batch(
      source.model, source.lanes,
      [&](Eigen::Index n, double t, std::span<const double> state) { return cutter.see(n, t, state); },
      {.step = source.plan.step,
       .interval = database.step,
       .end = source.plan.until,
       .threads = options.threads,
       .progress = options.progress}));
  gather(cutter.runs(), database);
  if (database.segment_count() < 2)
    throw ArgumentError(
        fmt::format("the falls of the sweep have {} segments between events, expected two or more",
                    database.segment_count()));
  if (std::ranges::all_of(database.segments, &MotionSegment::is_steady))
    throw ArgumentError("all falls of the sweep are steady: there are no events to cut them at");
  Eigen::MatrixXd reduced(database.segment_count(), moving.reduced_size());
  Eigen::VectorXd state, one(moving.reduced_size());
  for (Eigen::Index n = 0; n < reduced.rows(); ++n) {
    state = database.starts.row(n);
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())},
                  {one.data(), static_cast<std::size_t>(one.size())});
    reduced.row(n) = one;
  }
  database.metric_weights = StateMetric::fitted(moving, reduced).weights();
  return database;
}

void require_same_body(const MotionDatabase& database, const models::ParametricModel& model) {
  const std::string& name = model.model().info().name;
  if (name != database.model)
    throw ArgumentError(
        fmt::format("the database is of \"{}\", expected one of \"{}\"", database.model, name));
  for (const auto& [parameter, value] : database.fixed) {
    const auto given = model.fixed().find(parameter);
    const double other = given == model.fixed().end() ? std::nan("") : given->second;
    if (!(std::abs(other - value) <= 1e-9 * std::abs(value))) {
      throw ArgumentError(fmt::format("the motions of the database have {} = {}, the body has {}", parameter,
                                      value,
                                      given == model.fixed().end() ? "none" : fmt::format("{}", other)));
    }
  }
}

KindChain kind_chain(const MotionDatabase& database) {
  const std::vector<std::vector<int>> sequences = database.kind_sequences();
  constexpr int kKinds = static_cast<int>(kEventKinds);
  OrderChoice choice;
  if (std::ranges::count_if(sequences, [](const auto& run) { return std::ssize(run) > kMostKindOrder; }) >= 2)
    choice = select_order(sequences, kKinds, kMostKindOrder);
  return {MarkovChain::fitted(sequences, kKinds, choice.order), choice};
}

}  // namespace samara::motion
