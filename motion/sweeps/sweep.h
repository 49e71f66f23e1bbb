#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/models/batch/batch.h"
#include "samara/motion/patterns/pattern_rules.h"
#include "samara/motion/sweeps/sweep_plan.h"

namespace samara::motion {

/// How a fall ended.
enum class FallStatus { done, landed, not_finite, too_many_steps, cancelled, inherited };
std::string to_string(FallStatus status);

/// A sweep before its first round of refining, and after each.
struct RefiningRound {
  Eigen::Index points = 0;
  Eigen::Index run = 0;  ///< of them; the others inherited their labels
  /// Share of the points that came first of which the others that were run tell the pattern, of the release where they
  /// do so worst: later ones crowd at borders, and those that inherited have what their neighbours have.
  double agreement = 0.0;
};

/// What a sweep found. Falls are numbered point after point, each from all releases.
struct Sweep {
  std::string model;
  std::string generator;  ///< the program that ran it, with its version
  /// Equations, parameters and initial values of the model: by them another of its name is known.
  std::string model_text;
  std::string plan_text;
  std::vector<std::string> names, units;  ///< of the coordinates of points
  std::vector<std::vector<double>> axes;  ///< values of a grid; empty: points were drawn
  Eigen::VectorXd lower, upper;           ///< of the box
  Eigen::MatrixXd points;                 ///< points x coordinates, SI
  std::vector<Release> releases;          ///< none: the model's own initial values
  PatternThresholds thresholds;

  std::vector<Features> features;  ///< per fall
  std::vector<PatternLabel> labels;
  std::vector<FallStatus> status;
  Eigen::VectorXd reached;  ///< s, per fall
  /// Falls x (x, y, t) [m, m, s] at the height of the plan below the release; NaN where it did not come there.
  Eigen::MatrixX3d landing;
  /// Times of frames, and of each fall its states (frames x states); empty unless the plan keeps them.
  Eigen::VectorXd times;
  std::vector<Eigen::MatrixXd> trajectories;
  std::vector<std::string> state_names;

  /// Per point the round of refining that it came with, 0 for those of the plan; empty: an older file does not say it.
  std::vector<int> round_of_point;
  /// What refine_by_plan() (refining.h) has done so far; empty: it was not refined by it.
  std::vector<RefiningRound> rounds;

  Eigen::Index release_count() const {
    return releases.empty() ? 1 : static_cast<Eigen::Index>(releases.size());
  }
  Eigen::Index fall_count() const { return static_cast<Eigen::Index>(labels.size()); }
  /// Falls that were run; the others inherited their labels, see refining.h.
  Eigen::Index run_count() const;
  Eigen::Index point_of(Eigen::Index fall) const { return fall / release_count(); }
  Eigen::Index release_of(Eigen::Index fall) const { return fall % release_count(); }
  /// Falls per pattern, in the order of pattern_names(), of one release or (-1) of all.
  std::vector<int> counts(Eigen::Index release = -1) const;
};

struct SweepOptions {
  int threads = 0;  ///< 0: as many as the machine has
  ProgressCallback progress = {};
  /// Where finished falls are kept while the sweep runs, and taken up again if there are any of the same plan; it is
  /// removed when all is done. Empty: nowhere.
  std::filesystem::path checkpoint = {};
  /// Leave the checkpoint of a sweep that is done, too: for a caller that removes it when the result is written.
  bool keep_checkpoint = false;
  /// Told in one sentence, once, if the checkpoint cannot be written.
  std::function<void(const std::string&)> warning = {};
};

struct SweepResult {
  Sweep sweep;
  bool complete = false;
  Eigen::Index falls_done = 0;
  Eigen::Index taken_up = 0;  ///< falls that came from the checkpoint
  double seconds = 0.0;
  std::string message = "not run";
};

/// Runs all falls, each in a lane of models/batch/watch_batch.h; a fall's frames are kept until its features are known.
/// Finished falls are the same to the bit whether or not the sweep was interrupted, and on any number of threads. A
/// checkpoint that was refined (refining.h) comes back as it is, complete.
/// @throws ArgumentError as the model and watch_batch do; InputError for a checkpoint of another plan, model or
/// version, and for another file in its place, also if it is a sweep that is finished.
SweepResult run_sweep(const SweepPlan& plan, const SweepOptions& options = {});

/// Falls of a plan at other points than its own, without a checkpoint: appended to `sweep`, which is one of that plan.
/// @returns false if cancelled; then nothing was appended
bool append_falls(const SweepPlan& plan, const Eigen::MatrixXd& points, const SweepOptions& options,
                  Sweep& sweep);

/// Equations, parameters and initial values: what makes a model another one of the same name.
std::string model_text(const models::ModelInfo& info);

/// A sweep of the plan without any falls.
Sweep empty_sweep(const SweepPlan& plan);

}  // namespace samara::motion
