#include "samara/codebooks/source/sampled_source.h"

#include <algorithm>
#include <memory>
#include <span>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"
#include "samara/codebooks/source/command_program.h"
#include "samara/codebooks/source/model_measure.h"
#include "samara/models/integrators/integrate.h"

namespace samara::codebooks {

namespace {

/// The lowest corner of the box, its centre, and the highest corner, as columns.
Eigen::MatrixXd diagonal_of(const Plan& plan) {
  Eigen::MatrixXd points(static_cast<Eigen::Index>(plan.box.size()), 3);
  for (Eigen::Index k = 0; k < points.rows(); ++k) {
    const BoxEntry& entry = plan.box[static_cast<std::size_t>(k)];
    points.row(k) << entry.lower, 0.5 * (entry.lower + entry.upper), entry.upper;
  }
  return points;
}

/// Noise of the integrator would be taken for structure: far below the tolerance.
double integrator_tolerance(const Plan& plan, const models::ParametricModel& model,
                            const pgd::OutputMeasure& measure) {
  const double share = share_for_range(model, diagonal_of(plan), plan.end, measure);
  return std::clamp(1e-4 * share * plan.relative, 1e-13, 1e-8);
}

/// Trajectories of the model at many points at a time.
class Trajectories {
 public:
  Trajectories(const Plan& plan, const models::ParametricModel& model, double tolerance)
      : arena_(plan.builder.threads > 0 ? std::min(plan.builder.threads, tbb::info::default_concurrency())
                                        : tbb::info::default_concurrency()),
        integrators_([tolerance, &model] {
          return models::Integrator(model, {.relative_tolerance = tolerance}, false);
        }) {}

  SampledAnswers operator()(const Eigen::MatrixXd& points, const std::vector<double>& times) {
    std::vector<models::Trajectory> results(static_cast<std::size_t>(points.cols()));
    arena_.execute([&] {
      parallel_for(points.cols(), [&](Eigen::Index j) {
        const std::span<const double> q(points.col(j).data(), static_cast<std::size_t>(points.rows()));
        results[static_cast<std::size_t>(j)] = integrators_.local()(q, times);
      });
    });
    const auto bad =
        std::ranges::find_if(results, [](const models::Trajectory& result) { return !result.is_usable(); });
    SampledAnswers answers;
    if (bad != results.end()) answers.failure = bad->message;
    const Eigen::Index good = bad - results.begin();
    if (good == 0) return answers;
    answers.values.resize(results.front().states.size(), good);
    for (Eigen::Index j = 0; j < good; ++j) {
      const Eigen::MatrixXd states = results[static_cast<std::size_t>(j)].states.transpose();
      answers.values.col(j) = states.reshaped();
    }
    return answers;
  }

 private:
  tbb::task_arena arena_;
  tbb::enumerable_thread_specific<models::Integrator> integrators_;
};

/// A program with some of its inputs fixed.
class PlannedFunction {
 public:
  PlannedFunction(const Plan& plan, pgd::PointsFunction instead)
      : outputs_(static_cast<Eigen::Index>(plan.command->outputs.size())),
        instead_(std::move(instead)),
        program_(std::make_shared<CommandProgram>(Command{.run = plan.command->run,
                                                          .timeout = plan.command->timeout,
                                                          .largest_batch = plan.command->batch,
                                                          .persistent = plan.command->persistent})) {
    for (const CommandQuantity& input : plan.command->inputs) {
      const auto free =
          std::ranges::find_if(plan.box, [&](const BoxEntry& entry) { return entry.name == input.name; });
      places_.push_back(free == plan.box.end() ? -1 : free - plan.box.begin());
      fixed_.push_back(free == plan.box.end() ? plan.fixed.at(input.name) : 0.0);
    }
  }

  void finish() const { program_->finish(); }

  /// Asks for all points at once; where that fails, one by one, to find the point.
  SampledAnswers operator()(const Eigen::MatrixXd& points, const std::vector<double>& times) const {
    const Eigen::MatrixXd rows = inputs(points, times);
    const Eigen::Index numbers = outputs_ * std::max<Eigen::Index>(1, std::ssize(times));
    SampledAnswers answers;
    try {
      answers.values = answered(rows, numbers);
      return answers;
    } catch (const Error& error) {
      answers.failure = error.what();
    }
    answers.values.resize(numbers, 0);
    if (points.cols() == 1) return answers;
    Eigen::MatrixXd good(numbers, points.cols());
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      try {
        good.col(j) = answered(rows.col(j), numbers);
      } catch (const Error& error) {
        return {good.leftCols(j), error.what()};
      }
    }
    return {good, ""};
  }

