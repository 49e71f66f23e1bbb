#include "samara/models/stochastic/fluid_seen.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "samara/base/errors.h"
#include "samara/base/normals.h"
#include "samara/base/require.h"
#include "samara/models/stochastic/langevin.h"
#include "samara/models/stochastic/seen_steps.h"

namespace samara::models {

namespace {

/// Over how many T the relative velocity is averaged: over fewer, much of what is random would count as a drift through
/// the eddies, and T would depend on the gust itself.
constexpr double kTimesOfMean = 10.0;

enum NoiseStream : std::uint16_t { kGustNoise = 1, kSpinNoise = 2 };

/// Standard normals of realisations side by side, step after step, made a few ahead.
class NoiseByLane {
 public:
  NoiseByLane(std::uint64_t seed, std::span<const Draw> draws, Eigen::Index lanes, NoiseStream stream)
      : seed_(seed), draws_(draws.begin(), draws.end()), stream_(stream) {
    ahead_.fill(VectorsByLane::Zero(lanes, 3));
  }

  const VectorsByLane& next() {
    if (used_ == ahead_.size()) refill();
    return ahead_[used_++];
  }

 private:
  void refill() {
    std::array<std::array<double, 4>, kAhead> of_one;
    for (std::size_t lane = 0; lane < draws_.size(); ++lane) {
      const double sign = draws_[lane].mirrored ? -1.0 : 1.0;
      normals_from(seed_, {.realisation = draws_[lane].number, .step = step_, .stream = stream_}, of_one);
      for (std::size_t n = 0; n < kAhead; ++n) {
        for (std::size_t i = 0; i < 3; ++i)
          ahead_[n](static_cast<Eigen::Index>(lane), static_cast<Eigen::Index>(i)) = sign * of_one[n][i];
      }
    }
    step_ += kAhead;
    used_ = 0;
  }

  static constexpr std::size_t kAhead = 16;

  std::uint64_t seed_;
  std::vector<Draw> draws_;
  NoiseStream stream_;
  std::uint64_t step_ = 0;
  std::array<VectorsByLane, kAhead> ahead_;
  std::size_t used_ = kAhead;
};

/// The energy in the terms of the Langevin equation, lane by lane. Where it is that of the last time, so are they.
class FluidLanes {
 public:
  FluidLanes(const TurbulentFlow& flow, const SeenOptions& options, Eigen::Index lanes)
      : fluid_(lanes), flow_(flow), options_(options), of_(static_cast<std::size_t>(lanes)) {}

  /// The fluid where bodies that fly are, before a step of length h [s].
  const FluidByLane& at(double t, const VectorsByLane& places, const Eigen::ArrayXd& flies, double h) {
    if (flow_.is_uniform()) {
      set_all(flow_.turbulence(t, Eigen::Vector3d::Zero()), flow_.sample(t, Eigen::Vector3d::Zero()), h);
      return fluid_;
    }
    for (Eigen::Index lane = 0; lane < places.rows(); ++lane) {
      if (!(flies[lane] > 0.0)) continue;
      const Eigen::Vector3d place = places.row(lane);
      const Turbulence energy = flow_.turbulence(t, place);
      const AmbientSample mean = flow_.sample(t, place);
      set_energy(lane, energy, h);
      fluid_.sigma_gradient.row(lane) = energy.sigma_gradient;
      fluid_.mean.row(lane) = mean.velocity;
      fluid_.mean_gradient.row(lane) = mean.gradient.reshaped();
      fluid_.inside[lane] = energy.inside ? 1.0 : 0.0;
    }
    return fluid_;
  }

 private:
  /// Of a flow that is the same everywhere: what is of one lane is of all.
  void set_all(const Turbulence& energy, const AmbientSample& mean, double h) {
    const bool is_known = energy.k == of_[0].k && energy.epsilon == of_[0].epsilon && h == h_ &&
                          mean.velocity == mean_ && (fluid_.inside[0] > 0.0) == energy.inside;
    if (is_known) return;
    set_energy(0, energy, h);
    for (Eigen::ArrayXd* row : {&fluid_.sigma, &fluid_.sigma_seen, &fluid_.T, &fluid_.crossing, &fluid_.steps,
                                &fluid_.blend, &fluid_.eddy_rate})
      row->setConstant((*row)[0]);
    fluid_.mean.rowwise() = mean.velocity.transpose().array();
    fluid_.inside.setConstant(energy.inside ? 1.0 : 0.0);
    h_ = h;
    mean_ = mean.velocity;
  }

