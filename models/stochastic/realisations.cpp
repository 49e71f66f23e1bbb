#include "samara/models/stochastic/realisations.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/require.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/stochastic/realisation_pack.h"

namespace samara::models {

namespace {

/// Realisations of one task, and tasks between two looks at the whole: both fixed, so that sums do not depend on the
/// machine or its threads.
constexpr long kGroup = 32;
constexpr long kWave = 8 * kGroup;

void check_options(const RealiseOptions& options) {
  require(options.realisations >= 1, "realisations", options.realisations, "at least 1");
  // Numbers of realisations are exact as doubles, and their sum is one.
  constexpr long kMost = 1L << 52;
  require(options.realisations <= kMost, "realisations", options.realisations,
          fmt::format("at most {}", kMost));
  require(options.first >= 0, "first", options.first, "0 or more");
  require(options.first <= kMost, "first", options.first, fmt::format("at most {}", kMost));
  require(options.keep <= kMost, "keep", options.keep, fmt::format("at most {}", kMost));
  require(!options.antithetic || options.first % 2 == 0, "first", options.first,
          "an even number, for antithetic pairs");
  require(!options.antithetic || options.realisations % 2 == 0, "realisations", options.realisations,
          "an even number, for antithetic pairs");
  require(options.keep >= 0, "keep", options.keep, "0 or more");
  check_step(options.step);
  check_max_steps(options.max_steps);
  require_not_negative(options.relative_error, "relative_error");
  if (options.ground)
    require(std::isfinite(*options.ground), "ground [m]", *options.ground, "a finite height");
}

/// Indices of the chosen states.
std::vector<int> chosen_states(const ModelInfo& info, const std::vector<std::string>& names,
                               const GustLayout& layout) {
  if (names.empty()) return layout.position();
  std::vector<std::string> all;
  for (const StateInfo& state : info.states) all.push_back(state.name);
  std::vector<int> indices;
  for (const std::string& name : names) {
    const auto found = std::ranges::find(all, name);
    if (found == all.end())
      throw ArgumentError(
          fmt::format("model \"{}\" has no state \"{}\"{}", info.name, name, suggestion(name, all)));
    indices.push_back(static_cast<int>(found - all.begin()));
    if (std::ranges::count(names, name) > 1)
      throw ArgumentError(fmt::format("states have \"{}\" twice, expected each state once", name));
  }
  return indices;
}

RealisationPlan plan_of(const ParametricModel& model, std::span<const double> point, const AirSource& air,
                        std::span<const double> times, const RealiseOptions& options) {
  check_options(options);
  check_times(times);
  require(!times.empty(), "number of times", times.size(), "at least 1");
  model.check(point);
  GustLayout layout(model.model());
  for (const std::string& name : layout.parameter_names()) {
    const bool is_free = std::ranges::count(model.free(), name, &FreeCoordinate::name) > 0;
    if (is_free || model.fixed().contains(name))
      throw ArgumentError(fmt::format("{} was given a value; realisations set it step by step", name));
  }
  if (are_too_many(times, options.step, options.max_steps)) {
    throw ArgumentError(
        fmt::format("steps of {} s to t = {} s are more than {}; a longer step or fewer times were expected",
                    options.step, times.back(), options.max_steps));
  }
  std::map<std::string, double> fixed = model.fixed();
  for (const std::string& name : layout.parameter_names()) fixed[name] = 0.0;
  std::vector<std::string> free;
  for (const FreeCoordinate& coordinate : model.free()) free.push_back(coordinate.name);
  RealisationPlan plan = {.model = {model.shared_model(), fixed, free},
                          .point = point,
                          .air = air,
                          .times = {times.begin(), times.end()},
                          .step = options.step,
                          .ground = options.ground,
                          .antithetic = options.antithetic,
                          .states = chosen_states(model.model().info(), options.states, layout),
                          .layout = layout,
                          .follows = {}};
  std::vector<double> x(static_cast<std::size_t>(model.state_count()));
  model.initial(point, x);
  const double height = x[static_cast<std::size_t>(layout.position().back())];
  if (options.ground && !(height > *options.ground)) {
    throw ArgumentError(fmt::format(
        "ground [m] is {}, expected below the start, which is at a height of {} m", *options.ground, height));
  }
  ParameterValues all;
  all.value = plan.model.parameters(point);
  all.given.assign(all.value.size(), 1);
  plan.follows = layout.follows(model.model(), x, all);
  return plan;
}

/// Of the realisations of one task.
EnsembleSums sums_of(const RealisationPlan& plan, std::vector<RealisationRecord>& records) {
  EnsembleSums sums(plan.times.size(), static_cast<Eigen::Index>(plan.states.size()));
  const std::size_t together = plan.antithetic ? 2 : 1;
  // The mean of those of a pair that count: add(record, n) adds what one has, and tells whether it counts.
  const auto by_pairs = [&](Spread& to, Eigen::Index size, const auto& value) {
    for (std::size_t first = 0; first < records.size(); first += together) {
      Eigen::VectorXd sum = Eigen::VectorXd::Zero(size);
      double count = 0.0;
      for (std::size_t n = first; n < std::min(first + together, records.size()); ++n) {
        const Eigen::VectorXd one = value(records[n]);
        if (one.size() == 0 || !one.allFinite()) continue;
        sum += one;
        count += 1.0;
      }
      if (count > 0.0) to.add(sum / count);
    }
  };
  for (std::size_t k = 0; k < plan.times.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const auto at_time = [&](const RealisationRecord& record) -> Eigen::VectorXd {
      return record.chosen.row(row);
    };
    TimeSums& at = sums.at[k];
    for (const RealisationRecord& record : records) {
      const Eigen::VectorXd x = at_time(record);
      if (x.allFinite()) at.single.add(x);
    }
    by_pairs(at.independent, static_cast<Eigen::Index>(plan.states.size()), at_time);
    at.close_group();
  }
  by_pairs(sums.half_turns, 1, [](const RealisationRecord& record) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, record.half_turns);
  });
  // With a ground those that have not come down say nothing of the landing.
  const auto displacement = [&](const RealisationRecord& record) -> Eigen::VectorXd {
    if (plan.ground && record.status != RealisationStatus::landed) return {};
    return record.displacement;
  };
  by_pairs(sums.displacement, 3, displacement);
  for (const RealisationRecord& record : records) {
    const Eigen::VectorXd way = displacement(record);
    if (way.size() > 0) sums.way.add(Eigen::VectorXd::Constant(1, way.squaredNorm()));
  }
  return sums;
}

