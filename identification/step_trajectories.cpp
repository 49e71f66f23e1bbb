#include "samara/identification/step_trajectories.h"

#include <numeric>

#include "samara/identification/model_family.h"
#include "samara/models/integrators/rk4_frames.h"
#include "samara/models/integrators/trajectory_tools.h"

namespace samara::identification {

namespace {

class StepSource final : public TrajectorySource {
 public:
  StepSource(const models::ParametricModel& model, const std::vector<double>& times,
             models::Rk4Frames::Options options)
      : wanted_(options.directions),
        outputs_(static_cast<Eigen::Index>(options.states.size())),
        frames_(model, times, std::move(options)) {
    derivatives_.setZero(static_cast<Eigen::Index>(times.size()),
                         outputs_ * static_cast<Eigen::Index>(wanted_.size()));
  }

  bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) override {
    if (!frames_(q, values, derivatives ? &derivatives_ : nullptr)) return false;
    for (std::size_t k = 0; derivatives && k < wanted_.size(); ++k) {
      derivatives->middleCols(outputs_ * wanted_[k], outputs_) =
          derivatives_.middleCols(outputs_ * static_cast<Eigen::Index>(k), outputs_);
    }
    return true;
  }

 private:
  std::vector<int> wanted_;
  Eigen::Index outputs_;
  models::Rk4Frames frames_;
  Eigen::MatrixXd derivatives_;  ///< by what is wanted, without gaps
};

class StepTrajectories final : public ModelFamily {
 public:
  StepTrajectories(std::shared_ptr<const models::Model> model, const std::map<std::string, double>& fixed,
                   const std::map<std::string, Interval>& box, double step)
      : ModelFamily(std::move(model), fixed, box, "Runge-Kutta steps"), step_(step) {
    models::check_step(step);
  }

  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    std::vector<int> all(info().coordinates.size());
    std::iota(all.begin(), all.end(), 0);
    return at(times, outputs, all);
  }

  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs,
                                       const std::vector<int>& wanted) const override {
    return std::make_unique<StepSource>(
        model(), times,
        models::Rk4Frames::Options{.step = step_, .states = state_indices(outputs), .directions = wanted});
  }

 private:
  double step_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> step_trajectories(std::shared_ptr<const models::Model> model,
                                                    const std::map<std::string, double>& fixed,
                                                    const std::map<std::string, Interval>& box, double step) {
  return std::make_unique<StepTrajectories>(std::move(model), fixed, box, step);
}

}  // namespace samara::identification
