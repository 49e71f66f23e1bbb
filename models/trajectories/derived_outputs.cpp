#include "samara/models/trajectories/derived_outputs.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/models/equations/equation_model.h"
#include "samara/models/trajectories/model_symmetry.h"

namespace samara::models {

DerivedOutputs::DerivedOutputs(const ParametricModel& model) : model_(model) {
  const ModelInfo& info = model.model().info();
  const auto outputs = static_cast<Eigen::Index>(info.outputs.size());
  y_.resize(outputs);
  dy_dt_.resize(outputs);
  dy_dx_.resize(outputs, static_cast<Eigen::Index>(info.states.size()));
  dy_dp_.resize(outputs, static_cast<Eigen::Index>(info.parameters.size()));
}

void DerivedOutputs::set(std::span<const double> q) {
  model_.parameter_values(q, p_);
}

void DerivedOutputs::evaluate(double t, std::span<const double> x, std::span<double> y) const {
  model_.model().outputs(t, x, p_, y);
}

void DerivedOutputs::evaluate(double t, std::span<const double> x,
                              const Eigen::Ref<const Eigen::MatrixXd>& x_slopes,
                              std::span<const int> coordinates, std::span<double> y,
                              Eigen::Ref<Eigen::MatrixXd> y_slopes) {
  model_.model().outputs_with_derivatives(t, x, p_, y, dy_dt_, dy_dx_, dy_dp_);
  y_slopes.noalias() = dy_dx_ * x_slopes;
  for (std::size_t k = 0; k < coordinates.size(); ++k) {
    auto column = y_slopes.col(static_cast<Eigen::Index>(k));
    if (coordinates[k] < 0) {
      column += dy_dt_;
      continue;
    }
    const FreeCoordinate& free = model_.free()[static_cast<std::size_t>(coordinates[k])];
    if (!free.is_initial) column += dy_dp_.col(free.index);
  }
}

namespace {

/// Where an output comes from: a column of the states, or a number among the derived ones.
struct Place {
  bool is_derived = false;
  Eigen::Index index = 0;
};

class DerivedSource final : public TrajectorySource {
 public:
  /// @param states gives all states of the model, in its order
  DerivedSource(std::unique_ptr<TrajectorySource> states, const ParametricModel& model,
                std::vector<double> times, std::vector<Place> places)
      : states_(std::move(states)),
        derived_(model),
        times_(std::move(times)),
        places_(std::move(places)),
        coordinates_(model.free().size()),
        y_(static_cast<std::size_t>(derived_.count())),
        y_slopes_(derived_.count(), std::ssize(coordinates_)),
        x_slopes_(model.state_count(), std::ssize(coordinates_)),
        x_(static_cast<std::size_t>(model.state_count())),
        values_(std::ssize(times_), model.state_count()),
        derivatives_(std::ssize(times_), model.state_count() * std::ssize(coordinates_)) {
    std::iota(coordinates_.begin(), coordinates_.end(), 0);
  }

  TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                             Eigen::MatrixXd* derivatives) override {
    derived_.set(q);
    TrajectoryOutcome outcome = states_->evaluate(q, values_, derivatives ? &derivatives_ : nullptr);
    const Eigen::Index outputs = std::ssize(places_), states = values_.cols();
    for (Eigen::Index i = 0; i < values_.rows(); ++i) {
      const double t = times_[static_cast<std::size_t>(i)];
      for (Eigen::Index s = 0; s < states; ++s) x_[static_cast<std::size_t>(s)] = values_(i, s);
      if (derivatives) {
        for (Eigen::Index k = 0; k < x_slopes_.cols(); ++k)
          x_slopes_.col(k) = derivatives_.row(i).segment(states * k, states).transpose();
        derived_.evaluate(t, x_, x_slopes_, coordinates_, y_, y_slopes_);
      } else {
        derived_.evaluate(t, x_, y_);
      }
      for (Eigen::Index o = 0; o < outputs; ++o) {
        const auto [is_derived, index] = places_[static_cast<std::size_t>(o)];
        values(i, o) = is_derived ? y_[static_cast<std::size_t>(index)] : values_(i, index);
        if (!derivatives) continue;
        for (Eigen::Index k = 0; k < x_slopes_.cols(); ++k)
          (*derivatives)(i, o + outputs * k) = is_derived ? y_slopes_(index, k) : x_slopes_(index, k);
      }
    }
    return outcome;
  }

