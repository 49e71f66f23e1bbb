#include "samara/models/trajectories/trajectory_family.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/parallel.h"

namespace samara::models {

namespace {

/// Trajectories to one source.
constexpr std::size_t kGroup = 16;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Nothing is left where nothing is known.
void clear_invalid(const TrajectoryOutcome& outcome, const std::vector<double>& times,
                   Eigen::MatrixXd& rows) {
  if (rows.size() > 0) rows.bottomRows(rows.rows() - rows_reached(outcome, times)).setConstant(kUnknown);
}

FamilyTrajectory evaluated(TrajectorySource& source, std::span<const double> q,
                           const std::vector<double>& times, Eigen::Index outputs, Derivatives derivatives) {
  const auto rows = static_cast<Eigen::Index>(times.size());
  FamilyTrajectory result;
  result.values.setConstant(rows, outputs, kUnknown);
  const bool with_derivatives = derivatives == Derivatives::yes;
  if (with_derivatives) {
    result.derivatives.setConstant(rows, outputs * static_cast<Eigen::Index>(q.size()), kUnknown);
  }
  result.outcome = source.evaluate(q, result.values, with_derivatives ? &result.derivatives : nullptr);
  clear_invalid(result.outcome, times, result.values);
  clear_invalid(result.outcome, times, result.derivatives);
  return result;
}

}  // namespace

Eigen::Index rows_reached(const TrajectoryOutcome& outcome, std::span<const double> times) {
  return outcome ? std::ssize(times) : std::ranges::upper_bound(times, outcome.reached) - times.begin();
}

std::unique_ptr<TrajectorySource> TrajectoryFamily::at(const std::vector<double>& times,
                                                       const std::vector<std::string>& outputs,
                                                       const std::vector<int>& /*wanted*/) const {
  return at(times, outputs);
}

FamilyBatch TrajectoryFamily::batch(const Eigen::Ref<const Eigen::MatrixXd>& points,
                                    const std::vector<double>& times, const std::vector<std::string>& outputs,
                                    const FamilyBatchOptions& options) const {
  const auto count = static_cast<std::size_t>(points.rows());
  const bool with_derivatives = options.derivatives == Derivatives::yes;
  FamilyBatch result;
  result.outcomes.resize(count);
  result.values.resize(count);
  if (with_derivatives) result.derivatives.resize(count);
  const auto run = [&](std::size_t group) {
    const std::unique_ptr<TrajectorySource> source = at(times, outputs);
    for (std::size_t n = group * kGroup; n < std::min(count, (group + 1) * kGroup); ++n) {
      const Eigen::VectorXd q = points.row(static_cast<Eigen::Index>(n)).transpose();
      FamilyTrajectory one = evaluated(*source, std::span(q.data(), static_cast<std::size_t>(q.size())),
                                       times, static_cast<Eigen::Index>(outputs.size()), options.derivatives);
      result.outcomes[n] = std::move(one.outcome);
      result.values[n] = std::move(one.values);
      if (with_derivatives) result.derivatives[n] = std::move(one.derivatives);
    }
  };
  if (count == 0) at(times, outputs);  // refuses what it must
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { parallel_for((count + kGroup - 1) / kGroup, run); });
  return result;
}

FamilyTrajectory trajectory(const TrajectoryFamily& family, std::span<const double> q,
                            const std::vector<double>& times, const std::vector<std::string>& outputs,
                            Derivatives derivatives) {
  const std::unique_ptr<TrajectorySource> source = family.at(times, outputs);
  return evaluated(*source, q, times, static_cast<Eigen::Index>(outputs.size()), derivatives);
}

std::optional<std::size_t> position(std::span<const FamilyCoordinate> coordinates, const std::string& name) {
  const auto found = std::ranges::find(coordinates, name, &FamilyCoordinate::name);
  if (found == coordinates.end()) return {};
  return static_cast<std::size_t>(found - coordinates.begin());
}

std::vector<std::string> names_of(std::span<const FamilyCoordinate> coordinates) {
  std::vector<std::string> names;
  for (const FamilyCoordinate& c : coordinates) names.push_back(c.name);
  return names;
}

std::vector<std::string> output_names(const FamilyInfo& family) {
  std::vector<std::string> names;
  for (const FamilyOutput& output : family.outputs) names.push_back(output.name);
  return names;
}

void check_point(std::span<const double> q, std::size_t count) {
  if (q.size() != count) {
    throw ArgumentError(fmt::format("a point has {} coordinates; {} were expected", q.size(), count));
  }
  for (const double value : q) {
    if (!std::isfinite(value)) {
      throw ArgumentError(fmt::format("a coordinate is {}; a finite number was expected", value));
    }
  }
}

}  // namespace samara::models