  void set_energy(Eigen::Index lane, const Turbulence& energy, double h) {
    Turbulence& of = of_[static_cast<std::size_t>(lane)];
    if (energy.k != of.k || energy.epsilon != of.epsilon) {
      of = energy;
      const LangevinScales scales(energy, options_);
      const bool moves = scales.sigma > 0.0;
      fluid_.sigma[lane] = scales.sigma;
      fluid_.sigma_seen[lane] = attenuated(scales);
      fluid_.T[lane] = scales.T;
      fluid_.crossing[lane] = options_.crossing && moves ? 0.565 * 6.0 / (scales.C_0 * scales.sigma) : 0.0;
      fluid_.eddy_rate[lane] = options_.rotation && energy.k > 0.0 ? eddy_rate(energy.epsilon) : 0.0;
    }
    if (const double steps = h / fluid_.T[lane]; steps != fluid_.steps[lane]) {
      fluid_.steps[lane] = steps;
      fluid_.blend[lane] = -std::expm1(-steps / kTimesOfMean);
    }
  }

  /// sigma of what the body sees of it.
  double attenuated(const LangevinScales& scales) const {
    if (options_.radius == 0.0 || !(scales.L > 0.0)) return scales.sigma;
    return scales.sigma * std::sqrt(disc_attenuation(options_.radius / scales.L));
  }

  /// (epsilon/l^2)^(1/3)
  double eddy_rate(double epsilon) const {
    const double length = 2.0 * options_.radius;
    return std::cbrt(epsilon / (length * length));
  }

  FluidByLane fluid_;
  const TurbulentFlow& flow_;
  SeenOptions options_;
  std::vector<Turbulence> of_;  ///< what the scales are of
  double h_ = -1.0;             ///< of a flow that is the same everywhere: the last step and mean velocity
  Eigen::Vector3d mean_ = Eigen::Vector3d::Zero();
};

class FluidSeen final : public AirAlongPaths {
 public:
  FluidSeen(const TurbulentFlow& flow, std::uint64_t seed, const SeenOptions& options,
            std::span<const Draw> draws, Eigen::Index lanes)
      : options_(options),
        gusts_(seed, draws, lanes, kGustNoise),
        spins_(seed, draws, lanes, kSpinNoise),
        middle_(flow, options, lanes),
        end_(flow, options, lanes),
        varies_(!flow.is_uniform()),
        steps_(lanes, varies_, options.rotation) {}

  void start(const BodiesOnPath& bodies, AirsSeen& seen) override {
    const FluidByLane& here = middle_.at(bodies.t, bodies.position, bodies.flies, 0.0);
    const VectorsByLane& noise = gusts_.next();
    steps_.start(bodies, here, noise, spin_noise());
    steps_.tell(here, seen);
    say_gradients(here, seen);
  }

  void step(const BodiesOnPath& bodies, double h, AirsSeen& seen) override {
    if (varies_) places_ = bodies.position + 0.5 * h * bodies.velocity;
    const FluidByLane& middle = middle_.at(bodies.t + 0.5 * h, places_, bodies.flies, h);
    const VectorsByLane& noise = gusts_.next();
    steps_.move(bodies, h, middle, noise, spin_noise());
    steps_.tell(end_.at(bodies.t + h, steps_.places(), bodies.flies, h), seen);
    say_gradients(middle, seen);
  }

 private:
  /// The drift is in proportion to them, and a body has its share of it.
  void say_gradients(const FluidByLane& fluid, AirsSeen& seen) const {
    if (varies_) seen.needs_response = (fluid.sigma_gradient != 0.0).rowwise().any().cast<double>();
  }
  const VectorsByLane& spin_noise() { return options_.rotation ? spins_.next() : none_; }

  SeenOptions options_;
  NoiseByLane gusts_, spins_;
  FluidLanes middle_, end_;
  bool varies_;
  SeenSteps steps_;
  VectorsByLane places_, none_;
};

/// One alone.
class FluidSeenByOne final : public AirAlongPath {
 public:
  FluidSeenByOne(const TurbulentFlow& flow, std::uint64_t seed, const SeenOptions& options, const Draw& draw)
      : path_(flow, seed, options, std::span(&draw, 1), 1), body_(1), seen_(1) {}

  AirSeen start(const BodyOnPath& body) override {
    body_.set(0, body);
    path_.start(body_, seen_);
    return seen_.seen(0);
  }
  AirSeen step(const BodyOnPath& body, double h) override {
    body_.set(0, body);
    path_.step(body_, h, seen_);
    return seen_.seen(0);
  }
  bool needs_response() const override { return seen_.needs_response[0] > 0.0; }

