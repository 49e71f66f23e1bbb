#include "samara/identification/series/series_knots.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "samara/models/interface/following_model.h"
#include "samara/models/trajectories/reference_trajectories.h"
#include "samara/models/trajectories/step_trajectories.h"

namespace samara::identification {

namespace {

constexpr const char* kClock = "start of the segment";

/// Straight lines between knots, constant beyond them. Its own parameters: the clock, then the values of the
/// first coefficient at all instants, those of the second, ..
class KnotCourse final : public models::ParameterCourse {
 public:
  KnotCourse(const models::ModelInfo& info, SeriesKnots knots) : knots_(std::move(knots)) {
    parameters_.push_back({.name = kClock,
                           .unit = models::time_unit(info),
                           .default_value = 0.0,
                           .description = "added to the time of a trajectory"});
    for (std::size_t c = 0; c < knots_.coefficients.size(); ++c) {
      // What is no parameter is refused by following().
      models::ParameterInfo parameter;
      const auto found =
          std::ranges::find(info.parameters, knots_.coefficients[c], &models::ParameterInfo::name);
      if (found != info.parameters.end()) parameter = *found;
      parameter.default_value.reset();
      parameter.derived.clear();
      for (int k = 0; k < knots_.count(); ++k) {
        parameter.name = knots_.name(c, k);
        parameters_.push_back(parameter);
      }
    }
  }

  const std::vector<std::string>& followed() const override { return knots_.coefficients; }
  std::vector<models::ParameterInfo> parameters() const override { return parameters_; }

  void values(double t, std::span<const double> own, std::span<double> followed) const override {
    const Place place = find(t + own[0]);
    for (std::size_t c = 0; c < followed.size(); ++c) {
      const double* const values = own.data() + first(c);
      followed[c] = (1.0 - place.share) * values[place.knot] + place.share * values[place.knot + 1];
    }
  }

  void derivatives(double t, std::span<const double> own, Eigen::Ref<Eigen::MatrixXd> by_own) const override {
    const Place place = find(t + own[0]);
    by_own.setZero();  // the derivative by the clock is not used
    for (std::size_t c = 0; c < knots_.coefficients.size(); ++c) {
      const auto row = static_cast<Eigen::Index>(c);
      const Eigen::Index column = static_cast<Eigen::Index>(first(c)) + place.knot;
      by_own(row, column) = 1.0 - place.share;
      by_own(row, column + 1) = place.share;
    }
  }

 private:
  struct Place {
    Eigen::Index knot = 0;  ///< the one before
    double share = 0.0;     ///< of the one after it
  };

  Place find(double t) const {
    const Eigen::VectorXd& at = knots_.instants;
    const auto next = std::upper_bound(at.begin() + 1, at.end() - 1, t);
    const Eigen::Index knot = (next - at.begin()) - 1;
    return {knot, std::clamp((t - at[knot]) / (at[knot + 1] - at[knot]), 0.0, 1.0)};
  }

  std::size_t first(std::size_t coefficient) const {
    return 1 + coefficient * static_cast<std::size_t>(knots_.count());
  }

  SeriesKnots knots_;
  std::vector<models::ParameterInfo> parameters_;
};

/// The same trajectories; the clock is known for what it is.
class ClockedTrajectories final : public models::TrajectoryFamily {
 public:
  explicit ClockedTrajectories(std::unique_ptr<models::TrajectoryFamily> family)
      : family_(std::move(family)), info_(family_->info()) {
    info_.clock = kClock;
  }

  const models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs) const override {
    return family_->at(times, outputs);
  }
  std::unique_ptr<models::TrajectorySource> at(const std::vector<double>& times,
                                               const std::vector<std::string>& outputs,
                                               const std::vector<int>& wanted) const override {
    return family_->at(times, outputs, wanted);
  }
  const models::ParametricModel* equations() const override { return family_->equations(); }
  std::unique_ptr<models::TrajectoryFamily> finer() const override {
    std::unique_ptr<models::TrajectoryFamily> finer = family_->finer();
    return finer ? std::make_unique<ClockedTrajectories>(std::move(finer)) : nullptr;
  }

 private:
  std::unique_ptr<models::TrajectoryFamily> family_;
  models::FamilyInfo info_;
};

}  // namespace

std::string SeriesKnots::name(std::size_t coefficient, int knot) const {
  return fmt::format("{}@{:.9g}", coefficients[coefficient], instants[knot]);
}

Eigen::MatrixXd difference_rows(const Eigen::VectorXd& instants, int order, double unit) {
  const Eigen::Index count = instants.size();
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(0, count - order), count);
  for (Eigen::Index k = 0; k < rows.rows(); ++k) {
    const double h = instants[k + 1] - instants[k];
    if (order == 1) {
      // A random walk: its variance grows with the time between.
      rows(k, k + 1) = std::sqrt(unit / h);
      rows(k, k) = -rows(k, k + 1);
      continue;
    }
    // The integral of c''^2 over the middle between neighbours.
    const double next = instants[k + 2] - instants[k + 1];
    const double mean = 0.5 * (h + next);
    const double weight = unit * unit / mean * std::sqrt(mean / unit);
    rows(k, k) = weight / h;
    rows(k, k + 1) = -weight / h - weight / next;
    rows(k, k + 2) = weight / next;
  }
  return rows;
}

std::unique_ptr<models::TrajectoryFamily> knot_trajectories(
    std::shared_ptr<const models::Model> model, const std::map<std::string, double>& fixed,
    const std::map<std::string, models::Interval>& box, std::optional<double> step,
    const SeriesKnots& knots) {
  std::map<std::string, models::Interval> knot_box = box;
  for (std::size_t c = 0; c < knots.coefficients.size(); ++c) {
    const auto whole = knot_box.extract(knots.coefficients[c]);
    for (int k = 0; k < knots.count(); ++k) knot_box[knots.name(c, k)] = whole.mapped();
  }
  // Its width means nothing; times of captures may be anything.
  const double span = 1.0 + knots.instants.cwiseAbs().maxCoeff();
  knot_box[kClock] = {-2.0 * span, 2.0 * span};
  const auto course = std::make_shared<KnotCourse>(model->info(), knots);
  auto moving = models::following(std::move(model), course);
  return std::make_unique<ClockedTrajectories>(
      step ? step_trajectories(std::move(moving), fixed, knot_box, *step)
           : reference_trajectories(std::move(moving), fixed, knot_box));
}

}  // namespace samara::identification