 private:
  Eigen::MatrixXd inputs(const Eigen::MatrixXd& points, const std::vector<double>& times) const {
    const auto count = static_cast<Eigen::Index>(places_.size());
    Eigen::MatrixXd rows(count + static_cast<Eigen::Index>(times.size()), points.cols());
    for (std::size_t k = 0; k < places_.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      if (places_[k] < 0) {
        rows.row(row).setConstant(fixed_[k]);
      } else {
        rows.row(row) = points.row(places_[k]);
      }
    }
    for (std::size_t i = 0; i < times.size(); ++i)
      rows.row(count + static_cast<Eigen::Index>(i)).setConstant(times[i]);
    return rows;
  }

  /// Whatever a function throws counts as its failure.
  Eigen::MatrixXd answered(const Eigen::MatrixXd& rows, Eigen::Index numbers) const {
    if (!instead_) return program_->answers(rows, numbers);
    Eigen::MatrixXd values = Eigen::MatrixXd::Zero(numbers, rows.cols());
    try {
      instead_(rows, values);
    } catch (const std::exception& error) {
      throw Error(error.what());
    }
    if (values.rows() == numbers && values.cols() == rows.cols()) return values;
    throw Error(fmt::format("the function made a table of {} x {} for {} outputs at {} points", values.rows(),
                            values.cols(), numbers, rows.cols()));
  }

  Eigen::Index outputs_;
  pgd::PointsFunction instead_;
  std::shared_ptr<CommandProgram> program_;
  std::vector<Eigen::Index> places_;  ///< of the inputs in the box; -1: fixed
  std::vector<double> fixed_;
};

}  // namespace

SampledSource model_source(const Plan& plan, const models::ParametricModel& model) {
  const models::ModelInfo& info = model.model().info();
  SampledSource source;
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    const models::FreeCoordinate& free = model.free()[k];
    source.coordinates.push_back({free.name, free.unit,
                                  free.is_initial ? pgd::AxisRole::initial : pgd::AxisRole::parameter,
                                  plan.box[k].transform});
  }
  for (const auto& state : info.states) source.outputs.push_back({state.name, state.unit});
  source.measure = {.floors = floors_of(plan.absolute, source.outputs),
                    .sizes = state_sizes(model, diagonal_of(plan).col(1))};
  source.time_unit = models::time_unit(info);
  source.answers_name = "trajectory";
  // Made when first asked: who steps the model by himself needs no tolerance, which takes trajectories to find.
  source.answers = [trajectories = std::shared_ptr<Trajectories>(), plan, &model, measure = source.measure](
                       const Eigen::MatrixXd& points, const std::vector<double>& times) mutable {
    if (!trajectories)
      trajectories = std::make_shared<Trajectories>(plan, model, integrator_tolerance(plan, model, measure));
    return (*trajectories)(points, times);
  };
  source.batch = 256;
  return source;
}

SampledSource command_source(const Plan& plan, const pgd::PointsFunction& function) {
  SampledSource source;
  for (const BoxEntry& entry : plan.box) {
    const auto input = std::ranges::find(plan.command->inputs, entry.name, &CommandQuantity::name);
    source.coordinates.push_back({entry.name, input->unit, pgd::AxisRole::parameter, entry.transform});
  }
  for (const CommandQuantity& output : plan.command->outputs)
    source.outputs.push_back({output.name, output.unit});
  source.measure.floors = floors_of(plan.absolute, source.outputs);
  source.answers_name = "answer";
  const PlannedFunction planned(plan, function);
  source.answers = planned;
  source.finish = [planned] { planned.finish(); };
  source.batch = plan.command->batch;
  // A program is killed after its timeout, however many points it was given.
  source.batch_seconds = std::min(source.batch_seconds, 0.25 * plan.command->timeout);
  return source;
}

}  // namespace samara::codebooks
