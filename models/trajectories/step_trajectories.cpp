#include "samara/models/trajectories/step_trajectories.h"

#include <numeric>

#include "samara/models/batch/batch.h"
#include "samara/models/batch/rk4_frames.h"
#include "samara/models/integrators/trajectory_tools.h"
#include "samara/models/trajectories/derived_outputs.h"
#include "samara/models/trajectories/model_family.h"

namespace samara::models {

namespace {

class StepSource final : public TrajectorySource {
 public:
  StepSource(const ParametricModel& model, const std::vector<double>& times, Rk4Frames::Options options)
      : coordinates_(static_cast<std::size_t>(model.free_count())),
        wanted_(options.directions),
        outputs_(static_cast<Eigen::Index>(options.states.size())),
        frames_(model, times, std::move(options)) {
    derivatives_.setZero(static_cast<Eigen::Index>(times.size()),
                         outputs_ * static_cast<Eigen::Index>(wanted_.size()));
  }

  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    check_point(q, coordinates_);
    if (!frames_(q, values, derivatives ? &derivatives_ : nullptr)) {
      return {TrajectoryStatus::not_integrated, "a state was not finite at one of the times"};
    }
    for (std::size_t k = 0; derivatives && k < wanted_.size(); ++k) {
      derivatives->middleCols(outputs_ * wanted_[k], outputs_) =
          derivatives_.middleCols(outputs_ * static_cast<Eigen::Index>(k), outputs_);
    }
    return {};
  }

 private:
  std::size_t coordinates_;
  std::vector<int> wanted_;
  Eigen::Index outputs_;
  Rk4Frames frames_;
  Eigen::MatrixXd derivatives_;  ///< by what is wanted, without gaps
};

/// A source at more times than are asked for: every `parts`th row counts.
class PartedSource final : public TrajectorySource {
 public:
  PartedSource(std::unique_ptr<TrajectorySource> source, Eigen::Index parts)
      : source_(std::move(source)), parts_(parts) {}

  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    values_.resize(parts_ * values.rows(), values.cols());
    if (derivatives) derivatives_.setZero(parts_ * derivatives->rows(), derivatives->cols());
    TrajectoryOutcome outcome = source_->evaluate(q, values_, derivatives ? &derivatives_ : nullptr);
    if (!outcome) return outcome;
    pick(values_, values);
    if (derivatives) pick(derivatives_, *derivatives);
    return outcome;
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
  StepTrajectories(const std::shared_ptr<const Model>& model, const std::map<std::string, double>& fixed,
                   const std::map<std::string, Interval>& box, double step, int parts = 1)
      : ModelFamily(model, fixed, box, "Runge-Kutta steps"),
        model_(model),
        fixed_(fixed),
        box_(box),
        step_(step),
        parts_(parts) {
    check_step(step);
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
        Rk4Frames::Options{.step = step_, .states = state_indices(outputs), .directions = wanted});
    if (parts_ == 1) return source;
    return std::make_unique<PartedSource>(std::move(source), parts_);
  }

  /// Several trajectories side by side in the lanes of SIMD registers (batch/batch.h).
  FamilyBatch batch(const Eigen::Ref<const Eigen::MatrixXd>& points, const std::vector<double>& times,
                    const std::vector<std::string>& outputs,
                    const FamilyBatchOptions& options) const override;

  /// Between two times there are as many steps as the bound on their length asks for, and at least one: to
  /// halve them, the intervals must be halved as well.
  std::unique_ptr<TrajectoryFamily> finer() const override {
    return std::make_unique<StepTrajectories>(model_, fixed_, box_, 0.5 * step_, 2 * parts_);
  }

 private:
  std::shared_ptr<const Model> model_;
  std::map<std::string, double> fixed_;
  std::map<std::string, Interval> box_;
  double step_;
  int parts_;
};

/// Rows of one trajectory of a batch, for the states wanted: every `parts`th time counts.
Eigen::MatrixXd rows_of(const BatchTrajectories& batch, const Eigen::MatrixXd& columns,
                        Eigen::Index trajectory, const std::vector<int>& states, Eigen::Index parts) {
  Eigen::MatrixXd rows(batch.times.size() / parts, static_cast<Eigen::Index>(states.size()));
  for (Eigen::Index row = 0; row < rows.rows(); ++row) {
    const Eigen::Index column = batch.column(trajectory, parts * (row + 1) - 1);
    for (Eigen::Index o = 0; o < rows.cols(); ++o) {
      rows(row, o) = columns(states[static_cast<std::size_t>(o)], column);
    }
  }
  return rows;
}

FamilyBatch StepTrajectories::batch(const Eigen::Ref<const Eigen::MatrixXd>& points,
                                    const std::vector<double>& times, const std::vector<std::string>& outputs,
                                    const FamilyBatchOptions& options) const {
  const std::vector<int> states = state_indices(outputs);
  BatchOptions batch_options{.step = step_, .threads = options.threads};
  if (options.derivatives == Derivatives::yes) {
    for (const FamilyCoordinate& c : info().coordinates) batch_options.tangents.push_back(c.name);
  }
  const BatchTrajectories all = integrate_batch(model(), points, parted(times, parts_), batch_options);
  FamilyBatch result;
  for (Eigen::Index n = 0; n < points.rows(); ++n) {
    const BatchStatus status = all.status[static_cast<std::size_t>(n)];
    TrajectoryOutcome outcome;
    if (status != BatchStatus::done) {
      outcome = {TrajectoryStatus::not_integrated,
                 status == BatchStatus::too_many_steps ? "the times take more steps than allowed"
                                                       : "a state was not finite at one of the times",
                 times.empty() || !(all.reached[n] >= times.front()) ? -1.0 : all.reached[n]};
    }
    result.outcomes.push_back(std::move(outcome));
    result.values.push_back(rows_of(all, all.states, n, states, parts_));
    if (options.derivatives == Derivatives::no) continue;
    const auto width = static_cast<Eigen::Index>(states.size());
    Eigen::MatrixXd& by_q = result.derivatives.emplace_back(static_cast<Eigen::Index>(times.size()),
                                                            width * std::ssize(all.tangents));
    for (std::size_t k = 0; k < all.tangents.size(); ++k) {
      by_q.middleCols(width * static_cast<Eigen::Index>(k), width) =
          rows_of(all, all.tangents[k], n, states, parts_);
    }
  }
  return result;
}

}  // namespace

std::unique_ptr<TrajectoryFamily> step_trajectories(std::shared_ptr<const Model> model,
                                                    const std::map<std::string, double>& fixed,
                                                    const std::map<std::string, Interval>& box, double step) {
  require_free_coordinates(box);
  return with_derived_outputs(std::make_unique<StepTrajectories>(model, fixed, box, step));
}

}  // namespace samara::models
