#include "samara/models/stochastic/seen_steps.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "samara/base/exponentials.h"
#include "samara/models/stochastic/lane_packs.h"

namespace samara::models {

using laws::Rotation;
using laws::Vector3;

namespace {

/// A body that overtakes the fluid, as a bubble does, has the drift of the fluid and no more.
Eigen::Matrix3d bounded(const Eigen::Matrix3d& follows) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes;
  axes.computeDirect(0.5 * (follows + follows.transpose()));
  const Eigen::Vector3d shares = axes.eigenvalues().cwiseMax(0.0).cwiseMin(1.0);
  return axes.eigenvectors() * shares.asDiagonal() * axes.eigenvectors().transpose();
}

/// exp(-x) of several.
template <class S, std::size_t N>
void take_decays(S (&x)[N]) {
  constexpr std::size_t kWidth = LaneLayout<S>::kWidth;
  double numbers[N * kWidth];
  for (std::size_t i = 0; i < N; ++i) LaneLayout<S>::store(-x[i], numbers + i * kWidth);
  take_exponentials(numbers);
  for (std::size_t i = 0; i < N; ++i) x[i] = LaneLayout<S>::load(numbers + i * kWidth);
}

/// The noise that makes up for what a relaxation does not keep.
template <class S>
S noise_beside(const S& kept) {
  using std::sqrt;
  return sqrt((S(1.0) - kept) * (S(1.0) + kept));
}

template <class S>
S norm(const Vector3<S>& u) {
  using std::sqrt;
  return sqrt(dot(u, u));
}

template <class S>
S lesser(const S& a, const S& b) {
  return chosen(b < a, b, a);
}

}  // namespace

FluidByLane::FluidByLane(Eigen::Index lanes)
    : mean(VectorsByLane::Zero(lanes, 3)),
      mean_gradient(MatricesByLane::Zero(lanes, 9)),
      sigma_gradient(mean),
      sigma(Eigen::ArrayXd::Zero(lanes)),
      sigma_seen(sigma),
      T(Eigen::ArrayXd::Constant(lanes, std::numeric_limits<double>::infinity())),
      crossing(sigma),
      steps(sigma),
      blend(sigma),
      eddy_rate(sigma),
      inside(Eigen::ArrayXd::Ones(lanes)) {}

SeenSteps::SeenSteps(Eigen::Index lanes, bool varies, bool turns)
    : lanes_(lanes),
      varies_(varies),
      turns_(turns),
      w_(VectorsByLane::Zero(lanes, 3)),
      spin_(w_),
      mean_u_r_(w_),
      places_(w_),
      gradient_(MatricesByLane::Zero(lanes, 9)),
      time_scale_(Eigen::ArrayXd::Zero(lanes)) {}

void SeenSteps::start(const BodiesOnPath& bodies, const FluidByLane& here, const VectorsByLane& noise,
                      const VectorsByLane& spin_noise) {
  w_ = noise;
  spin_ = spin_noise;
  at_once_ = bounded(bodies.follows);
  mean_u_r_ = (bodies.velocity - here.mean).rowwise() * bodies.axes.transpose().array();
  time_scale_.setConstant(std::numeric_limits<double>::infinity());
}

SAMARA_FLAT void SeenSteps::move(const BodiesOnPath& bodies, double h, const FluidByLane& middle,
                                 const VectorsByLane& noise, const VectorsByLane& spin_noise) {
  with_scalar_of(lanes_, [&]<class S>(S) {
    for (Eigen::Index lane = 0; lane < lanes_; lane += LaneLayout<S>::kWidth)
      move_some<S>(lane, bodies, h, middle, noise, spin_noise);
  });
}

SAMARA_FLAT void SeenSteps::tell(const FluidByLane& there, AirsSeen& seen) const {
  with_scalar_of(lanes_, [&]<class S>(S) {
    for (Eigen::Index lane = 0; lane < lanes_; lane += LaneLayout<S>::kWidth) tell_some<S>(lane, there, seen);
  });
}

