#include "samara/motion/planning/fall_tangents.h"

#include <algorithm>
#include <cmath>

namespace samara::motion {

namespace {

Eigen::Index lane_count(const PlannedFall& fall, std::size_t knots) {
  const models::Stepper one(fall.model(), fall.names(), 1, {.tangents = true});
  const auto wanted = static_cast<Eigen::Index>(knots * fall.names().size());
  return (wanted + one.directions() - 1) / one.directions();
}

std::span<const double> column(const Eigen::MatrixXd& matrix, Eigen::Index k) {
  return {matrix.col(k).data(), static_cast<std::size_t>(matrix.rows())};
}

}  // namespace

FallTangents::FallTangents(const PlannedFall& fall, std::size_t most)
    : fall_(fall),
      count_(std::ssize(fall.names())),
      tangent_lanes_(fall.model(), fall.names(), lane_count(fall, most), {.tangents = true}),
      value_lane_(fall.model(), fall.names(), 1) {
  for (Eigen::Index lane = 0; lane < tangent_lanes_.lanes(); ++lane)
    tangent_lanes_.load(lane, fall.natural());
  value_lane_.load(0, fall.natural());
  if (fall.plan().codebook) book_.emplace(fall.plan());
}

void FallTangents::begin(const FallPoint& from, std::size_t unknowns) {
  state_ = from.state;
  tangents_.setZero(std::ssize(state_), static_cast<Eigen::Index>(unknowns) * count_);
  by_book_ = false;
  number_ = -1;
  for (Eigen::Index lane = 0; lane < lanes().lanes(); ++lane) {
    lanes().set_state(lane, from.t, from.state);
    lanes().set_parameters(lane, from.coefficients);
  }
}

void FallTangents::turn(const CourseKnot& knot) {
  if (by_book_) leave_book();
  values_ = knot.values;
  ++number_;
  for (Eigen::Index lane = 0; lane < lanes().lanes(); ++lane) {
    if (has_tangents()) {
      lanes().ramp(lane, knot.values, knot.ramp, seeds_of(lane));
    } else {
      lanes().ramp(lane, knot.values, knot.ramp);
    }
  }
  if (!book_ || !has_tangents()) return;
  ramp_left_ = static_cast<long>(std::ceil(knot.ramp / fall_.plan().search.step - 1e-9));
  holds_coefficients_ = book_->set_coefficients(knot.values);
}

Eigen::MatrixXd FallTangents::seeds_of(Eigen::Index lane) const {
  const int directions = tangent_lanes_.directions();
  Eigen::MatrixXd seeds = Eigen::MatrixXd::Zero(count_, directions);
  for (Eigen::Index j = 0; j < count_; ++j) {
    const Eigen::Index unknown = number_ * count_ + j;
    if (unknown < tangents_.cols() && unknown / directions == lane) seeds(j, unknown % directions) = 1.0;
  }
  return seeds;
}

bool FallTangents::step(long steps) {
  if (!book_ || !has_tangents()) {
    step_by_lanes(steps);
    return lanes().finite(0);
  }
  while (steps > 0) {
    const long now = std::min(steps, ramp_left_ > 0 ? ramp_left_ : book_->steps());
    if (ramp_left_ > 0 || !holds_coefficients_ || !step_by_book(now)) {
      if (by_book_) leave_book();
      step_by_lanes(now);
    }
    ramp_left_ = std::max(0L, ramp_left_ - now);
    steps -= now;
    use_.asked += now;
    if (!lanes().finite(0)) return false;
  }
  return true;
}

void FallTangents::step_by_lanes(long steps) {
  lanes().step(fall_.plan().search.step, steps);
  lanes().read(0, state_);
  const int directions = tangent_lanes_.directions();
  for (Eigen::Index k = 0; k < tangents_.cols(); ++k) {
    lanes().read_tangent(k / directions, static_cast<int>(k % directions),
                         {tangents_.col(k).data(), state_.size()});
  }
}

bool FallTangents::step_by_book(long steps) {
  const double duration = fall_.plan().search.step * static_cast<double>(steps);
  if (!book_->transition(state_, duration, by_start_, by_coefficients_)) return false;
  moved_.noalias() = by_start_ * tangents_;
  if (number_ * count_ < tangents_.cols()) moved_.middleCols(number_ * count_, count_) += by_coefficients_;
  tangents_.swap(moved_);
  if (!by_book_) {
    value_lane_.set_state(0, lanes().time(0), state_);
    value_lane_.set_parameters(0, values_);
    by_book_ = true;
  }
  value_lane_.step(fall_.plan().search.step, steps);
  value_lane_.read(0, state_);
  ++use_.windows;
  use_.served += steps;
  return true;
}

void FallTangents::leave_book() {
  const double t = value_lane_.time(0);
  by_book_ = false;
  const int directions = tangent_lanes_.directions();
  for (Eigen::Index lane = 0; lane < tangent_lanes_.lanes(); ++lane) {
    tangent_lanes_.set_state(lane, t, state_);
    tangent_lanes_.ramp(lane, values_, 0.0, seeds_of(lane));
    for (int d = 0; d < directions && lane * directions + d < tangents_.cols(); ++d)
      tangent_lanes_.set_tangent(lane, d, column(tangents_, lane * directions + d));
  }
}

}  // namespace samara::motion
