#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <utility>

#include "samara/models/trajectories/trajectory_family.h"

/// Trajectories by a formula.
class ClosedFormFamily : public samara::models::TrajectoryFamily {
 public:
  /// The outputs at a time, and, if wanted, their derivatives: those of all outputs by the first coordinate, by the
  /// next..
  using Motion = std::function<void(std::span<const double> q, double t, Eigen::RowVectorXd& values,
                                    Eigen::RowVectorXd* derivatives)>;

  ClosedFormFamily(samara::models::FamilyInfo info, Motion motion)
      : info_(std::move(info)), motion_(std::move(motion)) {
    info_.source = "closed form";
  }

  const samara::models::FamilyInfo& info() const override { return info_; }
  std::unique_ptr<samara::models::TrajectorySource> at(const std::vector<double>& times,
                                                       const std::vector<std::string>&) const override {
    return std::make_unique<Source>(times, motion_);
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    Source(const std::vector<double>& at_times, const Motion& by) : times(at_times), motion(by) {}
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      Eigen::RowVectorXd at_time(values.cols()), slopes;
      if (derivatives) slopes.resize(derivatives->cols());
      for (std::size_t k = 0; k < times.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k);
        motion(q, times[k], at_time, derivatives ? &slopes : nullptr);
        values.row(row) = at_time;
        if (derivatives) derivatives->row(row) = slopes;
      }
      return {};
    }
    std::vector<double> times;
    Motion motion;
  };

  samara::models::FamilyInfo info_;
  Motion motion_;
};

/// The root of v0 + k t: no number where that is negative, and without a derivative where it is zero.
/// @param least_k, least_v0 where their boxes begin
inline ClosedFormFamily roots(double least_k, double least_v0) {
  return {{.model = "root",
           .coordinates = {{"k", "1/s", false, least_k, least_k + 1.0}, {"v0", "1", true, least_v0, 2.0}},
           .outputs = {{"x", "m"}}},
          [](std::span<const double> q, double t, auto& values, auto* derivatives) {
            values << std::sqrt(q[1] + q[0] * t);
            if (derivatives) *derivatives << 0.5 * t / values[0], 0.5 / values[0];
          }};
}
