#include "samara/codebooks/sampling_builder.h"

#include <algorithm>
#include <functional>
#include <span>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include "samara/codebooks/time_mesh.h"
#include "samara/models/integrate.h"
#include "samara/pgd/random.h"
#include "samara/pgd/sampling.h"

namespace samara::codebooks {

namespace {

// Shares of the plan's tolerance. The mesh of time has three times its own left for what pilots do not see.
constexpr double kTimeShare = 0.1;
constexpr double kSamplingShare = 0.5;

/// Ends the pilots from inside.
struct PilotsStopped {
  std::string status;
  std::string message;
};

/// Noise of the integrator would be taken for structure: far below the tolerance.
double integrator_tolerance(const Plan& plan) {
  return std::clamp(1e-4 * plan.relative, 1e-13, 1e-8);
}

/// Trajectories of the model at many points at a time.
class Trajectories {
 public:
  Trajectories(const Plan& plan, const models::ParametricModel& model)
      : arena_(plan.builder.threads > 0 ? std::min(plan.builder.threads, tbb::info::default_concurrency())
                                        : tbb::info::default_concurrency()),
        integrators_([tolerance = integrator_tolerance(plan), &model] {
          return models::Integrator(model, {.relative_tolerance = tolerance}, false);
        }) {}

  /// In the order of the points (coordinates x points). Those that cannot be integrated say so themselves.
  std::vector<models::Trajectory> operator()(const Eigen::MatrixXd& points,
                                             const std::vector<double>& times) {
    std::vector<models::Trajectory> results(static_cast<std::size_t>(points.cols()));
    arena_.execute([&] {
      tbb::parallel_for(Eigen::Index{0}, points.cols(), [&](Eigen::Index j) {
        const std::span<const double> q(points.col(j).data(), static_cast<std::size_t>(points.rows()));
        results[static_cast<std::size_t>(j)] = integrators_.local()(q, times);
      });
    });
    count_ += points.cols();
    return results;
  }

  long count() const { return count_; }

 private:
  tbb::task_arena arena_;
  tbb::enumerable_thread_specific<models::Integrator> integrators_;
  long count_ = 0;
};

/// Corners of the box (all of them for up to three coordinates) and random points.
Eigen::MatrixXd pilot_points(const Plan& plan) {
  constexpr int kCorners = 8, kInside = 8;
  pgd::Random random(plan.builder.seed);
  const auto coordinates = static_cast<Eigen::Index>(plan.box.size());
  const int corners = coordinates < 3 ? 1 << coordinates : kCorners;
  Eigen::MatrixXd points(coordinates, corners + kInside);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index k = 0; k < coordinates; ++k) {
      const BoxEntry& entry = plan.box[static_cast<std::size_t>(k)];
      const bool upper = coordinates <= 3 ? ((j >> k) & 1) != 0 : random.below(2) == 1;
      points(k, j) = j >= corners ? entry.lower + (entry.upper - entry.lower) * random.uniform()
                     : upper      ? entry.upper
                                  : entry.lower;
    }
  }
  return points;
}

std::string described(const models::ParametricModel& model, const Eigen::VectorXd& q) {
  std::string text;
  for (std::size_t k = 0; k < model.free().size(); ++k)
    text += fmt::format("{}{} = {:.9g}", k == 0 ? "" : ", ", model.free()[k].name,
                        q[static_cast<Eigen::Index>(k)]);
  return text;
}

