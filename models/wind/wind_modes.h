#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "samara/models/laws/ambient_flow.h"
#include "samara/models/wind/wind_spectrum.h"

/// A random field of turbulent wind for bodies that fly through it: Fourier modes with von Karman's spectrum, without a
/// grid or a box, and with exact derivatives.
///
///   u(x, t) = sum over m of a_m cos(k_m.y + f_m t) + b_m sin(k_m.y + f_m t),     y = x - U_c t
///
/// a and b are perpendicular to k: div u = 0. Directions of k are uniform over the sphere; |k| has one mode in every
/// stratum of a density that is half that of the energy, half uniform in ln k, so that few modes carry the large eddies
/// and the small ones alike. The frequencies f = 0.4 sigma |k| times a standard normal number let eddies pass each
/// other as the large ones sweep the small. R. H. Kraichnan, Diffusion by a random velocity field, Phys. Fluids 13
/// (1970); the projector is also that of GSTools.
///
/// One realisation has few large eddies: its variance scatters by some 14 %. Statistics are over realisations.
///
///   const ModeSpectrum spectrum(VonKarmanSpectrum(1.2, 10.0), {.highest = 2.0 * pi / 0.08});
///   const WindModes wind(spectrum, seed, realisation);
namespace samara::models::wind {

inline constexpr int kMostModes = 100000;

struct ModeOptions {
  int modes = 200;
  /// Band of wave numbers [rad/m]. Outside it there is nothing: [0.02/L, 200/L] holds 96 % of the variance, but of the
  /// difference over 0.03 L only 54 % (VonKarmanSpectrum::structure_function). 0: 0.02/L.
  double lowest = 0.0;
  double highest = 0.0;  ///< has no default; 2 pi/(length of the body) is where the body averages waves away
  bool frozen = false;   ///< f = 0: the field is only carried along by U_c
  Eigen::Vector3d convection = Eigen::Vector3d::Zero();  ///< U_c [m/s]
  /// Multiplies all velocities, for deviations that differ by component: a symmetric matrix, in world axes. Any other
  /// than a multiple of the identity leaves a divergence, see ModeSpectrum::divergence().
  Eigen::Matrix3d stretch = Eigen::Matrix3d::Identity();
};

/// What all realisations share. Immutable.
class ModeSpectrum {
 public:
  /// @throws ArgumentError unless there are 1 to kMostModes modes, 0 < lowest < highest are finite, U_c is finite, and
  /// the stretch is symmetric and not zero.
  ModeSpectrum(const VonKarmanSpectrum& spectrum, const ModeOptions& options);

  const VonKarmanSpectrum& spectrum() const { return spectrum_; }
  /// With `lowest` in place.
  const ModeOptions& options() const { return options_; }
  /// What the band holds of the variance.
  double variance_share() const;
  /// Root mean square of the divergence over that of the gradient: 0 unless the field is stretched.
  double divergence() const;
  /// Deviation of f/|k|, 0.4 sigma, or 0 of a frozen field [m/s].
  double sweeping_speed() const;

  struct Stratum {
    double wave_number = 0.0;  ///< [rad/m]
    double energy = 0.0;       ///< E dk that one mode stands for [m^2/s^2]
  };
  /// The wave number at a share, between 0 and 1, of the density.
  Stratum at_share(double share) const;

 private:
  VonKarmanSpectrum spectrum_;
  ModeOptions options_;
  std::vector<double> shares_;  ///< of the density below the nodes, equally spaced in ln k
};

/// An ellipse in space: semi-axis vectors in world axes [m].
struct Ellipse {
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  Eigen::Vector3d second = Eigen::Vector3d::Zero();
};

/// One realisation. Immutable.
class WindModes final : public AmbientFlow {
 public:
  /// The same bits for the same seed and number, whichever else are drawn.
  /// @param mirrored all amplitudes with the other sign
  WindModes(const ModeSpectrum& spectrum, std::uint64_t seed, std::uint64_t realisation,
            bool mirrored = false);

  AmbientSample sample(double t, const Eigen::Vector3d& position) const override;
  /// Mean over the area of an ellipse about the position, each mode by its exact factor 2 J1(q)/q (to 1e-7): what a
  /// flat body of this outline and attitude meets.
  AmbientSample mean_over(const Ellipse& ellipse, double t, const Eigen::Vector3d& position) const;
  /// The shortest wave [m].
  double length() const override { return length_; }

 private:
  std::vector<double> rows_;
  std::size_t count_ = 0;
  Eigen::Vector3d convection_;
  double length_;
};

}  // namespace samara::models::wind