 private:
  std::unique_ptr<TrajectorySource> states_;
  DerivedOutputs derived_;
  std::vector<double> times_;
  std::vector<Place> places_;
  std::vector<int> coordinates_;
  std::vector<double> y_;
  Eigen::MatrixXd y_slopes_, x_slopes_;
  std::vector<double> x_;
  Eigen::MatrixXd values_, derivatives_;
};

class DerivedTrajectories final : public TrajectoryFamily {
 public:
  explicit DerivedTrajectories(std::unique_ptr<TrajectoryFamily> family)
      : family_(std::move(family)), info_(family_->info()) {
    for (const StateInfo& state : model().model().info().states) states_.push_back(state.name);
    for (const OutputInfo& output : model().model().info().outputs)
      info_.outputs.push_back({output.name, output.unit});
    info_.autonomous = info_.autonomous && !depends_on_time();
  }

  const FamilyInfo& info() const override { return info_; }
  const ParametricModel* equations() const override { return family_->equations(); }
  std::unique_ptr<TrajectoryFamily> finer() const override {
    std::unique_ptr<TrajectoryFamily> finer = family_->finer();
    return finer ? with_derived_outputs(std::move(finer)) : nullptr;
  }

  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs) const override {
    std::vector<int> all(info_.coordinates.size());
    std::iota(all.begin(), all.end(), 0);
    return at(times, outputs, all);
  }
  std::unique_ptr<TrajectorySource> at(const std::vector<double>& times,
                                       const std::vector<std::string>& outputs,
                                       const std::vector<int>& wanted) const override {
    if (!has_derived(outputs)) return family_->at(times, outputs, wanted);
    std::vector<Place> places;
    for (const std::string& output : outputs) places.push_back(place_of(output));
    return std::make_unique<DerivedSource>(family_->at(times, states_, wanted), model(), times,
                                           std::move(places));
  }

  FamilyBatch batch(const Eigen::Ref<const Eigen::MatrixXd>& points, const std::vector<double>& times,
                    const std::vector<std::string>& outputs,
                    const FamilyBatchOptions& options) const override {
    return has_derived(outputs) ? TrajectoryFamily::batch(points, times, outputs, options)
                                : family_->batch(points, times, outputs, options);
  }

 private:
  const ParametricModel& model() const { return *family_->equations(); }

  /// Whether an output changes with time while the states stay: then a part of a trajectory is none from 0 on.
  bool depends_on_time() const {
    // No times that are tried would meet a switch, or what acts for a moment.
    if (const Equations* const text = equations_of(model().model())) return outputs_mention_time(*text);
    const ModelInfo& info = model().model().info();
    std::vector<double> y(info.outputs.size());
    Eigen::VectorXd by_t(std::ssize(y));
    Eigen::MatrixXd by_x(std::ssize(y), std::ssize(info.states)),
        by_p(std::ssize(y), std::ssize(info.parameters));
    const std::vector<double> times = times_of_motion();
    for (const auto& [q, x] : points_of_motion(model(), info_.coordinates)) {
      const ParameterValues p = model().parameter_values(q);
      for (const double t : times) {
        model().model().outputs_with_derivatives(t, x, p, y, by_t, by_x, by_p);
        const auto changes = [](double rate) { return rate != 0.0 && !std::isnan(rate); };
        if (std::ranges::any_of(by_t, changes)) return true;
      }
    }
    return false;
  }

  bool has_derived(const std::vector<std::string>& outputs) const {
    return std::ranges::any_of(outputs, [&](const std::string& name) {
      return std::ranges::count(model().model().info().outputs, name, &OutputInfo::name) > 0;
    });
  }

  Place place_of(const std::string& output) const {
    const std::vector<OutputInfo>& derived = model().model().info().outputs;
    const auto found = std::ranges::find(derived, output, &OutputInfo::name);
    if (found != derived.end()) return {true, found - derived.begin()};
    const auto state = std::ranges::find(states_, output);
    if (state == states_.end())
      throw ArgumentError(fmt::format("model \"{}\" has no output \"{}\"{}", info_.model, output,
                                      suggestion(output, output_names(info_))));
    return {false, state - states_.begin()};
  }

  std::unique_ptr<TrajectoryFamily> family_;
  FamilyInfo info_;
  std::vector<std::string> states_;
};

}  // namespace

std::unique_ptr<TrajectoryFamily> with_derived_outputs(std::unique_ptr<TrajectoryFamily> family) {
  const ParametricModel* model = family->equations();
  if (model == nullptr || model->model().info().outputs.empty()) return family;
  const std::vector<std::string> outputs = output_names(family->info());
  for (const StateInfo& state : model->model().info().states) {
    if (std::ranges::find(outputs, state.name) == outputs.end()) return family;
  }
  return std::make_unique<DerivedTrajectories>(std::move(family));
}

}  // namespace samara::models