TimeMesh mesh_by_pilots(const Plan& plan, const models::ParametricModel& model, Trajectories& trajectories,
                        long max_trajectories, const ProgressCallback& progress) {
  const Eigen::MatrixXd points = pilot_points(plan);
  const PilotTrajectories pilots = [&](const std::vector<double>& times) {
    if (trajectories.count() + points.cols() > max_trajectories) {
      throw PilotsStopped{"max_calls",
                          fmt::format("{} trajectories of the {} allowed were used, {} more were needed for "
                                      "the axis of time",
                                      trajectories.count(), max_trajectories, points.cols())};
    }
    if (progress && !progress({"pilots", 0.0})) throw PilotsStopped{"cancelled", "cancelled"};
    std::vector<Eigen::MatrixXd> states;
    const std::vector<models::Trajectory> results = trajectories(points, times);
    for (std::size_t j = 0; j < results.size(); ++j) {
      if (!results[j].is_usable()) {
        throw PilotsStopped{"failed", fmt::format("no trajectory at {}: {}",
                                                  described(model, points.col(static_cast<Eigen::Index>(j))),
                                                  results[j].message)};
      }
      states.push_back(results[j].states);
    }
    return states;
  };
  const models::ModelInfo& info = model.model().info();
  TimeMeshOptions options;
  options.tolerance = kTimeShare * plan.relative;
  options.floors = Eigen::VectorXd::Zero(model.state_count());
  for (std::size_t s = 0; s < info.states.size(); ++s) {
    const auto floor = plan.absolute.find(info.states[s].name);
    if (floor != plan.absolute.end()) options.floors[static_cast<Eigen::Index>(s)] = floor->second;
  }
  return mesh_time({"t", models::time_unit(info), pgd::AxisRole::time}, plan.end, pilots, options);
}

/// The outputs at the nodes of time as a function of points. The sampler, told of an exception, asks again
/// for the points one by one: those of a batch that failed are kept for that.
class SampledTrajectories {
 public:
  SampledTrajectories(Trajectories& trajectories, const pgd::Axis& time)
      : trajectories_(trajectories), times_(time.nodes().begin(), time.nodes().end()) {}

  void operator()(const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    std::vector<models::Trajectory> results = known(points);
    if (results.empty()) results = trajectories_(points, times_);
    for (std::size_t j = 0; j < results.size(); ++j) {
      if (!results[j].is_usable()) {
        const std::string message = results[j].message;
        failed_points_ = points;
        failed_ = std::move(results);
        throw std::runtime_error(message);
      }
      // Outputs fastest, then times.
      const Eigen::MatrixXd states = results[j].states.transpose();
      values.col(static_cast<Eigen::Index>(j)) = states.reshaped();
    }
  }

 private:
  std::vector<models::Trajectory> known(const Eigen::MatrixXd& points) const {
    if (points.cols() != 1) return {};
    for (Eigen::Index j = 0; j < failed_points_.cols(); ++j) {
      if (failed_points_.col(j) == points.col(0)) return {failed_[static_cast<std::size_t>(j)]};
    }
    return {};
  }

  Trajectories& trajectories_;
  std::vector<double> times_;
  Eigen::MatrixXd failed_points_;
  std::vector<models::Trajectory> failed_;
};

std::vector<pgd::OutputLabel> state_labels(const models::ParametricModel& model) {
  std::vector<pgd::OutputLabel> labels;
  for (const auto& state : model.model().info().states) labels.push_back({state.name, state.unit});
  return labels;
}

pgd::Axis::Label label_of(const Plan& plan, const models::ParametricModel& model, std::size_t k) {
  const models::FreeCoordinate& free = model.free()[k];
  return {free.name, free.unit, free.is_initial ? pgd::AxisRole::initial : pgd::AxisRole::parameter,
          plan.box[k].transform};
}

pgd::SamplingResult sample_trajectories(const Plan& plan, const models::ParametricModel& model,
                                        const TimeMesh& mesh, Trajectories& trajectories,
                                        long max_trajectories, const ProgressCallback& progress) {
  std::vector<pgd::SampledCoordinate> coordinates;
  for (std::size_t k = 0; k < plan.box.size(); ++k)
    coordinates.push_back({label_of(plan, model, k), plan.box[k].lower, plan.box[k].upper});
  std::vector<pgd::OutputLabel> outputs;
  for (const double t : mesh.axis.nodes()) {
    for (const pgd::OutputLabel& state : state_labels(model))
      outputs.push_back({fmt::format("{} at t = {:.6g}", state.name, t), state.unit});
  }
  pgd::SamplingOptions options;
  options.tolerance = kSamplingShare * plan.relative;
  // Errors of an output count by its range over all times, not by that at the one time.
  options.absolute = mesh.scale.replicate(mesh.axis.size(), 1);
  options.max_calls = std::max(1L, max_trajectories - trajectories.count());
  options.seed = plan.builder.seed;
  options.progress = progress;
  SampledTrajectories function(trajectories, mesh.axis);
  return pgd::sample(coordinates, outputs, std::ref(function), options);
}

