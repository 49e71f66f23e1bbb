#include "samara/models/stochastic/fluid_seen.h"

#include <algorithm>
#include <array>
#include <utility>

#include "samara/base/errors.h"
#include "samara/base/normals.h"
#include "samara/base/require.h"
#include "samara/models/stochastic/langevin.h"

namespace samara::models {

namespace {

enum NoiseStream : std::uint16_t { kGustNoise = 1, kSpinNoise = 2 };

/// Standard normals of one realisation, step after step, made a few ahead.
class NoiseAhead {
 public:
  NoiseAhead(std::uint64_t seed, std::uint64_t number, bool mirrored, NoiseStream stream)
      : seed_(seed), place_{.realisation = number, .stream = stream}, sign_(mirrored ? -1.0 : 1.0) {}

  Eigen::Vector3d next() {
    if (used_ == ahead_.size()) {
      normals_from(seed_, place_, ahead_);
      place_.step += ahead_.size();
      used_ = 0;
    }
    const std::array<double, 4>& z = ahead_[used_++];
    return sign_ * Eigen::Vector3d(z[0], z[1], z[2]);
  }

 private:
  std::uint64_t seed_;
  RandomPlace place_;
  double sign_;
  std::array<std::array<double, 4>, 16> ahead_;
  std::size_t used_ = ahead_.size();
};

/// What an exponential relaxation keeps over a step, and the noise that makes up for the rest.
struct Relaxation {
  explicit Relaxation(double steps) : kept(std::exp(-steps)), noise(std::sqrt((1.0 - kept) * (1.0 + kept))) {}
  double kept, noise;
};

class FluidSeen final : public AirAlongPath {
 public:
  FluidSeen(const TurbulentFlow& flow, std::uint64_t seed, const SeenOptions& options, std::uint64_t number,
            bool mirrored)
      : flow_(flow),
        options_(options),
        gusts_(seed, number, mirrored, kGustNoise),
        spins_(seed, number, mirrored, kSpinNoise) {}

  AirSeen start(const BodyOnPath& body) override {
    w_ = gusts_.next();
    if (options_.rotation) spin_ = spins_.next();
    const Turbulence here = flow_.turbulence(body.t, body.position);
    has_gradient_ = !here.sigma_gradient.isZero(0.0);
    AirSeen seen = seen_at(body.t, body.position, here);
    mean_u_r_ = body.velocity - seen.velocity;
    return seen;
  }

  AirSeen step(const BodyOnPath& body, double h) override {
    const double t = body.t + 0.5 * h;
    const Eigen::Vector3d middle = body.position + 0.5 * h * body.velocity;
    const Turbulence energy = flow_.turbulence(t, middle);
    const LangevinScales scales = scales_of(energy);
    has_gradient_ = !energy.sigma_gradient.isZero(0.0);
    const double sigma = attenuated(scales);
    move_gust(body, h, energy, scales, sigma);
    if (options_.rotation && energy.k > 0.0) move_spin(h, energy.epsilon);
    const AmbientSample mean = flow_.sample(t, middle);
    // The body's own change of velocity by this gust moves it, too: without it what the fluid carries does not stay mixed.
    const Eigen::Vector3d change = mean.velocity + sigma * w_ - body.air;
    const Eigen::Vector3d end = body.position_after(h, change);
    AirSeen seen = seen_at(body.t + h, end, flow_.turbulence(body.t + h, end));
    seen.gradient = mean.gradient;
    seen.time_scale =
        std::min(shortest_time_, scales.time_scale(energy.sigma_gradient, body.velocity.norm()));
    return seen;
  }

  bool needs_response() const override { return has_gradient_; }

 private:
  /// Where the energy is the same as at the last place, so are they.
  const LangevinScales& scales_of(const Turbulence& energy) {
    if (energy.k != of_.k || energy.epsilon != of_.epsilon) {
      of_ = energy;
      scales_ = LangevinScales(energy, options_);
    }
    return scales_;
  }

  /// sigma of what the body sees of it.
  double attenuated(const LangevinScales& scales) {
    if (options_.radius == 0.0 || !(scales.L > 0.0)) return scales.sigma;
    const double ratio = options_.radius / scales.L;
    if (ratio != ratio_) {
      ratio_ = ratio;
      left_ = std::sqrt(disc_attenuation(ratio));
    }
    return scales.sigma * left_;
  }

