#pragma once

#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/fields/error_scale.h"
#include "samara/pgd/fields/separated_field.h"

/// What errors of a model's states are measured in, and how well trajectories must be integrated for that.
namespace samara::codebooks {

/// Per output its absolute tolerance, 0 where there is none.
Eigen::VectorXd floors_of(const std::map<std::string, double>& absolute,
                          const std::vector<pgd::OutputLabel>& outputs);

/// The characteristic sizes of the model's states, 0 where nothing says one. @param q free coordinates
Eigen::VectorXd state_sizes(const models::ParametricModel& model, const Eigen::VectorXd& q);

/// Factor for the integrator's tolerance, which is relative to the sizes of the states, so that it counts by what
/// errors are divided by: the least ratio of the two, from some trajectories to `end`; 1 where no range is less than a
/// tenth of its state's size. @param points free coordinates x points
double share_for_range(const models::ParametricModel& model, const Eigen::MatrixXd& points, double end,
                       const pgd::OutputMeasure& measure);

}  // namespace samara::codebooks
