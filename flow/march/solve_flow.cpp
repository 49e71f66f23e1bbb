#include "samara/flow/march/solve_flow.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/streams.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/flow/march/flow_checkpoint.h"
#include "samara/flow/march/flow_run.h"

namespace samara::flow {

namespace {

constexpr double kSteady = 1e-4;     // of l/U^2 du/dt
constexpr double kDragKnown = 0.01;  // half the 95 % interval over the mean
constexpr int kStepsBetweenChecks = 20;
constexpr int kBoxMargin = 3;  // cells
constexpr auto kBetweenCheckpoints = std::chrono::seconds(60);

FlowSetup setup_of(const FlowCase& flow) {
  FlowSetup setup{.grid = grid_of(flow), .borders = {}};
  const std::array<double, 2> stream = stream_turbulence(flow.intensity, 1.0, 1.0);
  Border& inflow = setup.borders.side[0];
  inflow.kind = BorderKind::inflow;
  inflow.velocity = {flow.stream, 0.0, 0.0};
  inflow.k = stream[0];
  inflow.epsilon = stream[1];
  setup.borders.side[1].kind = BorderKind::outflow;
  setup.body.emplace(flow.shape, Eigen::Vector3d::Zero(), flow.angle_of_attack);
  if (flow.motion) {
    setup.path = [path = flow.motion->path, angle = flow.angle_of_attack](double t) {
      BodyPose pose = path(t);
      pose.angle += angle;
      return pose;
    };
  }
  setup.viscosity = 1.0 / flow.reynolds;
  setup.scheme = flow.central ? AdvectionScheme::central : AdvectionScheme::van_leer;
  setup.turbulence = flow.turbulence;
  return setup;
}

/// The stream, with a kick across it behind a body that is held.
void start(FlowRun& run, std::uint64_t seed) {
  Stream random(seed, 0);
  const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
  const double offset = 0.5 * (random.uniform() - 0.5);
  const Border& inflow = run.march.setup().borders.side[0];
  run.march.set_velocity([&](const Eigen::Vector3d& x) {
    const bool kicked = !run.march.moves() && x.x() > 0.75 && x.x() < 2.25 && std::abs(x.y() - offset) < 0.75;
    return Eigen::Vector3d(inflow.velocity.x(), kicked ? 0.2 * side : 0.0, 0.0);
  });
  run.march.set_turbulence(inflow.k, inflow.epsilon);
}

/// One step, its loads, and what ends with it. At FlowEnd::time the last one ends at max_time.
void take_step(FlowRun& run, const FlowOptions& options) {
  // So that no last step is hardly longer than its rounding; of a cell no more than half flows out in it.
  constexpr double kStretched = 1.1;
  const double allowed = run.march.allowed_step(), left = options.max_time - run.march.state().time;
  const bool is_last = options.end == FlowEnd::time && left <= kStretched * allowed;
  const StepReport report = run.march.advance(is_last ? left : allowed);
  if (is_last) run.march.state().time = options.max_time;  // which the sum may miss by rounding
  run.finite = report.finite;
  if (!report.pressure.converged) ++run.unconverged;
  if (run.march.turbulence() != nullptr) run.not_positive += run.march.turbulence()->not_positive();
  const BodyLoads loads = run.march.loads();
  LoadRecord record{run.march.state().time, report.step, 2.0 * loads.force.x(), 2.0 * loads.force.y(),
                    2.0 * loads.moment};
  run.finite = run.finite && std::isfinite(record.drag) && std::isfinite(record.lift);
  run.history.push_back(record);
  run.largest_force = std::max(run.largest_force, loads.force.norm());
  if (run.march.moves()) return;  // its periods are those of its motion
  if (run.averaging) run.mean.fields.add(run.march, report.step);
  if (const std::optional<PeriodMeans> period = run.counter.add(record)) run.add_period(*period, kDragKnown);
}

/// Largest change of the velocity and of k per time in the last step; k by the change of its field since `before`.
double change_rate(const FlowRun& run, const Field& k_before) {
  const FlowState& state = run.march.state();
  double largest = 0.0;
  for (int d = 0; d < run.march.grid().dimensions; ++d) {
    const auto at = static_cast<std::size_t>(d);
    for (std::size_t c = 0; c < state.u[at].size(); ++c)
      largest = std::max(largest, std::abs(state.u[at][c] - state.u_before[at][c]));
  }
  if (run.march.turbulence() != nullptr) {
    for (std::size_t c = 0; c < k_before.size(); ++c)
      largest = std::max(largest, std::abs(run.march.turbulence()->k[c] - k_before[c]));
  }
  return largest / state.last_step;
}

double disagreement(const FlowRun& run) {
  const Eigen::Vector3d surface = run.march.loads().force;
  // The force of a body that moves to and fro passes through 0.
  const double scale = run.march.moves() ? run.largest_force : surface.norm();
  return (run.march.force_by_box(kBoxMargin) - surface).norm() / std::max(scale, 1e-6);
}

/// What was not reached by max_time, in words.
std::string unreached(FlowRun& run, const FlowOptions& options) {
  if (options.end == FlowEnd::steady && run.march.state().steps < kStepsBetweenChecks)
    return fmt::format(
        "max_time, {:.4g} l/U, was reached after {} steps, and whether the flow still changes is looked at "
        "after {}",
        options.max_time, run.march.state().steps, kStepsBetweenChecks);
  if (options.end == FlowEnd::steady)
    return fmt::format("the flow still changes by {:.2g} per l/U at max_time, {:.4g} l/U", run.change,
                       options.max_time);
  const FlowMean& mean = run.last_mean();
  const char* const fields = mean.fields.time() > 0.0 ? "" : "; the fields are those of one instant";
  if (mean.periods.size() < 2)
    return fmt::format(
        "the drag has no mean of known error at max_time, {:.4g} l/U: {} whole periods were "
        "averaged, expected at least 5{}",
        options.max_time, mean.periods.size(), fields);
  const MeanWithError drag = mean_drag(mean.periods);
  return fmt::format(
      "the mean drag is known to {:.2g} % from {} periods at max_time, {:.4g} l/U, expected {:.2g} % from at "
      "least 5 that do not drift",
      100.0 * drag.half_width / std::abs(drag.value), mean.periods.size(), options.max_time,
      100.0 * kDragKnown);
}

void finish(FlowRun& run, FlowStatus status, std::string message, FlowResult& result) {
  result.status = status;
  result.message = std::move(message);
  result.time = run.march.state().time;
  result.steps = run.march.state().steps;
}

/// The first cell whose values cannot be, in words.
std::string bad_place(const FlowMarch& march) {
  const MacGrid& grid = march.grid();
  const KEpsilon* const turbulence = march.turbulence();
  for (int k = 0; k < grid.cells[2]; ++k) {
    for (int j = 0; j < grid.cells[1]; ++j) {
      for (int i = 0; i < grid.cells[0]; ++i) {
        const auto c = static_cast<std::size_t>(grid.at(i, j, k));
        if (march.openness().inverse_cell[c] == 0.0) continue;
        bool good = std::isfinite(march.state().p[c]);
        for (int d = 0; d < grid.dimensions; ++d)
          good = good && std::isfinite(march.state().u[static_cast<std::size_t>(d)][c]);
        if (turbulence != nullptr) good = good && turbulence->k[c] > 0.0 && turbulence->epsilon[c] > 0.0;
        if (!good) return fmt::format("first in cell ({}, {}, {})", i, j, k);
      }
    }
  }
  return "in no cell but in the loads";
}

/// Steps until one of the ends of FlowStatus.
/// @param keep writes the checkpoint; empty: there is none
void march_to_end(FlowRun& run, const FlowOptions& options, const std::function<void()>& keep,
                  FlowResult& result) {
  auto last_checkpoint = std::chrono::steady_clock::now();
  Field k_before;
  while (true) {
    const FlowState& state = run.march.state();
    if (state.time >= options.max_time && options.end == FlowEnd::time)
      return finish(run, FlowStatus::ended, fmt::format("{:.4g} l/U were asked for", options.max_time),
                    result);
    if (state.time >= options.max_time)
      return finish(run, FlowStatus::max_time, unreached(run, options), result);
    const bool checks = (state.steps + 1) % kStepsBetweenChecks == 0;
    if (checks && run.march.turbulence() != nullptr) k_before = run.march.turbulence()->k;
    take_step(run, options);
    if (!run.finite)
      return finish(
          run, FlowStatus::diverged,
          fmt::format("a value is not finite, or k or epsilon not positive, at {:.4g} l/U, step {}, {}",
                      state.time, state.steps, bad_place(run.march)),
          result);
    if (checks) {
      run.change = change_rate(run, k_before);
      run.worst_disagreement = std::max(run.worst_disagreement, disagreement(run));
      if (run.change < kSteady && options.end != FlowEnd::time)
        return finish(run, FlowStatus::steady, fmt::format("nothing changes after {:.4g} l/U", state.time),
                      result);
    }
    if (options.end == FlowEnd::mean && is_known(run.mean.periods, kDragKnown))
      return finish(
          run, FlowStatus::averaged,
          fmt::format("mean over {} periods, {:.4g} l/U", run.mean.periods.size(), run.mean.fields.time()),
          result);
    const bool goes_on =
        !options.progress || options.progress({run.averaging                  ? "averaging"
                                               : options.end == FlowEnd::time ? "marching"
                                                                              : "developing",
                                               std::min(1.0, state.time / options.max_time)});
    if (!goes_on && state.time < options.max_time)
      return finish(run, FlowStatus::cancelled, fmt::format("cancelled at {:.4g} l/U", state.time), result);
    const auto now = std::chrono::steady_clock::now();
    if (keep && now - last_checkpoint > kBetweenCheckpoints) {
      keep();
      last_checkpoint = now;
    }
  }
}

/// Behind the centre on the axis y = 0, z = 0: where the mean velocity turns downstream for good, or the body's rear.
double bubble_end(const MacGrid& grid, const Openness& open, const FaceField& velocity) {
  const int j = grid.cells[1] / 2, k = grid.dimensions == 3 ? grid.cells[2] / 2 : 0;
  const auto on_axis = [&](int i) {
    return 0.5 * (velocity[0][static_cast<std::size_t>(grid.at(i, j, k))] +
                  velocity[0][static_cast<std::size_t>(grid.at(i, j - 1, k))]);
  };
  const auto place = [&](int i) { return grid.face_centre(0, i, j, k).x(); };
  for (int i = grid.cells[0] - 1; i > 0 && place(i) > 0.0; --i) {
    if (open.face[0][static_cast<std::size_t>(grid.at(i, j, k))] == 0.0) return place(i);
    const double before = on_axis(i), after = on_axis(i + 1);
    if (before < 0.0 && after >= 0.0) return place(i) + grid.spacing * before / (before - after);
  }
  return 0.0;
}

void summarise(FlowRun& run, const FlowOptions& options, double repeats, FlowResult& result) {
  FlowMarch& march = run.march;
  FlowMean& mean = run.last_mean();
  // A steady flow is its own mean.
  if (result.status == FlowStatus::steady || mean.fields.time() == 0.0) {
    mean.fields = FieldAverage(march.grid(), march.turbulence() != nullptr);
    mean.fields.add(march, 1.0);
  } else {
    result.averaged_time = mean.fields.time();
  }
  result.velocity = mean.fields.velocity();
  result.pressure = mean.fields.pressure();
  result.k_resolved = mean.fields.k_resolved();
  if (march.turbulence() != nullptr) {
    result.k_modelled = mean.fields.k_modelled();
    result.epsilon = mean.fields.epsilon();
  }
  if (!march.moves()) result.bubble_end = bubble_end(march.grid(), march.openness(), result.velocity);

  const LoadRecord& last = run.history.back();
  if (options.end == FlowEnd::time) mean.periods = last_periods(run.history, repeats);
  const std::vector<PeriodMeans>& periods = mean.periods;
  const bool is_steady = result.status == FlowStatus::steady;
  if (is_steady || periods.empty()) {
    // Of a flow that still changes, one step is no mean.
    result.drag = {last.drag, is_steady ? 0.0 : INFINITY};
    result.lift = last.lift;
    result.moment = last.moment;
    if (!is_steady) result.drag_rms = result.lift_rms = result.strouhal = NAN;
  } else {
    double length = 0.0, drag_squared = 0.0, lift_squared = 0.0;
    for (const PeriodMeans& period : periods) {
      length += period.length;
      result.lift += period.length * period.lift;
      result.moment += period.length * period.moment;
      drag_squared += period.length * period.drag_squared;
      lift_squared += period.length * period.lift_squared;
    }
    result.drag = mean_drag(periods);
    result.lift /= length;
    result.moment /= length;
    result.drag_rms = std::sqrt(std::max(0.0, drag_squared / length - result.drag.value * result.drag.value));
    result.lift_rms = std::sqrt(std::max(0.0, lift_squared / length - result.lift * result.lift));
    result.strouhal = shedding_frequency(periods);
    // Where the mean is known, hardly any crossing says that nothing sheds; of a shorter run it says nothing.
    if (result.strouhal == 0.0 && result.status != FlowStatus::averaged) result.strouhal = NAN;
  }
  FlowChecks& checks = result.checks;
  checks.divergence = march.divergence();
  checks.unconverged = run.unconverged;
  checks.force_disagreement = std::max(run.worst_disagreement, disagreement(run));
  if (KEpsilon* const turbulence = march.turbulence()) {
    checks.energy_defect = turbulence->budget().defect();
    checks.guarded_cells = turbulence->guarded();
    checks.production = turbulence->total_production();
    const std::array<double, 3> wall = turbulence->wall_range();
    checks.y_plus_low = wall[0];
    checks.y_plus_high = wall[1];
    checks.viscous_share = wall[2];
  }
}

void warn(const FlowCase& flow, FlowResult& result) {
  if (flow.turbulence != TurbulenceModel::none && flow.reynolds < 1e3)
    result.warnings.push_back(fmt::format(
        "k-epsilon is a model of high Reynolds numbers, and this is {:.3g}: expected turbulence = \"none\"",
        flow.reynolds));
  if (flow.turbulence != TurbulenceModel::none && flow.reynolds > 1e4 && result.checks.viscous_share > 0.5)
    result.warnings.push_back(
        fmt::format("{:.0f} % of the wall's cells lie in the viscous layer, where its law does not hold",
                    100.0 * result.checks.viscous_share));
  if (result.checks.unconverged > 0)
    result.warnings.push_back(
        fmt::format("the pressure was not found to its tolerance in {} steps", result.checks.unconverged));
  if (result.checks.guarded_cells > 0)
    result.warnings.push_back(
        fmt::format("the guard of the eddy viscosity acts in {} cells", result.checks.guarded_cells));
}

/// Halves a time in which a body moves by more than a cell, again and again: without leaps, however fast it is, it
/// moves by less in what is left. @param reach of the body from its centre
void require_no_leap(const FlowCase& flow, double reach, double from, double to) {
  constexpr int kHalvings = 40;
  const double cell = 1.0 / flow.cells_per_length;
  const auto way = [&](double begin, double end) {
    const BodyPose before = flow.motion->path(begin), after = flow.motion->path(end);
    return (after.place - before.place).norm() + reach * std::abs(after.angle - before.angle);
  };
  for (int i = 0; i < kHalvings; ++i) {
    if (!(way(from, to) > cell)) return;
    const double middle = 0.5 * (from + to);
    (way(from, middle) > way(middle, to) ? to : from) = middle;
  }
  throw ArgumentError(
      fmt::format("solve_flow: the body leaps by {:.4g} at t = {:.6g}, more than a cell, {:.4g}: expected a "
                  "path without leaps",
                  way(from, to), to, cell));
}

}  // namespace

std::string to_string(FlowStatus status) {
  constexpr std::array kNames = {"steady", "averaged", "max_time", "ended", "diverged", "cancelled"};
  return kNames.at(static_cast<std::size_t>(status));
}

void check_path(const FlowCase& flow, const FlowOptions& options) {
  if (options.end != FlowEnd::time)
    throw ArgumentError("solve_flow: a body that moves has no mean flow, expected the end \"time\"");
  const MacGrid grid = grid_of(flow);
  PlacedShape body(flow.shape, Eigen::Vector3d::Zero(), 0.0);
  const double reach = body.half_extent().norm();
  constexpr int kPlaces = 2000;
  double before = 0.0;
  for (int i = 0; i <= kPlaces; ++i) {
    const double t = options.max_time * i / kPlaces;
    const BodyPose pose = flow.motion->path(t);
    if (!pose.is_finite())
      throw ArgumentError(fmt::format("solve_flow: the path of the body is not finite at t = {:.6g}", t));
    require_no_leap(flow, reach, before, t);
    before = t;
    body.move_to(pose.place, pose.angle + flow.angle_of_attack);
    require_within(grid, body, fmt::format(" at t = {:.6g}", t));
  }
}

FlowResult solve_flow(const FlowCase& flow, const FlowOptions& options) {
  check_case(flow, options.max_memory);
  require_positive(options.max_time, "max_time", "solve_flow");
  if (options.end == FlowEnd::time && !flow.motion)
    throw ArgumentError("solve_flow: the end \"time\" is that of bodies that move, and this one is held");
  if (flow.motion) check_path(flow, options);
  require(options.threads >= 0, "threads", options.threads, "0 for all cores, or their number", "solve_flow");
  codebooks::check_checkpoint_path(options.checkpoint, kFlowCheckpoint);
  FlowResult result;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    FlowRun run(setup_of(flow), case_text(flow, options));
    if (options.resume && load_checkpoint(run, options.checkpoint)) {
      if (run.march.state().time >= options.max_time)
        throw ArgumentError(
            fmt::format("solve_flow: max_time is {:.6g} l/U, and the flow in {} stands at {:.6g} l/U; a "
                        "max_time after that "
                        "was expected, or --fresh to begin anew",
                        options.max_time, options.checkpoint.string(), run.march.state().time));
    } else {
      start(run, options.seed);
    }
    std::function<void()> keep;
    if (!options.checkpoint.empty())
      keep = codebooks::told_once<>([&] { save_checkpoint(run, options.checkpoint); }, options.warning);
    march_to_end(run, options, keep, result);
    result.checks.clipped_cells = run.not_positive;
    const bool can_go_on = result.status == FlowStatus::cancelled || result.status == FlowStatus::max_time;
    if (can_go_on && keep) keep();
    result.grid = run.march.grid();
    result.body = run.march.openness();
    result.history = run.history;
    if (result.status != FlowStatus::diverged)
      summarise(run, options, flow.motion ? flow.motion->period : 0.0, result);
  });
  result.checks.blockage = blockage(flow);
  warn(flow, result);
  return result;
}

}  // namespace samara::flow
