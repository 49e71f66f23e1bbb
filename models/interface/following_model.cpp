#include "samara/models/interface/following_model.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"

namespace samara::models {

namespace {

class FollowingModel final : public Model {
 public:
  FollowingModel(std::shared_ptr<const Model> model, std::shared_ptr<const ParameterCourse> course)
      : base_(std::move(model)), course_(std::move(course)), info_(base_->info()) {
    find_followed();
    info_.outputs.clear();  // their derivatives by time would be those of the course as well
    info_.parameters.clear();
    for (const int index : kept_) {
      info_.parameters.push_back(base_->info().parameters[static_cast<std::size_t>(index)]);
    }
    const std::vector<ParameterInfo> own = course_->parameters();
    own_count_ = own.size();
    info_.parameters.insert(info_.parameters.end(), own.begin(), own.end());
    std::erase_if(info_.affine_in,
                  [&](const std::string& name) { return std::ranges::count(course_->followed(), name) > 0; });
  }

  const ModelInfo& info() const override { return info_; }

  void rhs(double t, std::span<const double> x, const ParameterValues& p,
           std::span<double> dxdt) const override {
    base_->rhs(t, x, base_values(t, p), dxdt);
  }

  void rhs_with_derivatives(double t, std::span<const double> x, const ParameterValues& p,
                            std::span<double> dxdt, Eigen::Ref<Eigen::MatrixXd> df_dx,
                            Eigen::Ref<Eigen::MatrixXd> df_dp) const override {
    const auto states = static_cast<Eigen::Index>(info_.states.size());
    Eigen::MatrixXd by_base(states, static_cast<Eigen::Index>(base_->info().parameters.size()));
    base_->rhs_with_derivatives(t, x, base_values(t, p), dxdt, df_dx, by_base);
    const auto own = static_cast<Eigen::Index>(own_count_);
    df_dp.leftCols(df_dp.cols() - own) = by_base(Eigen::all, kept_);
    if (own == 0) return;
    Eigen::MatrixXd by_own(static_cast<Eigen::Index>(followed_.size()), own);
    course_->derivatives(t, own_values(p.value), by_own);
    df_dp.rightCols(own) = by_base(Eigen::all, followed_) * by_own;
  }

  void forces(double t, std::span<const double> x, const ParameterValues& p,
              std::span<Wrench> terms) const override {
    base_->forces(t, x, base_values(t, p), terms);
  }

  std::optional<double> kinetic_energy(double t, std::span<const double> x,
                                       const ParameterValues& p) const override {
    return base_->kinetic_energy(t, x, base_values(t, p));
  }

  /// At time 0.
  std::vector<double> completed(const ParameterValues& p) const override {
    return from_base(base_->completed(base_values(0.0, p)), p);
  }

  /// Defaults that depend on what follows stay open, as NaN: they are put at every instant.
  void complete_into(const ParameterValues& p, std::span<double> all) const override {
    ParameterValues base = base_values(0.0, p);
    const std::vector<double> here = base_->completed(base);
    for (const int index : followed_) {
      double& value = base.value[static_cast<std::size_t>(index)];
      value = value == 0.0 ? 1.0 : 1.5 * value;
    }
    const std::vector<double> there = base_->completed(base);
    std::ranges::copy(from_base(here, p), all.begin());
    for (std::size_t k = 0; k < kept_.size(); ++k) {
      const auto index = static_cast<std::size_t>(kept_[k]);
      if (!p.given[k] && here[index] != there[index]) all[k] = std::numeric_limits<double>::quiet_NaN();
    }
  }

  std::string problem(const ParameterValues& p) const override { return base_->problem(base_values(0.0, p)); }

  Scales scales(const ParameterValues& p) const override { return base_->scales(base_values(0.0, p)); }

 private:
  void find_followed() {
    const std::vector<ParameterInfo>& parameters = base_->info().parameters;
    std::vector<std::string> known;
    for (const ParameterInfo& parameter : parameters) known.push_back(parameter.name);
    for (const std::string& name : course_->followed()) {
      const auto found = std::ranges::find(known, name);
      if (found == known.end()) {
        throw ArgumentError(fmt::format("model \"{}\" has no parameter \"{}\" that could change in time{}",
                                        info_.name, name, suggestion(name, known)));
      }
      const auto index = static_cast<int>(found - known.begin());
      if (std::ranges::count(followed_, index) > 0) {
        throw ArgumentError(fmt::format("\"{}\" is to change in time twice; once was expected", name));
      }
      followed_.push_back(index);
    }
    for (int index = 0; index < static_cast<int>(parameters.size()); ++index) {
      if (std::ranges::count(followed_, index) == 0) kept_.push_back(index);
    }
  }

  std::span<const double> own_values(std::span<const double> values) const { return values.last(own_count_); }

  /// The parameters of the base model at an instant; what is NaN was left open.
  ParameterValues base_values(double t, const ParameterValues& p) const {
    const std::size_t count = base_->info().parameters.size();
    ParameterValues base{std::vector<double>(count), std::vector<char>(count, 1)};
    for (std::size_t k = 0; k < kept_.size(); ++k) {
      const auto index = static_cast<std::size_t>(kept_[k]);
      base.value[index] = p.value[k];
      base.given[index] = p.given[k] && !std::isnan(p.value[k]) ? 1 : 0;
    }
    std::vector<double> now(followed_.size());
    course_->values(t, own_values(p.value), now);
    for (std::size_t k = 0; k < followed_.size(); ++k)
      base.value[static_cast<std::size_t>(followed_[k])] = now[k];
    return base;
  }

  std::vector<double> from_base(const std::vector<double>& base, const ParameterValues& p) const {
    std::vector<double> all;
    for (const int index : kept_) all.push_back(base[static_cast<std::size_t>(index)]);
    const std::span<const double> own = own_values(p.value);
    all.insert(all.end(), own.begin(), own.end());
    return all;
  }

  std::shared_ptr<const Model> base_;
  std::shared_ptr<const ParameterCourse> course_;
  ModelInfo info_;
  std::vector<int> followed_;  ///< indices of the base model's parameters, in the order of the course
  std::vector<int> kept_;      ///< of the others
  std::size_t own_count_ = 0;
};

}  // namespace

void ParameterCourse::derivatives(double, std::span<const double>, Eigen::Ref<Eigen::MatrixXd> by_own) const {
  by_own.setZero();
}

std::shared_ptr<const Model> following(std::shared_ptr<const Model> model,
                                       std::shared_ptr<const ParameterCourse> course) {
  return std::make_shared<FollowingModel>(std::move(model), std::move(course));
}

}  // namespace samara::models
