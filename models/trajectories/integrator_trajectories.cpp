#include "samara/models/trajectories/integrator_trajectories.h"

#include <algorithm>
#include <utility>

#include "samara/base/errors.h"
#include "samara/models/integrators/lie_group_model.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/trajectories/derived_outputs.h"
#include "samara/models/trajectories/model_family.h"

namespace samara::models {

namespace {

/// One integration answers for values and derivatives at the same point: a fit asks for both, one after the
/// other, and both must be of the same trajectory to the last bit, or the last steps of a fit stall.
class ReferenceSource final : public TrajectorySource {
 public:
  ReferenceSource(const ParametricModel& model, const IntegrateOptions& options,
                  const std::vector<double>& times, std::vector<int> states)
      : integrator_(model, options, true),
        coordinates_(static_cast<std::size_t>(model.free_count())),
        times_(times),
        states_(std::move(states)) {}

  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    check_point(q, coordinates_);
    if (!is_known_ || !std::ranges::equal(q, q_)) {
      is_known_ = false;
      trajectory_ = integrator_(q, times_);
      q_.assign(q.begin(), q.end());
      is_known_ = true;
    }
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
    return outcome_of(trajectory_);
  }

 private:
  Integrator integrator_;
  std::size_t coordinates_;
  std::vector<double> times_;
  std::vector<int> states_;
  std::vector<double> q_;  ///< of trajectory_
  bool is_known_ = false;
  Trajectory trajectory_;
};

class ReferenceTrajectories final : public ModelFamily {
 public:
  ReferenceTrajectories(std::shared_ptr<const Model> model, const std::map<std::string, double>& fixed,
                        const std::map<std::string, Interval>& box, const IntegrateOptions& options)
      : ModelFamily(std::move(model), fixed, box, "reference integrator"), options_(options) {}

  using TrajectoryFamily::at;
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    check_times(times);
    return std::make_unique<ReferenceSource>(model(), options_, times, state_indices(outputs));
  }

 private:
  IntegrateOptions options_;
};

/// @tparam Integrator of q and times, to a Trajectory without sensitivities
template <class Integrator>
class ValuesSource final : public TrajectorySource {
 public:
  template <class Options>
  ValuesSource(const ParametricModel& model, const Options& options, const std::vector<double>& times,
               std::vector<int> states)
      : integrator_(model, options),
        coordinates_(static_cast<std::size_t>(model.free_count())),
        times_(times),
        states_(std::move(states)) {}

  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    if (derivatives != nullptr && coordinates_ > 0) {
      throw ArgumentError("derivatives were asked for; this integrator has values only");
    }
    check_point(q, coordinates_);
    const Trajectory trajectory = integrator_(q, times_);
    for (std::size_t o = 0; o < states_.size(); ++o) {
      values.col(static_cast<Eigen::Index>(o)) = trajectory.states.col(states_[o]);
    }
    return outcome_of(trajectory);
  }

 private:
  Integrator integrator_;
  std::size_t coordinates_;
  std::vector<double> times_;
  std::vector<int> states_;
};

template <class Integrator, class Options>
class ValuesTrajectories final : public ModelFamily {
 public:
  ValuesTrajectories(std::shared_ptr<const Model> model, const std::map<std::string, double>& fixed,
                     const std::map<std::string, Interval>& box, const std::string& source,
                     const Options& options)
      : ModelFamily(std::move(model), fixed, box, source), options_(options) {
    mutable_info().has_derivatives = false;
    const Integrator refuses_its_options(this->model(), options);
  }

  using TrajectoryFamily::at;
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    check_times(times);
    return std::make_unique<ValuesSource<Integrator>>(model(), options_, times, state_indices(outputs));
  }

 private:
  Options options_;
};

std::unique_ptr<TrajectoryFamily> of_states(std::shared_ptr<const Model> model,
                                            const std::map<std::string, double>& fixed,
                                            const std::map<std::string, Interval>& box,
                                            const IntegratorChoice& integrator) {
  if (const auto* adaptive = std::get_if<AdaptiveOptions>(&integrator)) {
    return std::make_unique<ValuesTrajectories<AdaptiveIntegrator, AdaptiveOptions>>(
        std::move(model), fixed, box, "adaptive integrator", *adaptive);
  }
  if (const auto* rk4 = std::get_if<Rk4Options>(&integrator)) {
    return std::make_unique<ValuesTrajectories<Rk4Integrator, Rk4Options>>(std::move(model), fixed, box,
                                                                           "Runge-Kutta steps", *rk4);
  }
  if (const auto* rkmk = std::get_if<RkmkOptions>(&integrator)) {
    return std::make_unique<ValuesTrajectories<RkmkIntegrator, RkmkOptions>>(
        std::move(model), fixed, box, "Runge-Kutta-Munthe-Kaas steps", *rkmk);
  }
  if (const auto* on_group = std::get_if<LieGroupOptions>(&integrator)) {
    return std::make_unique<ValuesTrajectories<LieGroupModelIntegrator, LieGroupOptions>>(
        std::move(model), fixed, box, "steps on the group of rigid motions", *on_group);
  }
  return std::make_unique<ReferenceTrajectories>(std::move(model), fixed, box,
                                                 std::get<IntegrateOptions>(integrator));
}

}  // namespace

std::unique_ptr<TrajectoryFamily> integrator_trajectories(std::shared_ptr<const Model> model,
                                                          const std::map<std::string, double>& fixed,
                                                          const std::map<std::string, Interval>& box,
                                                          const IntegratorChoice& integrator) {
  return with_derived_outputs(of_states(std::move(model), fixed, box, integrator));
}

}  // namespace samara::models