struct TaskResult {
  std::vector<RealisationRecord> records;
  EnsembleSums sums;
};

void take_up(Ensemble& ensemble, std::vector<RealisationRecord>& records, const GustLayout& layout) {
  for (RealisationRecord& record : records) {
    ensemble.status.push_back(record.status);
    if (layout.has_attitude()) ensemble.half_turns.push_back(record.half_turns);
    if (record.status == RealisationStatus::landed) ensemble.landings.push_back(record.landing);
    if (record.all.size() > 0) ensemble.kept.push_back(std::move(record.all));
  }
}

/// Runs realisations `first` to `last` - 1 in tasks. @returns false if cancelled; then nothing is changed
bool run_wave(const RealisationPlan& plan, long first, long last, const RealiseOptions& options,
              SharedProgress& progress, Ensemble& ensemble, EnsembleSums& sums) {
  const long tasks = (last - first + kGroup - 1) / kGroup;
  std::vector<std::optional<TaskResult>> results(static_cast<std::size_t>(tasks));
  arena_of(options.threads).execute([&] {
    parallel_for(tasks, [&](long task) {
      const long from = first + task * kGroup;
      const long to = std::min(last, from + kGroup);
      FlownRealisations flown = fly_realisations(plan, options.first + from, options.first + to,
                                                 options.first + options.keep, progress);
      if (flown.records.empty()) return;
      EnsembleSums of_task = sums_of(plan, flown.records);
      of_task.steps = flown.steps;
      results[static_cast<std::size_t>(task)] = {.records = std::move(flown.records),
                                                 .sums = std::move(of_task)};
      progress.count();
    });
  });
  if (std::ranges::any_of(results, [](const auto& result) { return !result; })) return false;
  for (std::optional<TaskResult>& result : results) {
    sums.merge(result->sums);
    take_up(ensemble, result->records, plan.layout);
  }
  return true;
}

std::vector<std::string> names_of(const RealisationPlan& plan) {
  std::vector<std::string> names;
  for (const int state : plan.states)
    names.push_back(plan.model.model().info().states[static_cast<std::size_t>(state)].name);
  return names;
}

/// All parameters and initial values that are flown.
std::vector<double> begun_with(const RealisationPlan& plan) {
  std::vector<double> values(static_cast<std::size_t>(plan.model.state_count()));
  plan.model.initial(plan.point, values);
  const std::vector<double> parameters = plan.model.parameters(plan.point);
  values.insert(values.end(), parameters.begin(), parameters.end());
  return values;
}

