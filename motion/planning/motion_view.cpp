#include "samara/motion/planning/motion_view.h"

#include <algorithm>

#include "samara/motion/records/motion_record.h"

namespace samara::motion {

namespace {

std::vector<Eigen::Index> shown_rows(Eigen::Index count) {
  constexpr Eigen::Index kMost = 600;
  const Eigen::Index every = std::max<Eigen::Index>(1, count / kMost);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index k = 0; k + 1 < count; k += every) rows.push_back(k);
  rows.push_back(count - 1);
  return rows;
}

}  // namespace

MotionView view_of(const MotionPlan& plan, const MotionResult& motion, const GhostForce& ghost) {
  MotionView view;
  const std::vector<Eigen::Index> rows = shown_rows(motion.times.size());
  const MotionStates states(plan.model->info());
  view.times = motion.times(rows);
  view.places.resize(view.times.size(), 3);
  view.coefficients.resize(view.times.size(), static_cast<Eigen::Index>(plan.box.size()));
  std::vector<double> values(plan.box.size());
  for (Eigen::Index k = 0; k < view.times.size(); ++k) {
    const Eigen::VectorXd state = motion.states.row(rows[static_cast<std::size_t>(k)]);
    view.places.row(k) = states.position({state.data(), static_cast<std::size_t>(state.size())});
    motion.course->values(view.times[k], {}, values);
    view.coefficients.row(k) = Eigen::Map<const Eigen::RowVectorXd>(values.data(), view.coefficients.cols());
  }
  const std::vector<Eigen::Index> frames = shown_rows(ghost.times.size());
  view.ghost_times = ghost.times(frames);
  view.ghost_force = ghost.declared.force(frames);
  view.ghost_torque = ghost.declared.torque(frames);
  return view;
}

}  // namespace samara::motion
