#pragma once

#include <functional>
#include <memory>

#include "samara/models/laws/ambient_flow.h"

/// Mean flows with turbulence: what a body meets is the mean velocity and, at random, what the energy says.
///
///   class Wake : public samara::models::TurbulentFlow { ... };
///   auto cloud = realise(model, {}, *fluid_seen_in(std::make_shared<Wake>()), times);
///
/// World axes, z up, SI units. The mean velocity is that of AmbientFlow::sample; nothing in it is random.
namespace samara::models {

/// Energy of the turbulence at a point and a time.
struct Turbulence {
  double k = 0.0;  ///< kinetic energy per mass, 3/2 sigma^2, sigma the deviation of a component [m^2/s^2]
  double epsilon = 0.0;  ///< its rate of dissipation; positive wherever k is [m^2/s^3]
  Eigen::Vector3d sigma_gradient = Eigen::Vector3d::Zero();  ///< of sigma = sqrt(2 k/3), in space [1/s]
  bool inside = true;  ///< false where the flow ends: a realisation that comes here has left it
};

/// Immutable: called from several threads at once.
class TurbulentFlow : public AmbientFlow {
 public:
  /// @param position world axes [m]
  /// @returns k >= 0, epsilon > 0 wherever k > 0; both finite wherever `inside`. Realisations that come to anything
  ///   else end as not_finite.
  virtual Turbulence turbulence(double t, const Eigen::Vector3d& position) const = 0;

  /// Whether mean and energy are the same at every place, without gradients: they are then asked for once for all
  /// bodies.
  virtual bool is_uniform() const { return false; }
};

/// Decay without a stream and without production: k = k_0 X^(-1/(C_2-1)), epsilon = epsilon_0 X^(-C_2/(C_2-1)),
/// X = 1 + (C_2-1) epsilon_0 t/k_0, C_2 = 1.92 (the k-epsilon model of B. E. Launder, D. B. Spalding, Comput. Methods
/// Appl. Mech. Eng. 3 (1974) 269-289). The gradient is zero.
/// @throws ArgumentError unless k_0 >= 0 and epsilon_0 > 0 are finite, and t >= 0.
Turbulence decaying_energy(double k_0, double epsilon_0, double t);

/// The same energy everywhere and always, in a uniform steady stream [m/s].
/// @throws ArgumentError unless k >= 0 and epsilon > 0 are finite, and the stream is finite.
std::shared_ptr<const TurbulentFlow> uniform_turbulence(
    double k, double epsilon, const Eigen::Vector3d& stream = Eigen::Vector3d::Zero());

/// Energy that decays from t = 0 on as decaying_energy() says, the same everywhere, in a uniform steady stream.
/// @throws ArgumentError as above.
std::shared_ptr<const TurbulentFlow> decaying_turbulence(
    double k_0, double epsilon_0, const Eigen::Vector3d& stream = Eigen::Vector3d::Zero());

/// A flow from functions of (t, position), for what has no class of its own.
/// @param mean AmbientFlow::sample  @param energy turbulence()  @param length AmbientFlow::length [m]
/// @throws ArgumentError if a function is empty or the length is not positive and finite.
std::shared_ptr<const TurbulentFlow> turbulent_flow(
    std::function<AmbientSample(double t, const Eigen::Vector3d& position)> mean,
    std::function<Turbulence(double t, const Eigen::Vector3d& position)> energy, double length);

}  // namespace samara::models