  AirSeen seen_at(double t, const Eigen::Vector3d& position, const Turbulence& energy) {
    AirSeen seen;
    seen.velocity = flow_.sample(t, position).velocity + attenuated(scales_of(energy)) * w_;
    if (options_.rotation && energy.k > 0.0) seen.rotation = 0.99 * eddy_rate(energy.epsilon) * spin_;
    seen.inside = energy.inside;
    return seen;
  }

  void move_gust(const BodyOnPath& body, double h, const Turbulence& energy, const LangevinScales& scales,
                 double sigma) {
    shortest_time_ = scales.T;
    if (!(scales.sigma > 0.0)) return;  // still fluid keeps w for where it is not
    if (h / scales.T != blend_steps_) {
      blend_steps_ = h / scales.T;
      blend_ = -std::expm1(-blend_steps_);
    }
    mean_u_r_ += blend_ * (body.velocity - body.air - mean_u_r_);
    const double speed = mean_u_r_.norm();
    const double b = 0.565 * 6.0 / scales.C_0;
    const double bs = options_.crossing ? b * speed / scales.sigma : 0.0;
    const double shorter_along = std::sqrt(1.0 + bs * bs), shorter_across = std::sqrt(1.0 + 4.0 * bs * bs);
    const double T_along = scales.T / shorter_along, T_across = scales.T / shorter_across;
    shortest_time_ = T_across;
    const Relaxation along(blend_steps_ * shorter_along), across(blend_steps_ * shorter_across);
    Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
    if (speed > 0.0) axis = mean_u_r_ / speed;
    const Eigen::Vector3d xi = gusts_.next();
    Eigen::Vector3d next = across.kept * w_ + across.noise * xi;
    next += ((along.kept - across.kept) * axis.dot(w_) + (along.noise - across.noise) * axis.dot(xi)) * axis;
    if (has_gradient_) {
      const Eigen::Vector3d drift =
          share_of_drift(body, scales.T) * (sigma / scales.sigma) * energy.sigma_gradient;
      next += (1.0 - across.kept) * T_across * drift;
      next += ((1.0 - along.kept) * T_along - (1.0 - across.kept) * T_across) * axis.dot(drift) * axis;
    }
    w_ = next;
  }

  /// The drift is that of the fluid's own particles: a body has of it what it follows at once, and of the rest what its
  /// drag follows in the time of an eddy (P. A. Bocksell, E. Loth, Int. J. Multiphase Flow 32 (2006) 1234-1253).
  static double share_of_drift(const BodyOnPath& body, double T) {
    const double at_once = body.follows.trace() / 3.0;
    return at_once + (1.0 - at_once) / (1.0 + body.response_time / T);
  }

  void move_spin(double h, double epsilon) {
    const Relaxation spin(h * eddy_rate(epsilon));
    spin_ = spin.kept * spin_ + spin.noise * spins_.next();
  }

  /// (epsilon/l^2)^(1/3)
  double eddy_rate(double epsilon) const {
    const double length = 2.0 * options_.radius;
    return std::cbrt(epsilon / (length * length));
  }

  const TurbulentFlow& flow_;
  SeenOptions options_;
  NoiseAhead gusts_, spins_;
  Eigen::Vector3d w_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d spin_ = Eigen::Vector3d::Zero();
  /// Relative to the fluid seen, averaged over an eddy's time: what a particle of the fluid has is zero.
  Eigen::Vector3d mean_u_r_ = Eigen::Vector3d::Zero();
  Turbulence of_ = {};  ///< what the scales are of
  LangevinScales scales_{of_, options_};
  double blend_steps_ = 0.0, blend_ = 0.0;  ///< of that average, by h/T
  double ratio_ = 0.0, left_ = 1.0;         ///< radius over scale, and the share of sigma that is left of it
  double shortest_time_ = 0.0;
  bool has_gradient_ = false;
};

class FluidSeenSource final : public AirSource {
 public:
  FluidSeenSource(std::shared_ptr<const TurbulentFlow> flow, std::uint64_t seed, const SeenOptions& options)
      : flow_(std::move(flow)), seed_(seed), options_(options) {}

  std::unique_ptr<AirAlongPath> realisation(std::uint64_t number, bool mirrored) const override {
    return std::make_unique<FluidSeen>(*flow_, seed_, options_, number, mirrored);
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
  return 6.5 * std::pow(1.0 + 140.0 * std::pow(Re_lambda, -4.0 / 3.0), -0.75);
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
