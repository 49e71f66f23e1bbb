#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "samara/base/progress.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/codebooks/plan/plan.h"
#include "samara/pgd/sampling/sampling.h"

/// Builds the codebook of a plan, by the PGD engine, which integrates no trajectory, or by sampling
/// trajectories, and then certifies it against one integrator on points that the builder did not see. A
/// command is sampled, and certified against itself. Only the command of the plan given is ever run: nothing
/// that stands in a codebook or a checkpoint is.
///
/// Usage:
///   const BuildResult result = build(read_plan("coin.toml"));
///   if (!result.met) warn(result.message);
///   save(result.book, "coin.h5");
namespace samara::codebooks {

struct BuildOptions {
  std::optional<int> certificate_points = {};  ///< instead of Plan::certificate_points()
  /// Where to keep the engine's state between rounds and the calls of sampling; empty: nowhere. The file is
  /// removed when the build is done; one that was cancelled leaves it, and one whose command failed.
  std::filesystem::path checkpoint = {};
  /// Leave the checkpoint of a build that is done, too: for a caller that removes it when the codebook is
  /// saved.
  bool keep_checkpoint = false;
  /// Go on from the checkpoint if there is one. The result equals that of an undisturbed build except its
  /// provenance; calls that it holds are not made again.
  bool resume = false;
  ProgressCallback progress = {};
  /// Told in one sentence, once, what went wrong beside the build: a checkpoint that cannot be written.
  std::function<void(const std::string&)> warning = {};
};

struct BuildResult {
  Codebook book;        ///< always valid, marked by its certificate if it missed the tolerance
  bool met = false;     ///< the certificate's word
  std::string message;  ///< one sentence with the numbers
  /// Whether another build may go on where this one was stopped, by the caller or by a command that failed.
  bool resumable = false;
};

/// @throws ArgumentError as Plan::parametric_model(); InputError for a checkpoint that is broken or of
/// another plan, and for another file in its place; NoResultError if a command fails, or may not be called
/// often enough, before there is any result, or printed more than it was asked for.
BuildResult build(const Plan& plan, const BuildOptions& options = {});

/// The codebook of a model of your own, or any other, with its coordinates as they are fixed and free:
///
///   BuildRequest request;
///   request.box = {{.name = "growth", .lower = 0.8, .upper = 1.2}};
///   request.end = 15.0;
///   const BuildResult result = build(ParametricModel(model, {{"hunt", 0.1}}, {"growth"}), request);
///
/// @throws ArgumentError as make_plan(), and as above
BuildResult build(const models::ParametricModel& model, const BuildRequest& request,
                  const BuildOptions& options = {});

/// The same of a plan with a command, where a function answers instead of the program: in its columns stand
/// the inputs of [command] in order and the times, if the plan has any; outputs come first, then times.
/// @throws ArgumentError if the plan has no command, or the function is empty
BuildResult build(const Plan& plan, const pgd::PointsFunction& function, const BuildOptions& options = {});

}  // namespace samara::codebooks
