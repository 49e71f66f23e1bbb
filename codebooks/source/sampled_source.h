#pragma once

#include <functional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/codebooks/plan/plan.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/axes/axis.h"
#include "samara/pgd/fields/error_scale.h"
#include "samara/pgd/fields/separated_field.h"
#include "samara/pgd/sampling/sampling.h"

namespace samara::codebooks {

/// What a source says at some points.
struct SampledAnswers {
  /// A column for every point before the first that failed: outputs fastest, then times.
  Eigen::MatrixXd values;
  std::string failure;  ///< why the point after the last column has no answer; empty: all have one
};

/// What a build by sampling calls: the trajectories of a model, or a command.
struct SampledSource {
  std::vector<pgd::Axis::Label> coordinates;  ///< of the box, in its order
  std::vector<pgd::OutputLabel> outputs;
  pgd::OutputMeasure measure;  ///< the plan's absolute tolerances, and what a model says of its states
  std::string time_unit = "s";
  std::string answers_name;  ///< what it gives, for messages: "trajectory"
  /// At points (coordinates x points) and times, which are empty where there is no time.
  std::function<SampledAnswers(const Eigen::MatrixXd& points, const std::vector<double>& times)> answers;
  /// Ends what answers. @throws Error if its answers cannot be relied on after all
  std::function<void()> finish = [] {};
  int batch = 1;  ///< most points that are asked for at a time
  /// How long an answer to so many may take: no more points are asked for than the last ones let expect.
  double batch_seconds = 10.0;
};

/// Trajectories of the reference integrator, by the plan's number of threads. The model must outlive it.
SampledSource model_source(const Plan& plan, const models::ParametricModel& model);

/// The plan's command, fixed inputs included. @param function answers instead of the program, from the
/// columns that would be its lines; empty: the program does
SampledSource command_source(const Plan& plan, const pgd::PointsFunction& function = {});

}  // namespace samara::codebooks
