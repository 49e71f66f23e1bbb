#include "samara/codebooks/build/sampling_builder.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/build/time_mesh.h"
#include "samara/codebooks/source/checkpoint.h"
#include "samara/pgd/fields/field_rounding.h"
#include "samara/pgd/sampling/leja.h"
#include "samara/pgd/sampling/sampling.h"
#include "samara/pgd/tensors/random.h"

namespace samara::codebooks {

namespace {

// Shares of the plan's tolerance. The mesh of time has three times its own left for what pilots do not see.
constexpr double kTimeShare = 0.1;
constexpr double kSamplingShare = 0.5;
constexpr double kSamplingShareWithoutTime = 0.8;
constexpr double kRoundingShare = 0.1;  // and what the cross did not use of its own

using SamplingChallenge = std::function<Eigen::MatrixXd(const pgd::SamplingResult&)>;

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

std::string described(const SampledSource& source, const Eigen::VectorXd& point) {
  std::string text;
  for (std::size_t k = 0; k < source.coordinates.size(); ++k)
    text += fmt::format("{}{} = {:.9g}", k == 0 ? "" : ", ", source.coordinates[k].name,
                        point[static_cast<Eigen::Index>(k)]);
  return text;
}

/// The axis of time, and how many calls it took.
struct PilotedMesh {
  TimeMesh mesh;
  long calls = 0;
};

Outcome<PilotedMesh> mesh_by_pilots(const Plan& plan, CallMemory& calls, long max_calls,
                                    const ProgressCallback& progress) {
  const Eigen::MatrixXd points = pilot_points(plan);
  const SampledSource& source = calls.source();
  const auto outputs = static_cast<Eigen::Index>(source.outputs.size());
  long used = 0;
  using Trajectories = std::vector<Eigen::MatrixXd>;
  const PilotTrajectories pilots = [&](const std::vector<double>& times) -> Outcome<Trajectories> {
    if (used + points.cols() > max_calls) {
      return Ending{Termination::max_calls, fmt::format("{} calls of the {} allowed were used, {} more were "
                                                        "needed for the axis of time",
                                                        used, max_calls, points.cols())};
    }
    if (progress && !progress({"pilots", 0.0})) return Ending{Termination::cancelled, "cancelled"};
    used += points.cols();
    const CalledAnswers answered = calls(points, times);
    if (!answered.failure.empty()) {
      return Ending{Termination::failed, fmt::format("no {} at {}: {}", source.answers_name,
                                                     described(source, answered.point), answered.failure)};
    }
    Trajectories trajectories;
    for (Eigen::Index j = 0; j < answered.values.cols(); ++j) {
      trajectories.push_back(
          answered.values.col(j).reshaped(outputs, answered.values.rows() / outputs).transpose());
    }
    return trajectories;
  };
  TimeMeshOptions options;
  options.tolerance = kTimeShare * plan.relative;
  options.measure = source.measure;
  Outcome<TimeMesh> mesh = mesh_time({"t", source.time_unit, pgd::AxisRole::time}, plan.end, pilots, options);
  if (!mesh) return mesh.ending();
  return PilotedMesh{std::move(*mesh), used};
}

/// What the sampler is told of the outputs: with time, all at every node.
struct SampledOutputs {
  std::vector<pgd::OutputLabel> labels;
  std::vector<double> times;
  Eigen::VectorXd floors;
};

SampledOutputs outputs_of(const SampledSource& source, const std::optional<TimeMesh>& mesh) {
  if (!mesh) return {source.outputs, {}, source.measure.floors};
  SampledOutputs outputs;
  outputs.times.assign(mesh->axis.nodes().begin(), mesh->axis.nodes().end());
  for (const double t : outputs.times) {
    for (const pgd::OutputLabel& output : source.outputs)
      outputs.labels.push_back({fmt::format("{} at t = {:.6g}", output.name, t), output.unit});
  }
  // Errors of an output count by its range over all times, not by that at the one time.
  outputs.floors = mesh->scale.replicate(mesh->axis.size(), 1);
  return outputs;
}

pgd::SamplingResult sample_calls(const Plan& plan, CallMemory& calls, const std::optional<TimeMesh>& mesh,
                                 long max_calls, const ProgressCallback& progress,
                                 const SamplingChallenge& challenge) {
  std::vector<pgd::SampledCoordinate> coordinates;
  for (std::size_t k = 0; k < plan.box.size(); ++k)
    coordinates.push_back({calls.source().coordinates[k], plan.box[k].lower, plan.box[k].upper});
  const SampledOutputs outputs = outputs_of(calls.source(), mesh);
  pgd::SamplingOptions options;
  options.tolerance = (mesh ? kSamplingShare : kSamplingShareWithoutTime) * plan.relative;
  options.absolute = outputs.floors;
  options.max_calls = std::max(1L, max_calls);
  // The whole grid of two coordinates may be that large; crosses of more would rather need other ranks.
  if (coordinates.size() <= 2) options.max_nodes = pgd::kMostLejaPoints;
  if (plan.builder.max_nodes) options.max_nodes = std::min(*plan.builder.max_nodes, pgd::kMostLejaPoints);
  options.max_rank = plan.builder.max_rank.value_or(options.max_rank);
  options.exploration_points = plan.builder.guards.value_or(options.exploration_points);
  options.seed = plan.builder.seed;
  options.progress = progress;
  options.challenge = challenge;
  const auto function = [&](const Eigen::MatrixXd& points, Eigen::MatrixXd& values) {
    CalledAnswers answered = calls(points, outputs.times);
    if (!answered.failure.empty()) throw Error(answered.failure);
    values = std::move(answered.values);
  };
  return pgd::sample(coordinates, outputs.labels, function, options);
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

/// Points of the box, each at some time.
Eigen::MatrixXd with_times(const Eigen::MatrixXd& points, const std::optional<TimeMesh>& mesh,
                           std::uint64_t seed) {
  if (!mesh) return points;
  pgd::Random random(seed);
  Eigen::MatrixXd result(points.rows() + 1, points.cols());
  for (double& t : result.row(0)) t = mesh->axis.lower() + mesh->axis.length() * random.uniform();
  result.bottomRows(points.rows()) = points;
  return result;
}

/// @param refuted how often a certificate has found such a field wrong: each time half as much is left out
pgd::RoundedField rounded_field(const pgd::SamplingResult& result, const Plan& plan,
                                const SampledSource& source, const std::optional<TimeMesh>& mesh,
                                int refuted) {
  const pgd::TrainField field = mesh ? with_time(*result.field, mesh->axis, source.outputs) : *result.field;
  const double of_cross = mesh ? kSamplingShare : kSamplingShareWithoutTime;
  const double share =
      kRoundingShare * plan.relative + std::max(0.0, of_cross * plan.relative - result.error);
  return pgd::rounded(field, mesh ? mesh->scale : result.scale, std::ldexp(share, -refuted),
                      plan.builder.seed, with_times(result.pivots, mesh, plan.builder.seed));
}

Termination status_of(const pgd::SamplingResult& result, bool mesh_is_resolved) {
  if (!result.tolerance_met()) return result.status;
  return mesh_is_resolved ? Termination::converged : Termination::not_resolved;
}

std::string described(const TimeMesh& mesh, long pilots, double tolerance) {
  return fmt::format("; {} elements of time by {} calls of pilots, interpolation error {:.3g}{}",
                     mesh.axis.elements(), pilots, mesh.error,
                     mesh.resolved ? "" : fmt::format(" > {:.3g}", tolerance));
}

Outcome<Solution> solve(const Plan& plan, CallMemory& calls, long max_calls, const ProgressCallback& progress,
                        const CertifyClaim& certify_claim) {
  BuildRecord record;
  record.builder = "sampling";
  record.strategy = "cross";
  std::optional<TimeMesh> mesh;
  long pilots = 0;
  if (plan.end > 0.0) {
    Outcome<PilotedMesh> piloted = mesh_by_pilots(plan, calls, max_calls, progress);
    if (!piloted) return piloted.ending();
    mesh.emplace(std::move(piloted->mesh));
    pilots = piloted->calls;
  }
  std::optional<pgd::RoundedField> claimed;
  std::optional<Certificate> certificate;
  int refuted = 0;
  const SamplingChallenge challenge = [&](const pgd::SamplingResult& claim) {
    claimed = rounded_field(claim, plan, calls.source(), mesh, refuted);
    Measured measured = certify_claim(Piece{{claimed->field}}, static_cast<double>(pilots + claim.calls));
    certificate = std::move(measured.certificate);
    ++refuted;
    return measured.wrong;
  };
  // What is not resolved in time is missed, however well the cross follows it.
  const pgd::SamplingResult result = sample_calls(plan, calls, mesh, max_calls - pilots, progress,
                                                  !mesh || mesh->resolved ? challenge : SamplingChallenge());
  record.evaluations = static_cast<double>(pilots + result.calls);
  record.grid_size = result.grid_size;
  record.rounds = static_cast<int>(result.history.size());
  record.status = status_of(result, !mesh || mesh->resolved);
  record.message = result.message;
  if (mesh) record.message += described(*mesh, pilots, kTimeShare * plan.relative);
  if (!result.field) return Ending{record.status, record.message};
  const bool is_certified = result.tolerance_met() && claimed;
  pgd::RoundedField field =
      is_certified ? std::move(*claimed) : rounded_field(result, plan, calls.source(), mesh, refuted);
  record.message +=
      fmt::format("; rounded from {} numbers to {}", result.field->entries(), field.field.entries());
  const ErrorBudget spent{.discretisation = mesh ? mesh->error : 0.0,
                          .compression = result.error + field.error};
  if (!is_certified) certificate.reset();
  return Solution{{Piece{{std::move(field.field)}}}, std::move(record), spent, std::move(certificate)};
}

}  // namespace

CallMemory calls_of(const Plan& plan, SampledSource source, const BuildOptions& options) {
  Checkpoint checkpoint(options.checkpoint, plan.whole_text());
  std::vector<CallSheet> known;
  if (options.resume && is_checkpoint(options.checkpoint)) known = checkpoint.calls();
  CallMemory::Save save;
  if (!options.checkpoint.empty()) {
    save = told_once<std::vector<CallSheet>>(
        [checkpoint](const std::vector<CallSheet>& calls) mutable { checkpoint.save_calls(calls); },
        options.warning);
  }
  try {
    return CallMemory(std::move(source), std::move(known), std::move(save));
  } catch (const ArgumentError& error) {
    throw bad_checkpoint(options.checkpoint, error.what());
  }
}

Outcome<Solution> solve_by_sampling(const Plan& plan, CallMemory& calls, long max_calls,
                                    const ProgressCallback& progress, const CertifyClaim& certify_claim) {
  try {
    Outcome<Solution> solution = solve(plan, calls, max_calls, progress, certify_claim);
    calls.save();
    return solution;
  } catch (const NoResultError&) {
    calls.save();
    throw;
  }
}

}  // namespace samara::codebooks
