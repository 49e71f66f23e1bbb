#pragma once

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
