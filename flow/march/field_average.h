#pragma once

#include <string>

#include "samara/flow/march/flow_march.h"

namespace samara::flow {

/// Means of a flow over time: velocity on faces, the rest in centres, and the mean squares from which the resolved
/// energy comes.
class FieldAverage {
 public:
  explicit FieldAverage(const MacGrid& grid, bool turbulent);

  void add(const FlowMarch& march, double step);
  double time() const { return time_; }

  /// Sums over time, for checkpoints: velocity, p, squares, k, eps.
  template <class Visitor>
  void visit(const Visitor& visitor, const std::string& prefix) {
    visitor(prefix + "time", time_);
    for (std::size_t d = 0; d < 3; ++d) visitor(prefix + "u" + std::to_string(d), velocity_[d]);
    visitor(prefix + "p", pressure_);
    visitor(prefix + "squares", squares_);
    visitor(prefix + "k", k_);
    visitor(prefix + "epsilon", epsilon_);
  }

  FaceField velocity() const;
  Field pressure() const { return over_time(pressure_); }
  Field k_modelled() const { return over_time(k_); }
  Field epsilon() const { return over_time(epsilon_); }
  /// 1/2 <|u - <u>|^2> in centres.
  Field k_resolved() const;

 private:
  Field over_time(const Field& sum) const;

  MacGrid grid_;
  double time_ = 0.0;
  FaceField velocity_;
  Field pressure_, squares_, k_, epsilon_;
};

}  // namespace samara::flow