/// The statistics, from the sums.
void conclude(const RealisationPlan& plan, const EnsembleSums& sums, Ensemble& ensemble) {
  const ModelInfo& info = plan.model.model().info();
  const auto times = static_cast<Eigen::Index>(plan.times.size());
  const auto states = static_cast<Eigen::Index>(plan.states.size());
  ensemble.times = Eigen::Map<const Eigen::VectorXd>(plan.times.data(), times);
  ensemble.units.clear();
  ensemble.states = names_of(plan);
  for (const int state : plan.states) {
    ensemble.units.push_back(info.states[static_cast<std::size_t>(state)].unit);
  }
  ensemble.flying.resize(times);
  ensemble.mean.resize(times, states);
  ensemble.mean_error.resize(times, states);
  ensemble.covariance.clear();
  ensemble.covariance_error.clear();
  for (Eigen::Index k = 0; k < times; ++k) {
    const TimeSums& at = sums.at[static_cast<std::size_t>(k)];
    ensemble.flying[k] = at.single.count();
    ensemble.mean.row(k) = at.single.mean();
    if (at.single.count() == 0) ensemble.mean.row(k).setConstant(std::numeric_limits<double>::quiet_NaN());
    ensemble.mean_error.row(k) = at.independent.error_of_mean();
    ensemble.covariance.push_back(at.single.covariance());
    ensemble.covariance_error.push_back(at.groups.error_of_mean().reshaped(states, states));
  }
  ensemble.mean_half_turns = {sums.half_turns.mean()[0], sums.half_turns.error_of_mean()[0]};
  const auto steps = static_cast<double>(std::max(1L, sums.steps.steps()));
  ensemble.steps = {.beyond_tenth = static_cast<double>(sums.steps.beyond_tenth()) / steps,
                    .beyond_third = static_cast<double>(sums.steps.beyond_third()) / steps,
                    .shortest = sums.steps.scale_below(0.05)};
  ensemble.antithetic = plan.antithetic;
  ensemble.step = plan.step;
  ensemble.ground = plan.ground;
  ensemble.values = begun_with(plan);
  ensemble.relative_error = sums.relative_error();
  ensemble.sums = std::make_shared<EnsembleSums>(sums);
}

/// Puts numbers into a row, or takes them from one.
class NumberWriter {
 public:
  void operator()(long value) { numbers.push_back(static_cast<double>(value)); }
  void operator()(double value) { numbers.push_back(value); }
  void operator()(const Eigen::Ref<const Eigen::MatrixXd>& values) {
    for (const auto& column : values.colwise()) numbers.insert(numbers.end(), column.begin(), column.end());
  }

  std::vector<double> numbers;
};

class NumberReader {
 public:
  explicit NumberReader(std::span<const double> numbers) : left_(numbers) {}

  void operator()(long& value) { value = static_cast<long>(next()); }
  void operator()(double& value) { value = next(); }
  void operator()(Eigen::Ref<Eigen::MatrixXd> values) {
    for (auto column : values.colwise()) std::ranges::generate(column, [&] { return next(); });
  }
  /// A count of things that take at least a number each.
  std::size_t size() {
    const double value = next();
    if (!(value >= 0.0 && value <= static_cast<double>(left_.size()) && value == std::floor(value)))
      throw ArgumentError("the numbers of an ensemble are damaged, or of another call");
    return static_cast<std::size_t>(value);
  }
  bool is_at_end() const { return left_.empty(); }

 private:
  double next() {
    if (left_.empty()) throw ArgumentError("the numbers of an ensemble are too few, or of another call");
    const double value = left_.front();
    left_ = left_.subspan(1);
    return value;
  }

  std::span<const double> left_;
};

/// When RealiseOptions::so_far is given what is done.
class HandingOver {
 public:
  explicit HandingOver(long begun) : first_(begun + 4 * kWave) {}

  bool is_due(long done) const {
    return (is_first_ && done >= first_) || Clock::now() - last_ >= std::chrono::seconds(10);
  }
  void done() {
    is_first_ = false;
    last_ = Clock::now();
  }

 private:
  using Clock = std::chrono::steady_clock;

  long first_;
  bool is_first_ = true;
  Clock::time_point last_ = Clock::now();
};

Ensemble run_from(Ensemble ensemble, EnsembleSums sums, const RealisationPlan& plan,
                  const RealiseOptions& options) {
  const auto all = static_cast<double>(options.realisations);
  SharedProgress progress(options.progress, "realising", std::ceil(all / kGroup));
  for (long group = 0; group < ensemble.realisations() / kGroup; ++group) progress.count();
  HandingOver handing_over(ensemble.realisations());
  while (ensemble.realisations() < options.realisations) {
    const long first = ensemble.realisations();
    if (options.relative_error > 0.0 && first > 0 && sums.relative_error() <= options.relative_error) break;
    if (!run_wave(plan, first, std::min(options.realisations, first + kWave), options, progress, ensemble,
                  sums)) {
      ensemble.cancelled = true;
      break;
    }
    const bool goes_on = ensemble.realisations() < options.realisations;
    if (options.so_far && goes_on && handing_over.is_due(ensemble.realisations())) {
      conclude(plan, sums, ensemble);
      options.so_far(ensemble);
      handing_over.done();
    }
  }
  conclude(plan, sums, ensemble);
  if (options.so_far && ensemble.cancelled && ensemble.realisations() > 0) options.so_far(ensemble);
  return ensemble;
}

}  // namespace