template <class S>
void SeenSteps::move_some(Eigen::Index lane, const BodiesOnPath& bodies, double h, const FluidByLane& middle,
                          const VectorsByLane& noise, const VectorsByLane& spin_noise) {
  using std::sqrt;
  const S one(1.0);
  const S sigma = of_row<S>(middle.sigma, lane), sigma_seen = of_row<S>(middle.sigma_seen, lane);
  const S T = of_row<S>(middle.T, lane), steps = of_row<S>(middle.steps, lane);
  const Vector3<S> velocity = of_rows<S>(bodies.velocity, lane), air = of_rows<S>(bodies.air, lane);
  const Vector3<S> before = of_rows<S>(w_, lane), xi = of_rows<S>(noise, lane);
  const auto moves = sigma > S(0.0);  // still fluid keeps w for where it is not

  const S blend = of_row<S>(middle.blend, lane);
  const Vector3<S> mean_before = of_rows<S>(mean_u_r_, lane);
  const Vector3<S> mean_u_r = mean_before + blend * (velocity - air - mean_before);
  const S speed = norm(mean_u_r), bs = of_row<S>(middle.crossing, lane) * speed;
  const S shorter_along = sqrt(one + bs * bs), shorter_across = sqrt(one + S(4.0) * bs * bs);
  S kept[] = {steps * shorter_along, steps * shorter_across};
  take_decays(kept);
  const S along = kept[0], across = kept[1];
  const S along_noise = noise_beside(along), across_noise = noise_beside(across);
  const Vector3<S> x_axis = {one, S(0.0), S(0.0)};
  const Vector3<S> axis = chosen(speed > S(0.0), (one / speed) * mean_u_r, x_axis);
  Vector3<S> w = across * before + across_noise * xi;
  w = w + ((along - across) * dot(axis, before) + (along_noise - across_noise) * dot(axis, xi)) * axis;
  const S T_across = T / shorter_across;
  const Rotation<S> R = rotation_of<S>(bodies.attitude, lane);
  const Vector3<S> slope = of_rows<S>(middle.sigma_gradient, lane);
  if (varies_) {
    // The drift is that of the fluid's own particles: a body has of it what it follows at once, and of the rest what
    // its drag follows in the time of an eddy (P. A. Bocksell, E. Loth, Int. J. Multiphase Flow 32 (2006) 1234-1253).
    const Vector3<S> at_once = R.to_world(times(at_once_, R.to_body(slope)));
    const S response = of_row<S>(bodies.response_time, lane);
    const Vector3<S> drift =
        (sigma_seen / sigma) * (at_once + (one / (one + response / T)) * (slope - at_once));
    const S carried = (one - across) * T_across;
    w = w + carried * drift + (((one - along) * (T / shorter_along) - carried) * dot(axis, drift)) * axis;
  }
  w = chosen(moves, w, before);
  to_rows(w, w_, lane);
  to_rows(chosen(moves, mean_u_r, mean_before), mean_u_r_, lane);

  const Vector3<S> change = of_rows<S>(middle.mean, lane) + sigma_seen * w - air;
  const Vector3<S> followed = R.to_world(times(bodies.follows, R.to_body(change)));
  const Vector3<S> place = of_rows<S>(bodies.position, lane) + S(h) * velocity +
                           S(0.5 * h) * (followed + S(h) * of_rows<S>(bodies.acceleration, lane));
  to_rows(place, places_, lane);

  S time_scale = chosen(moves, T_across, T);
  if (varies_) {
    // Along the path of the fluid, too, its deviation changes.
    const Vector3<S> half = chosen(moves, (S(0.5) * sigma_seen / sigma) * (before + w), Vector3<S>());
    Rotation<S> gradient = rotation_of<S>(middle.mean_gradient, lane);
    gradient.x_axis = gradient.x_axis + slope.x * half;
    gradient.y_axis = gradient.y_axis + slope.y * half;
    gradient.z_axis = gradient.z_axis + slope.z * half;
    to_rows(gradient, gradient_, lane);
    const S change_rate = norm(slope) * norm(velocity);
    time_scale = lesser(time_scale, T);
    time_scale = chosen(change_rate > S(0.0), lesser(time_scale, sigma / change_rate), time_scale);
  }
  to_row(time_scale, time_scale_, lane);

  if (turns_) {
    const S rate = of_row<S>(middle.eddy_rate, lane);
    S stays[] = {S(h) * rate};
    take_decays(stays);
    const Vector3<S> spin = of_rows<S>(spin_, lane);
    const Vector3<S> then = stays[0] * spin + noise_beside(stays[0]) * of_rows<S>(spin_noise, lane);
    to_rows(chosen(rate > S(0.0), then, spin), spin_, lane);
  }
}

template <class S>
void SeenSteps::tell_some(Eigen::Index lane, const FluidByLane& there, AirsSeen& seen) const {
  const Vector3<S> gust = of_row<S>(there.sigma_seen, lane) * of_rows<S>(w_, lane);
  to_rows(of_rows<S>(there.mean, lane) + gust, seen.velocity, lane);
  if (varies_) to_rows(rotation_of<S>(gradient_, lane), seen.gradient, lane);
  if (turns_)
    to_rows((S(0.99) * of_row<S>(there.eddy_rate, lane)) * of_rows<S>(spin_, lane), seen.rotation, lane);
  to_row(of_row<S>(time_scale_, lane), seen.time_scale, lane);
  to_row(of_row<S>(there.inside, lane), seen.inside, lane);
}

}  // namespace samara::models
