#include "samara/motion/bodies/air_about_bodies.h"

#include <utility>

namespace samara::motion {

AirAboutBodies::AirAboutBodies(const models::Model& model, std::shared_ptr<const models::AmbientFlow> wind,
                               const StateLayout& layout, std::size_t count)
    : gusts_(model), wind_(std::move(wind)), layout_(layout), airs_(count) {}

models::BodyOnPath AirAboutBodies::motion_of(std::span<const double> state) const {
  models::BodyOnPath motion;
  gusts_.read([&](int i) { return state[static_cast<std::size_t>(i)]; }, motion);
  return motion;
}

void AirAboutBodies::look(Eigen::Index n, double t, std::span<double> state) {
  Air& about = air(n);
  const models::BodyOnPath motion = motion_of(state);
  about.now = wind_->sample(t, motion.position);
  const Eigen::Vector3d along = motion.attitude.transpose() * about.now.velocity;
  for (std::size_t k = 0; k < layout_.velocities().size(); ++k) {
    state[layout_.velocity[k]] -= along_axis(along, k);
    state[layout_.position[k]] -= along_axis(about.carried, k);
  }
}

void AirAboutBodies::tell(Eigen::Index n, double t, double h, std::span<const double> state,
                          std::span<double> values) {
  const models::AmbientSample& now = air(n).now;
  air(n).carried += h * now.velocity;
  const Eigen::Vector3d rate = now.rate + now.gradient * motion_of(state).velocity;
  std::size_t next = 0;
  gusts_.write([&](int, double value) { values[next++] = value; }, t, now.velocity, rate, now.gradient);
}

void AirAboutBodies::carry(double t, std::span<double> state) const {
  const models::BodyOnPath motion = motion_of(state);
  const Eigen::Vector3d along = motion.attitude.transpose() * wind_->sample(t, motion.position).velocity;
  for (std::size_t k = 0; k < layout_.velocities().size(); ++k)
    state[layout_.velocity[k]] += along_axis(along, k);
}

}  // namespace samara::motion