 private:
  FluidSeen path_;
  BodiesOnPath body_;
  AirsSeen seen_;
};

class FluidSeenSource final : public AirSource {
 public:
  FluidSeenSource(std::shared_ptr<const TurbulentFlow> flow, std::uint64_t seed, const SeenOptions& options)
      : flow_(std::move(flow)), seed_(seed), options_(options) {}

  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const override {
    return std::make_unique<FluidSeenByOne>(*flow_, seed_, options_, Draw{number, mirrored});
  }
  std::unique_ptr<AirAlongPaths> side_by_side(std::span<const Draw> draws,
                                              Eigen::Index lanes) const override {
    return std::make_unique<FluidSeen>(*flow_, seed_, options_, draws, lanes);
  }

 private:
  std::shared_ptr<const TurbulentFlow> flow_;
  std::uint64_t seed_;
  SeenOptions options_;
};

}  // namespace

double structure_constant(double Re_lambda) {
  require_not_negative(Re_lambda, "Re_lambda");
  if (Re_lambda == 0.0) return 0.0;
  // By roots, which cost less than powers: flows that vary ask twice in a step.
  const double base = 1.0 + 140.0 / (Re_lambda * std::cbrt(Re_lambda)), root = std::sqrt(base);
  return 6.5 / (root * std::sqrt(root));
}

LangevinStep::LangevinStep(double steps) {
  kept = std::exp(-steps);
  const double lost = -std::expm1(-steps);  // 1 - kept
  noise = std::sqrt(lost * (1.0 + kept));
  carry = lost;
  if (noise == 0.0) {
    shared = rest = 0.0;
    return;
  }
  // The integral has the covariance (1 - kept)^2 with the noise, and the variance 2 a - 3 + 4 kept - kept^2, which
  // cancels to third order: its series where that costs more than it errs.
  shared = lost * lost / noise;
  const double a = steps;
  const double variance =
      a < 0.02
          ? a * a * a * (2.0 / 3.0 + a * (-0.5 + a * (7.0 / 30.0 + a * (-1.0 / 12.0 + a * 31.0 / 1260.0))))
          : 2.0 * a - 2.0 * lost - lost * lost;
  rest = std::sqrt(std::max(0.0, variance - shared * shared));
}

double disc_attenuation(double radius_over_scale) {
  require_not_negative(radius_over_scale, "radius over scale");
  // Integrals of (2 J_1(q)/q)^2 over von Karman's spectrum, q = a k sin(angle to the normal), for a/L = 10^(-4 + i/4).
  static constexpr std::array kTable = {
      0.9975051,     0.99633732,    0.99462328,    0.9921075,    0.98841511,  0.98299628,  0.97504522,
      0.96338309,    0.94629172,    0.92128641,    0.88483288,   0.83207738,  0.75684803,  0.65264268,
      0.51609667,    0.35456865,    0.19490704,    0.077329892,  0.020875175, 0.004247709, 0.00078131282,
      0.00014029764, 2.5023905e-05, 4.4541506e-06, 7.9230312e-07};
  constexpr double kFirst = -4.0, kPerDecade = 4.0;
  constexpr int kLast = static_cast<int>(kTable.size()) - 1;
  if (radius_over_scale < 1e-4) return 1.0 - 1.158 * std::pow(radius_over_scale, 2.0 / 3.0);
  if (radius_over_scale >= 100.0) return kTable.back() * std::pow(radius_over_scale / 100.0, -3.0);
  const double place = (std::log10(radius_over_scale) - kFirst) * kPerDecade;
  const int cell = std::clamp(static_cast<int>(place), 1, kLast - 2);
  // Lagrange's cubic through four entries, in logarithms.
  static const std::array<double, kTable.size()> kLogarithms = [] {
    std::array<double, kTable.size()> all;
    std::ranges::transform(kTable, all.begin(), [](double value) { return std::log(value); });
    return all;
  }();
  double sum = 0.0;
  for (int i = cell - 1; i <= cell + 2; ++i) {
    double weight = 1.0;
    for (int j = cell - 1; j <= cell + 2; ++j) {
      if (j != i) weight *= (place - j) / (i - j);
    }
    sum += weight * kLogarithms[static_cast<std::size_t>(i)];
  }
  return std::exp(sum);
}

std::shared_ptr<const AirSource> fluid_seen_in(std::shared_ptr<const TurbulentFlow> flow, std::uint64_t seed,
                                               const SeenOptions& options) {
  if (!flow) throw ArgumentError("there is no turbulent flow; a flow was expected");
  require_not_negative(options.C_0, "C_0");
  require_positive(options.viscosity, "viscosity [m^2/s]");
  require_not_negative(options.radius, "radius of the body [m]");
  if (options.rotation && options.radius == 0.0)
    throw ArgumentError(
        "a rotational gust was asked for with a radius of 0 m; the radius of the body was expected");
  return std::make_shared<FluidSeenSource>(std::move(flow), seed, options);
}

}  // namespace samara::models
