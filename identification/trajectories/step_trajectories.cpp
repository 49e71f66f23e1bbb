#include "samara/identification/trajectories/step_trajectories.h"

#include <numeric>

#include "samara/identification/trajectories/model_family.h"
#include "samara/models/batch/rk4_frames.h"
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

/// A source at more times than are asked for: every `parts`th row counts.
class PartedSource final : public TrajectorySource {
 public:
  PartedSource(std::unique_ptr<TrajectorySource> source, Eigen::Index parts)
      : source_(std::move(source)), parts_(parts) {}

  bool evaluate(std::span<const double> q, Eigen::MatrixXd& values, Eigen::MatrixXd* derivatives) override {
    values_.resize(parts_ * values.rows(), values.cols());
    if (derivatives) derivatives_.setZero(parts_ * derivatives->rows(), derivatives->cols());
    if (!source_->evaluate(q, values_, derivatives ? &derivatives_ : nullptr)) return false;
    pick(values_, values);
    if (derivatives) pick(derivatives_, *derivatives);
    return true;
  }

 private:
  void pick(const Eigen::MatrixXd& from, Eigen::MatrixXd& to) const {
    for (Eigen::Index row = 0; row < to.rows(); ++row) to.row(row) = from.row(parts_ * (row + 1) - 1);
  }

  std::unique_ptr<TrajectorySource> source_;
  Eigen::Index parts_;
  Eigen::MatrixXd values_, derivatives_;
};

/// Each interval between times, the one from 0 to the first among them, in equal parts.
std::vector<double> parted(const std::vector<double>& times, int parts) {
  std::vector<double> result;
  double begin = 0.0;
  for (const double end : times) {
    for (int k = 1; k < parts; ++k) result.push_back(begin + (end - begin) * k / parts);
    result.push_back(end);
    begin = end;
  }
  return result;
}

class StepTrajectories final : public ModelFamily {
 public:
  /// @param parts into which intervals between times are cut, each of at least one step
  StepTrajectories(const std::shared_ptr<const models::Model>& model,
                   const std::map<std::string, double>& fixed, const std::map<std::string, Interval>& box,
                   double step, int parts = 1)
      : ModelFamily(model, fixed, box, "Runge-Kutta steps"),
        model_(model),
        fixed_(fixed),
        box_(box),
        step_(step),
        parts_(parts) {
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
    auto source = std::make_unique<StepSource>(
        model(), parts_ > 1 ? parted(times, parts_) : times,
        models::Rk4Frames::Options{.step = step_, .states = state_indices(outputs), .directions = wanted});
    if (parts_ == 1) return source;
    return std::make_unique<PartedSource>(std::move(source), parts_);
  }

  /// Between two times there are as many steps as the bound on their length asks for, and at least one: to
  /// halve them, the intervals must be halved as well.
  std::unique_ptr<TrajectoryFamily> finer() const override {
    return std::make_unique<StepTrajectories>(model_, fixed_, box_, 0.5 * step_, 2 * parts_);
  }

 private:
  std::shared_ptr<const models::Model> model_;
  std::map<std::string, double> fixed_;
  std::map<std::string, Interval> box_;
  double step_;
  int parts_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> step_trajectories(std::shared_ptr<const models::Model> model,
                                                    const std::map<std::string, double>& fixed,
                                                    const std::map<std::string, Interval>& box, double step) {
  return std::make_unique<StepTrajectories>(model, fixed, box, step);
}

}  // namespace samara::identification
