#pragma once

#include <algorithm>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "samara/models/trajectories/trajectory_family.h"

/// Another family, of whose output values, or their derivatives, are no numbers from some time of every trajectory on.
class SpoiltFamily final : public samara::models::TrajectoryFamily {
 public:
  enum class Part { values, derivatives };

  SpoiltFamily(const samara::models::TrajectoryFamily& whole, std::string output, double from, Part part)
      : whole_(whole), output_(std::move(output)), from_(from), part_(part) {}

  const samara::models::FamilyInfo& info() const override { return whole_.info(); }
  const samara::models::ParametricModel* equations() const override { return whole_.equations(); }
  std::unique_ptr<samara::models::TrajectorySource> at(
      const std::vector<double>& times, const std::vector<std::string>& outputs) const override {
    auto source = std::make_unique<Source>();
    source->whole = whole_.at(times, outputs);
    source->column = std::ranges::find(outputs, output_) - outputs.begin();
    source->outputs = std::ssize(outputs);
    source->row = std::ranges::lower_bound(times, from_) - times.begin();
    source->part = part_;
    return source;
  }

 private:
  struct Source final : samara::models::TrajectorySource {
    samara::models::TrajectoryOutcome evaluate(std::span<const double> q, Eigen::MatrixXd& values,
                                               Eigen::MatrixXd* derivatives) override {
      const auto outcome = whole->evaluate(q, values, derivatives);
      constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
      if (column == outputs) return outcome;  // not asked for
      if (part == Part::values) values.col(column).tail(values.rows() - row).setConstant(kNone);
      for (Eigen::Index k = column; derivatives && k < derivatives->cols(); k += outputs)
        derivatives->col(k).tail(values.rows() - row).setConstant(kNone);
      return outcome;
    }
    std::unique_ptr<samara::models::TrajectorySource> whole;
    Eigen::Index column = 0, outputs = 0, row = 0;
    Part part = Part::values;
  };

  const samara::models::TrajectoryFamily& whole_;
  std::string output_;
  double from_;
  Part part_;
};
