#include "samara/identification/trajectories/reference_trajectories.h"

#include <algorithm>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/certify/certify.h"
#include "samara/identification/trajectories/model_family.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"

namespace samara::identification {

namespace {

/// One integration answers for values and derivatives at the same point: a fit asks for both, one after the
/// other, and both must be of the same trajectory to the last bit, or the last steps of a fit stall.
class ReferenceSource final : public TrajectorySource {
 public:
  ReferenceSource(const models::ParametricModel& model, const models::IntegrateOptions& options,
                  const std::vector<double>& times, std::vector<int> states)
      : integrator_(model, options, true), times_(times), states_(std::move(states)) {}

  bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) override {
    if (!std::ranges::equal(q, q_)) {
      trajectory_ = integrator_(q, times_);
      q_.assign(q.begin(), q.end());
    }
    if (!trajectory_.is_usable()) return false;
    const auto outputs = static_cast<Eigen::Index>(states_.size());
    for (Eigen::Index o = 0; o < outputs; ++o) {
      const int state = states_[static_cast<std::size_t>(o)];
      values.col(o) = trajectory_.states.col(state);
      if (!derivatives) continue;
      for (std::size_t k = 0; k < trajectory_.sensitivities.size(); ++k) {
        derivatives->col(o + outputs * static_cast<Eigen::Index>(k)) =
            trajectory_.sensitivities[k].col(state);
      }
    }
    return true;
  }

 private:
  models::Integrator integrator_;
  std::vector<double> times_;
  std::vector<int> states_;
  std::vector<double> q_;  // of trajectory_; empty before the first
  models::Trajectory trajectory_;
};

class ReferenceTrajectories final : public ModelFamily {
 public:
  ReferenceTrajectories(std::shared_ptr<const models::Model> model,
                        const std::map<std::string, double>& fixed,
                        const std::map<std::string, Interval>& box, const models::IntegrateOptions& options)
      : ModelFamily(std::move(model), fixed, box, "reference integrator"), options_(options) {}

  using TrajectoryFamily::at;
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    return std::make_unique<ReferenceSource>(model(), options_, times, state_indices(outputs));
  }

 private:
  models::IntegrateOptions options_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> reference_trajectories(std::shared_ptr<const models::Model> model,
                                                         const std::map<std::string, double>& fixed,
                                                         const std::map<std::string, Interval>& box,
                                                         const models::IntegrateOptions& options) {
  return std::make_unique<ReferenceTrajectories>(std::move(model), fixed, box, options);
}

std::unique_ptr<TrajectoryFamily> reference_trajectories(const codebooks::Codebook& book,
                                                         const models::IntegrateOptions& options) {
  codebooks::model_of(book);  // a command has none, and is told apart from an unknown model
  std::map<std::string, Interval> box;
  for (const codebooks::Coordinate& c : book.coordinates()) {
    if (c.role != pgd::AxisRole::time) box[c.name] = {c.lower, c.upper};
  }
  return reference_trajectories(models::find_model(book.model().name), book.model().fixed, box, options);
}

}  // namespace samara::identification
