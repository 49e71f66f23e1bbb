#pragma once

#include <cstddef>

/// The inner loop of wind_modes.h: sums over Fourier modes, a register of modes at a time.
namespace samara::models::wind {

/// Rows of `count` numbers, one after another: wave vector x, y, z; angular frequency; amplitudes a x, y, z of the
/// cosine; b x, y, z of the sine. `count` is a multiple of kModeLanes; modes that only fill up are zero.
struct ModeRows {
  const double* numbers = nullptr;
  std::size_t count = 0;
};
inline constexpr std::size_t kModeLanes = 8;
inline constexpr std::size_t kModeRows = 10;

struct ModeSum {
  double velocity[3];
  double gradient[9];  ///< d velocity_i/d x_j at 3 j + i
  double rate[3];      ///< by time, at a place that moves with the mean wind
};

/// sum of a cos(k.y + f t) + b sin(k.y + f t) at y = `place`, and its derivatives.
void sum_modes(const ModeRows& modes, const double* place, double t, ModeSum& sum);

/// The same with every mode averaged over an ellipse about that place, whose semi-axes are the vectors `first` and
/// `second`: times 2 J1(q)/q, q^2 = (k.first)^2 + (k.second)^2.
void sum_modes_over_ellipse(const ModeRows& modes, const double* place, double t, const double* first,
                            const double* second, ModeSum& sum);

}  // namespace samara::models::wind