/// The core over (outputs, times) becomes one of the outputs, the identity, and one of time: the same numbers
/// in the same order.
pgd::TrainField with_time(const pgd::TrainField& sampled, const pgd::Axis& time,
                          const std::vector<pgd::OutputLabel>& outputs) {
  const auto count = static_cast<int>(outputs.size());
  pgd::TrainCore output_core(1, count, count);
  output_core.left_unfolding().setIdentity();
  pgd::TensorTrain train = sampled.train();
  pgd::TrainCore& first = train.cores.front();
  first.left = count;
  first.size = time.size();
  train.cores.insert(train.cores.begin(), std::move(output_core));
  std::vector<pgd::Axis> axes = sampled.axes();
  axes.insert(axes.begin(), time);
  return {std::move(axes), outputs, std::move(train)};
}

/// The initial values in the middle of the box, for all times and points: where there is nothing better.
pgd::TrainField initial_values(const Plan& plan, const models::ParametricModel& model) {
  std::vector<double> centre;
  std::vector<pgd::Axis> axes = {pgd::Axis::chebyshev(
      {"t", models::time_unit(model.model().info()), pgd::AxisRole::time}, 0.0, plan.end, 2)};
  for (std::size_t k = 0; k < plan.box.size(); ++k) {
    centre.push_back(0.5 * (plan.box[k].lower + plan.box[k].upper));
    axes.push_back(pgd::Axis::chebyshev(label_of(plan, model, k), plan.box[k].lower, plan.box[k].upper, 2));
  }
  pgd::TensorTrain train;
  pgd::TrainCore& outputs = train.cores.emplace_back(1, model.state_count(), 1);
  model.initial(centre, {outputs.data.data(), static_cast<std::size_t>(model.state_count())});
  for (const pgd::Axis& axis : axes) {
    train.cores.emplace_back(1, axis.size(), 1);
    train.cores.back().data.setOnes();
  }
  return {std::move(axes), state_labels(model), std::move(train)};
}

}  // namespace

Solution solve_by_sampling(const Plan& plan, const models::ParametricModel& model, long max_trajectories,
                           const ProgressCallback& progress) {
  Trajectories trajectories(plan, model);
  BuildRecord record;
  record.builder = "sampling";
  record.strategy = "cross";
  try {
    const TimeMesh mesh = mesh_by_pilots(plan, model, trajectories, max_trajectories, progress);
    const long pilots = trajectories.count();
    const pgd::SamplingResult result =
        sample_trajectories(plan, model, mesh, trajectories, max_trajectories, progress);
    record.evaluations = static_cast<double>(trajectories.count());
    record.grid_size = result.grid_size * mesh.axis.size();
    record.rounds = static_cast<int>(result.history.size());
    record.status = !result.tolerance_met() ? to_string(result.status)
                    : mesh.resolved         ? "converged"
                                            : "not_resolved";
    record.message =
        fmt::format("{}; {} elements of time by {} pilot trajectories, interpolation error {:.3g}{}",
                    result.message, mesh.axis.elements(), pilots, mesh.error,
                    mesh.resolved ? "" : fmt::format(" > {:.3g}", kTimeShare * plan.relative));
    if (!result.field) return {{Piece{{initial_values(plan, model)}}}, record, {}, 0.0};
    return {{Piece{{with_time(*result.field, mesh.axis, state_labels(model))}}},
            record,
            {.discretisation = mesh.error, .compression = result.error},
            0.0};
  } catch (const PilotsStopped& stopped) {
    record.status = stopped.status;
    record.message = stopped.message;
    record.evaluations = static_cast<double>(trajectories.count());
    return {{Piece{{initial_values(plan, model)}}}, record, {}, 0.0};
  }
}

}  // namespace samara::codebooks
