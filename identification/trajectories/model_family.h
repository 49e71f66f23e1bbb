#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "samara/identification/trajectories/interval.h"
#include "samara/identification/trajectories/trajectory_source.h"
#include "samara/models/interface/parametric_model.h"

/// Internal to identification/.
namespace samara::identification {

/// A family that integrates a model: what all of them have in common. Its outputs are the states.
class ModelFamily : public TrajectoryFamily {
 public:
  const FamilyInfo& info() const override { return info_; }
  const models::ParametricModel* equations() const override { return &model_; }

 protected:
  /// @param fixed, box as reference_trajectories()
  /// @param source as FamilyInfo
  /// @throws ArgumentError as reference_trajectories()
  ModelFamily(std::shared_ptr<const models::Model> model, const std::map<std::string, double>& fixed,
              const std::map<std::string, Interval>& box, const std::string& source);

  const models::ParametricModel& model() const { return model_; }
  /// @throws ArgumentError for an output that is no state.
  std::vector<int> state_indices(const std::vector<std::string>& outputs) const;

 private:
  models::ParametricModel model_;
  FamilyInfo info_;
};

}  // namespace samara::identification
