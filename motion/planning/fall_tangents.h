#pragma once

#include <optional>
#include <span>
#include <vector>

#include "samara/motion/courses/coefficient_course.h"
#include "samara/motion/planning/book_tangents.h"
#include "samara/motion/planning/fall_lanes.h"

namespace samara::motion {

/// A fall along knots, and how its state changes with the values at the first of them.
///
/// The state is that of the plan's steps. Tangents are theirs too, or, where coefficients rest and the plan's codebook
/// holds them and the state, those of its windows, one after the other.
class FallTangents {
 public:
  /// @param most knots whose values are unknowns
  FallTangents(const PlannedFall& fall, std::size_t most);

  /// @param unknowns knots whose values are; 0: without tangents
  void begin(const FallPoint& from, std::size_t unknowns);
  /// The next knot begins.
  void turn(const CourseKnot& knot);
  /// @returns whether the state is finite
  bool step(long steps);

  double time() const { return lanes().time(0); }
  const std::vector<double>& state() const { return state_; }
  void read_coefficients(std::span<double> values) const { lanes().read_parameters(0, values); }
  /// d(state)/d(values at knot n) in columns n c to (n + 1) c, with c coefficients; states x unknowns.
  const Eigen::MatrixXd& tangents() const { return tangents_; }

  const BookUse& use() const { return use_; }

 private:
  bool has_tangents() const { return tangents_.cols() > 0; }
  models::Stepper& lanes() { return has_tangents() && !by_book_ ? tangent_lanes_ : value_lane_; }
  const models::Stepper& lanes() const { return has_tangents() && !by_book_ ? tangent_lanes_ : value_lane_; }
  Eigen::MatrixXd seeds_of(Eigen::Index lane) const;
  bool step_by_book(long steps);
  void step_by_lanes(long steps);
  /// Steps go on from where the codebook has come.
  void leave_book();

  const PlannedFall& fall_;
  Eigen::Index count_;  ///< of coefficients
  models::Stepper tangent_lanes_, value_lane_;
  std::optional<BookTangents> book_;
  bool by_book_ = false;             ///< the last steps were
  bool holds_coefficients_ = false;  ///< the codebook, those of the knot
  std::vector<double> values_;       ///< of the knot
  Eigen::Index number_ = -1;         ///< of it
  long ramp_left_ = 0;               ///< steps until its coefficients rest
  std::vector<double> state_;
  Eigen::MatrixXd tangents_, moved_, by_start_, by_coefficients_;
  BookUse use_;
};

}  // namespace samara::motion