double step_of_body(const ParametricModel& model, std::span<const double> point) {
  return std::min(1e-3, model.scales(point).time / 20.0);
}

Ensemble realise(const ParametricModel& model, std::span<const double> point, const AirSource& air,
                 std::span<const double> times, const RealiseOptions& options) {
  const RealisationPlan plan = plan_of(model, point, air, times, options);
  Ensemble ensemble;
  ensemble.first = options.first;
  return run_from(std::move(ensemble),
                  EnsembleSums(times.size(), static_cast<Eigen::Index>(plan.states.size())), plan, options);
}

void check_realisations(const ParametricModel& model, std::span<const double> point, const AirSource& air,
                        std::span<const double> times, const RealiseOptions& options) {
  plan_of(model, point, air, times, options);
}

std::vector<double> numbers_of(const Ensemble& ensemble) {
  if (!ensemble.sums)
    throw ArgumentError("an ensemble that was not made by realise() has no numbers to go on from");
  NumberWriter write;
  write(ensemble.realisations());
  for (const RealisationStatus status : ensemble.status) write(static_cast<long>(status));
  write(static_cast<long>(ensemble.half_turns.size()));
  for (const int turns : ensemble.half_turns) write(static_cast<long>(turns));
  write(static_cast<long>(ensemble.landings.size()));
  for (const Landing& landing : ensemble.landings) {
    write(landing.realisation);
    write(landing.t);
    write(landing.position);
  }
  write(static_cast<long>(ensemble.kept.size()));
  for (const Eigen::MatrixXd& all : ensemble.kept) write(all);
  EnsembleSums sums = *ensemble.sums;
  sums.visit(write);
  return std::move(write.numbers);
}

Ensemble ensemble_of(std::span<const double> numbers, const ParametricModel& model,
                     std::span<const double> point, const AirSource& air, std::span<const double> times,
                     const RealiseOptions& options) {
  const RealisationPlan plan = plan_of(model, point, air, times, options);
  NumberReader read(numbers);
  Ensemble ensemble;
  ensemble.first = options.first;
  ensemble.status.resize(read.size());
  for (RealisationStatus& status : ensemble.status) {
    long which = 0;
    read(which);
    if (which < 0 || which > static_cast<long>(RealisationStatus::not_finite))
      throw ArgumentError("the numbers of an ensemble hold a status that there is not");
    status = static_cast<RealisationStatus>(which);
  }
  ensemble.half_turns.resize(read.size());
  for (int& turns : ensemble.half_turns) {
    long count = 0;
    read(count);
    turns = static_cast<int>(count);
  }
  ensemble.landings.resize(read.size());
  for (Landing& landing : ensemble.landings) {
    read(landing.realisation);
    read(landing.t);
    read(landing.position);
  }
  ensemble.kept.resize(read.size());
  for (Eigen::MatrixXd& all : ensemble.kept) {
    all.resize(static_cast<Eigen::Index>(times.size()), model.state_count());
    read(all);
  }
  EnsembleSums sums(times.size(), static_cast<Eigen::Index>(plan.states.size()));
  sums.visit(read);
  if (!read.is_at_end()) throw ArgumentError("the numbers of an ensemble are too many, or of another call");
  conclude(plan, sums, ensemble);
  return ensemble;
}

Ensemble resume(const Ensemble& begun, const ParametricModel& model, std::span<const double> point,
                const AirSource& air, std::span<const double> times, const RealiseOptions& options) {
  const RealisationPlan plan = plan_of(model, point, air, times, options);
  if (!begun.sums) throw ArgumentError("an ensemble that was not made by realise() cannot be resumed");
  require(begun.realisations() % kWave == 0, "realisations of the ensemble to resume", begun.realisations(),
          "a multiple of 256");
  require(begun.first == options.first, "first", options.first,
          fmt::format("{}, as it was begun", begun.first));
  const auto check = [](bool is_same, const char* what) {
    if (!is_same)
      throw ArgumentError(
          fmt::format("the ensemble to resume has {}; what it was begun with was expected", what));
  };
  check(
      begun.times.size() == static_cast<Eigen::Index>(times.size()) && std::ranges::equal(begun.times, times),
      "other times");
  check(begun.states == names_of(plan), "other states");
  check(begun.antithetic == options.antithetic, "other pairs");
  check(begun.step == options.step, "another step");
  check(begun.ground == options.ground, "another ground");
  check(begun.values == begun_with(plan), "other values of the model");
  check(std::ssize(begun.kept) == std::min(options.keep, begun.realisations()),
        "another number of trajectories kept");
  Ensemble ensemble = begun;
  ensemble.cancelled = false;
  return run_from(std::move(ensemble), *begun.sums, plan, options);
}

}  // namespace samara::models
