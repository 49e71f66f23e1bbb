#include "samara/models/stochastic/air_along_path.h"

#include <utility>
#include <vector>

namespace samara::models {

namespace {

class OneByOne final : public AirAlongPaths {
 public:
  explicit OneByOne(std::vector<std::unique_ptr<AirAlongPath>> paths) : paths_(std::move(paths)) {}

  void start(const BodiesOnPath& bodies, AirsSeen& seen) override {
    for_flying(bodies, [&](AirAlongPath& path, Eigen::Index lane) {
      seen.set(lane, path.start(bodies.body(lane)));
      seen.needs_response[lane] = path.needs_response() ? 1.0 : 0.0;
    });
  }

  void step(const BodiesOnPath& bodies, double h, AirsSeen& seen) override {
    for_flying(bodies, [&](AirAlongPath& path, Eigen::Index lane) {
      seen.set(lane, path.step(bodies.body(lane), h));
      seen.needs_response[lane] = path.needs_response() ? 1.0 : 0.0;
    });
  }

 private:
  template <class Act>
  void for_flying(const BodiesOnPath& bodies, const Act& act) {
    for (Eigen::Index lane = 0; lane < std::ssize(paths_); ++lane) {
      if (bodies.flies[lane] > 0.0) act(*paths_[static_cast<std::size_t>(lane)], lane);
    }
  }

  std::vector<std::unique_ptr<AirAlongPath>> paths_;
};

}  // namespace

BodiesOnPath::BodiesOnPath(Eigen::Index lanes)
    : position(VectorsByLane::Zero(lanes, 3)),
      velocity(position),
      air(position),
      acceleration(position),
      attitude(MatricesByLane::Zero(lanes, 9)),
      response_time(Eigen::ArrayXd::Zero(lanes)),
      flies(response_time) {}

BodyOnPath BodiesOnPath::body(Eigen::Index lane) const {
  BodyOnPath one = {.t = t,
                    .position = position.row(lane),
                    .velocity = velocity.row(lane),
                    .axes = axes,
                    .air = air.row(lane),
                    .follows = follows,
                    .acceleration = acceleration.row(lane),
                    .response_time = response_time[lane]};
  one.attitude.reshaped() = attitude.row(lane);
  return one;
}

void BodiesOnPath::set(Eigen::Index lane, const BodyOnPath& body) {
  t = body.t;
  position.row(lane) = body.position;
  velocity.row(lane) = body.velocity;
  air.row(lane) = body.air;
  acceleration.row(lane) = body.acceleration;
  attitude.row(lane) = body.attitude.reshaped();
  response_time[lane] = body.response_time;
  axes = body.axes;
  follows = body.follows;
  flies[lane] = 1.0;
}

AirsSeen::AirsSeen(Eigen::Index lanes)
    : velocity(VectorsByLane::Zero(lanes, 3)),
      rotation(velocity),
      gradient(MatricesByLane::Zero(lanes, 9)),
      time_scale(Eigen::ArrayXd::Zero(lanes)),
      inside(Eigen::ArrayXd::Ones(lanes)),
      needs_response(time_scale) {}

AirSeen AirsSeen::seen(Eigen::Index lane) const {
  AirSeen one = {.velocity = velocity.row(lane),
                 .rotation = rotation.row(lane),
                 .time_scale = time_scale[lane],
                 .inside = inside[lane] > 0.0};
  one.gradient.reshaped() = gradient.row(lane);
  return one;
}

void AirsSeen::set(Eigen::Index lane, const AirSeen& seen) {
  velocity.row(lane) = seen.velocity;
  rotation.row(lane) = seen.rotation;
  gradient.row(lane) = seen.gradient.reshaped();
  time_scale[lane] = seen.time_scale;
  inside[lane] = seen.inside ? 1.0 : 0.0;
}

std::unique_ptr<AirAlongPaths> AirSource::side_by_side(std::span<const Draw> draws, Eigen::Index) const {
  std::vector<std::unique_ptr<AirAlongPath>> paths;
  for (const Draw& draw : draws) paths.push_back(realisation(draw.number, draw.mirrored));
  return std::make_unique<OneByOne>(std::move(paths));
}

}  // namespace samara::models
