#include "samara/models/stochastic/gust_ramps.h"

#include "samara/models/batch/lane_sine.h"
#include "samara/models/stochastic/lane_packs.h"

namespace samara::models {

using laws::Rotation;
using laws::Vector3;

namespace {

/// R F R^T u: what a body with the attitude R follows of a change u at once.
template <class S>
Vector3<S> followed_of(const Rotation<S>& R, const Eigen::Matrix3d& follows, const Vector3<S>& change) {
  return R.to_world(times(follows, R.to_body(change)));
}

template <class S>
Rotation<S> upright() {
  return {{S(1.0), S(0.0), S(0.0)}, {S(0.0), S(1.0), S(0.0)}, {S(0.0), S(0.0), S(1.0)}};
}

/// Of a plate whose theta turns from x to z.
template <class S>
Rotation<S> in_plane(const S& theta) {
  const SineCosine<S> of = sine_and_cosine(theta);
  return {{of.cosine, S(0.0), of.sine}, {S(0.0), S(1.0), S(0.0)}, {-of.sine, S(0.0), of.cosine}};
}

}  // namespace

GustRamps::GustRamps(const GustLayout& layout, int width)
    : layout_(layout),
      width_(width),
      before_(VectorsByLane::Zero(whole_packs(width), 3)),
      followed_(before_),
      side_(Eigen::ArrayXd::Zero(before_.rows())),
      half_turns_(side_) {}

void GustRamps::start(const Lanes& flown, BodiesOnPath& bodies) {
  side_.setZero();
  half_turns_.setZero();
  with_scalar_of(lanes(), [&]<class S>(S) {
    for (Eigen::Index lane = 0; lane < lanes(); lane += LaneLayout<S>::kWidth) read<S>(lane, flown, bodies);
  });
}

SAMARA_FLAT bool GustRamps::set(double t, double h, const AirsSeen& seen, BodiesOnPath& bodies,
                                Lanes& flown) {
  bool is_any_lost = false;
  with_scalar_of(lanes(), [&]<class S>(S) {
    for (Eigen::Index lane = 0; lane < lanes(); lane += LaneLayout<S>::kWidth)
      is_any_lost |= set_some<S>(lane, t, h, seen, bodies, flown);
  });
  return is_any_lost;
}

SAMARA_FLAT bool GustRamps::look(double h, double ground, const Lanes& flown, BodiesOnPath& bodies) {
  bool is_any_down = false;
  with_scalar_of(lanes(), [&]<class S>(S) {
    for (Eigen::Index lane = 0; lane < lanes(); lane += LaneLayout<S>::kWidth)
      is_any_down |= look_some<S>(lane, h, ground, flown, bodies);
  });
  return is_any_down;
}

/// As GustLayout::read.
template <class S>
void GustRamps::read(Eigen::Index lane, const Lanes& flown, BodiesOnPath& bodies) {
  const std::ptrdiff_t left = width_ - lane;
  const auto state = [&](int index) { return load_some<S>(flown.states(index) + lane, left); };
  const std::vector<int>&place = layout_.position(), &speed = layout_.velocity();
  Rotation<S> R = upright<S>();
  Vector3<S> position, velocity;
  if (layout_.space() == GustLayout::Space::plane) {
    R = in_plane(state(layout_.attitude()));
    position = {state(place[0]), S(0.0), state(place[1])};
    velocity = R.to_world({state(speed[0]), S(0.0), state(speed[1])});
  } else {
    position = {state(place[0]), state(place[1]), state(place[2])};
    velocity = {state(speed[0]), state(speed[1]), state(speed[2])};
    if (layout_.space() == GustLayout::Space::body) {
      const int first = layout_.attitude();
      const S q[] = {state(first), state(first + 1), state(first + 2), state(first + 3)};
      R = laws::rotation(q);
      velocity = R.to_world(velocity);
    }
  }
  to_rows(position, bodies.position, lane);
  to_rows(velocity, bodies.velocity, lane);
  to_rows(R, bodies.attitude, lane);
  if (layout_.has_attitude()) count_turns(lane, R.z_axis.z);
}

template <class S>
void GustRamps::count_turns(Eigen::Index lane, const S& normal_z) {
  using std::abs;
  const S old = of_row<S>(side_, lane), count = of_row<S>(half_turns_, lane);
  const S side = chosen(normal_z > S(0.0), S(1.0), S(-1.0));
  const auto is_seen = abs(normal_z) >= S(0.5);
  const auto has_turned = is_seen && old * side < S(0.0);
  to_row(chosen(has_turned, count + S(1.0), count), half_turns_, lane);
  to_row(chosen(is_seen, side, old), side_, lane);
}

template <class S>
bool GustRamps::set_some(Eigen::Index lane, double t, double h, const AirsSeen& seen, BodiesOnPath& bodies,
                         Lanes& flown) {
  const Vector3<S> air = of_rows<S>(bodies.air, lane);
  const Rotation<S> R = rotation_of<S>(bodies.attitude, lane);
  const auto is_inside = of_row<S>(seen.inside, lane) > S(0.0);
  // The ground may be where the flow ends: the step is taken all the same, in air as it is here.
  const Vector3<S> velocity = of_rows<S>(seen.velocity, lane);
  const Vector3<S> next = chosen(is_inside, diagonal_times(for_all<S>(bodies.axes), velocity), air);
  const Vector3<S> change = next - air;
  const Vector3<S> rate = S(1.0 / h) * change;
  to_rows(followed_of(R, bodies.follows, change), followed_, lane);
  to_rows(next, bodies.air, lane);

  const std::ptrdiff_t left = width_ - lane;
  auto parameter = layout_.parameters().begin();
  const auto write = [&](const S& value) { store_some(value, flown.parameters(*parameter++) + lane, left); };
  const bool is_plane = layout_.space() == GustLayout::Space::plane;
  write(S(t));
  const auto write_vector = [&](const Vector3<S>& vector) {
    write(vector.x);
    if (!is_plane) write(vector.y);
    write(vector.z);
  };
  write_vector(air);
  write_vector(rate);
  // Of component i along axis j, column after column in a row of `seen`.
  for (const Eigen::Index i : {0, 1, 2}) {
    const auto along = [&](Eigen::Index j) {
      return chosen(is_inside, of_row<S>(seen.gradient, lane, 3 * j + i), S(0.0));
    };
    if (!is_plane || i != 1) write_vector({along(0), along(1), along(2)});
  }
  const Vector3<S> spin = of_rows<S>(seen.rotation, lane);
  // theta turns from x to z, the axis y of the world the other way.
  if (is_plane) {
    write(-spin.y);
  } else {
    for (const S* component : {&spin.x, &spin.y, &spin.z}) write(*component);
  }
  return is_any(of_row<S>(bodies.flies, lane) > S(0.0) && !all_finite(velocity));
}

template <class S>
bool GustRamps::look_some(Eigen::Index lane, double h, double ground, const Lanes& flown,
                          BodiesOnPath& bodies) {
  const Vector3<S> old = of_rows<S>(bodies.velocity, lane);
  to_rows(of_rows<S>(bodies.position, lane), before_, lane);
  read<S>(lane, flown, bodies);
  const Vector3<S> position = of_rows<S>(bodies.position, lane), velocity = of_rows<S>(bodies.velocity, lane);
  to_rows(S(1.0 / h) * (velocity - old - of_rows<S>(followed_, lane)), bodies.acceleration, lane);
  const auto is_down = !(position.z > S(ground)) || !all_finite(position) || !all_finite(velocity);
  return is_any(of_row<S>(bodies.flies, lane) > S(0.0) && is_down);
}

}  // namespace samara::models
