#include "samara/motion/events/event_finder.h"

#include <algorithm>
#include <cmath>

#include "samara/base/errors.h"
#include "samara/motion/records/smoothed_motion.h"

namespace samara::motion {

bool EventFinder::see(double t, std::span<const double> state) {
  if (!has_begun_) {
    lane_.begin(0, t, state);
    has_begun_ = true;
    return false;
  }
  return lane_.see(0, &t, {state.data(), 1}, 1) != 0;
}

EventList events_of(const MovingStates& states, const EventOptions& options, std::span<const double> times,
                    const Eigen::Ref<const Eigen::MatrixXd>& trajectory) {
  EventFinder finder(states, options);
  EventList list;
  std::vector<double> found, state(states.state_count());
  for (std::size_t k = 0; k < times.size(); ++k) {
    Eigen::Map<Eigen::VectorXd>(state.data(), trajectory.rows()) =
        trajectory.col(static_cast<Eigen::Index>(k));
    if (!finder.see(times[k], state)) continue;
    list.events.push_back(finder.event());
    found.insert(found.end(), finder.state().begin(), finder.state().end());
  }
  list.states =
      Eigen::Map<const Eigen::MatrixXd>(found.data(), static_cast<Eigen::Index>(states.state_count()),
                                        static_cast<Eigen::Index>(list.events.size()));
  return list;
}

EventList events_of(const MotionRecord& record) {
  if (!record.has_attitude())
    throw ArgumentError("the record has no attitude, without which its segments have no kinds");
  const SmoothedMotion motion = smoothed(record);
  Eigen::MatrixXd states(9, motion.frame_count());
  states.topRows(3) = motion.positions.transpose();
  states.middleRows(3, 3) = motion.velocities.transpose();
  if (motion.is_planar()) {
    states.row(6) = -motion.angles.transpose().array().sin();
    states.row(7).setZero();
    states.row(8) = motion.angles.transpose().array().cos();
  } else {
    states.bottomRows(3) = motion.normals.transpose();
  }
  const double square = motion.velocities.rowwise().squaredNorm().mean();
  EventOptions options;
  if (record.length > 0.0) options = event_options(square, record.length);
  options.mean_square_speed = square;
  options.prominence = std::max(options.prominence, 12.0 * motion.velocity_noise / std::sqrt(square));
  return events_of(MovingStates::of_record(motion.is_planar()), options,
                   {motion.times.data(), static_cast<std::size_t>(motion.times.size())}, states);
}

}  // namespace samara::motion
