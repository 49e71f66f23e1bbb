#include "samara/identification/reference_trajectories.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/codebooks/certify.h"
#include "samara/identification/model_symmetry.h"
#include "samara/models/parametric_model.h"

namespace samara::identification {

namespace {

std::vector<std::string> names_of(const std::map<std::string, Interval>& box) {
  std::vector<std::string> names;
  for (const auto& [name, interval] : box) names.push_back(name);
  return names;
}

void check_box(const models::ParametricModel& model, const std::map<std::string, Interval>& box) {
  if (box.empty()) throw ArgumentError("the box is empty; at least one free coordinate was expected");
  std::vector<double> lower;
  std::vector<double> upper;
  for (const auto& [name, interval] : box) {
    if (!(interval.width() > 0.0)) {
      throw ArgumentError(
          fmt::format("the box of \"{}\" goes from {} to {}; an interval with a length was expected", name,
                      interval.lower, interval.upper));
    }
    lower.push_back(interval.lower);
    upper.push_back(interval.upper);
  }
  model.check(lower);
  model.check(upper);
}

FamilyInfo describe(const models::ParametricModel& model, const std::map<std::string, Interval>& box) {
  const models::ModelInfo& m = model.model().info();
  FamilyInfo info{.model = m.name, .source = "reference integrator", .fixed = model.fixed()};
  for (const models::FreeCoordinate& c : model.free()) {
    const Interval& interval = box.at(c.name);
    info.coordinates.push_back({c.name, c.unit, c.is_initial, interval.lower, interval.upper});
  }
  for (const models::StateInfo& state : m.states) info.outputs.push_back({state.name, state.unit});
  info.translations = translated_outputs(m, info.outputs);
  return info;
}

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

class ReferenceTrajectories final : public TrajectoryFamily {
 public:
  ReferenceTrajectories(models::ParametricModel model, const std::map<std::string, Interval>& box,
                        const models::IntegrateOptions& options)
      : model_(std::move(model)), options_(options), info_(describe(model_, box)) {}

  const FamilyInfo& info() const override { return info_; }
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    std::vector<int> states;
    for (const std::string& output : outputs) states.push_back(state_index(output));
    return std::make_unique<ReferenceSource>(model_, options_, times, std::move(states));
  }

 private:
  int state_index(const std::string& output) const {
    const auto found = std::ranges::find(info_.outputs, output, &FitOutput::name);
    if (found == info_.outputs.end()) {
      throw ArgumentError(fmt::format("model \"{}\" has no state \"{}\"", info_.model, output));
    }
    return static_cast<int>(found - info_.outputs.begin());
  }

  models::ParametricModel model_;
  models::IntegrateOptions options_;
  FamilyInfo info_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> reference_trajectories(std::shared_ptr<const models::Model> model,
                                                         const std::map<std::string, double>& fixed,
                                                         const std::map<std::string, Interval>& box,
                                                         const models::IntegrateOptions& options) {
  models::ParametricModel parametric(std::move(model), fixed, names_of(box));
  check_box(parametric, box);
  return std::make_unique<ReferenceTrajectories>(std::move(parametric), box, options);
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
