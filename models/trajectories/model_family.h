#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "samara/models/integrators/integrate.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// Internal to models/.
namespace samara::models {

/// @throws ArgumentError if the box is empty.
void require_free_coordinates(const std::map<std::string, Interval>& box);

/// The outcome an integration has as a trajectory of a family.
TrajectoryOutcome outcome_of(const Trajectory& trajectory);

/// A family that integrates a model: what all of them have in common. Its outputs are the states.
class ModelFamily : public TrajectoryFamily {
 public:
  const FamilyInfo& info() const override { return info_; }
  const ParametricModel* equations() const override { return &model_; }

 protected:
  /// @param fixed, box as reference_trajectories(); the box may be empty
  /// @param source as FamilyInfo
  /// @throws ArgumentError as reference_trajectories(), but for an empty box
  ModelFamily(std::shared_ptr<const Model> model, const std::map<std::string, double>& fixed,
              const std::map<std::string, Interval>& box, const std::string& source);

  const ParametricModel& model() const { return model_; }
  FamilyInfo& mutable_info() { return info_; }
  /// @throws ArgumentError for an output that is no state.
  std::vector<int> state_indices(const std::vector<std::string>& outputs) const;

 private:
  ParametricModel model_;
  FamilyInfo info_;
};

}  // namespace samara::models
