#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace samara::codebooks {

/// How far one output of a codebook is from the independent integrator. Errors are divided by
/// max(range of the output over box and time, the plan's absolute tolerance for it), or its size where it is constant
/// up to rounding (pgd/fields/error_scale.h), unless they say SI. All
/// numbers are NaN, and `worst` is empty, where no integration succeeded. `max`, `max_si` and `worst` count
/// the ends of climbs, too.
struct OutputError {
  std::string name;
  std::string unit;
  double range = 0.0;   ///< what errors are divided by, SI; of a constant its size, of zero 1
  double max = 0.0;     ///< over all points and times
  double p95 = 0.0;     ///< 95 % quantile over points of the largest error over times
  double mean = 0.0;    ///< mean over points of the largest error over times
  double rms = 0.0;     ///< root mean square over points and times, relative to that of the output itself
  double max_si = 0.0;  ///< largest error in the output's unit
  std::vector<double> worst;  ///< coordinates of the largest error, in the order of Codebook::coordinates()
};

/// How far quaternions, as they are stored, are from the length with which they began: | |q| / |q(0)| - 1 |.
/// Queries give them that length; this is measured before they do. It grows where a codebook fails.
struct NormDefect {
  double max = 0.0;  ///< over all points and times; NaN where no integration succeeded
  double rms = 0.0;  ///< root mean square over points and times
};

/// What the builder spent of the tolerance, in the same measure.
struct ErrorBudget {
  double discretisation = 0.0;  ///< by elements of the time
  double compression = 0.0;     ///< by ranks, and by what was left out of them afterwards
  double nonlinearity = 0.0;    ///< what a march says of its equations, at its guard points
  double total() const { return discretisation + compression + nonlinearity; }
};

/// Points of a certificate, unless the plan asks for another assurance: none of 2000 wrong says that with
/// 95 % confidence at most 0.15 % of the box are.
inline constexpr int kCertificatePoints = 2000;

/// Error of a codebook against CVODES at tight tolerance, against the command it was sampled from, or, of a field
/// of space, against what `integrator` names, on scrambled Sobol' points that no builder saw, at all times of a grid
/// finer than the builder's. Where a few errors stand far above the others, climbs lead from the worst points to the
/// largest errors around them (pgd/sampling/error_climb.h).
struct Certificate {
  double tolerance = 0.0;  ///< what the plan asked for
  /// The builder came to an end (sampling to its tolerance; a march to the end of its time, with no guard point
  /// beyond the tolerance), no integration failed, and every output's max <= tolerance.
  bool met = false;
  double max_error = 0.0;  ///< largest OutputError::max; NaN where no integration succeeded
  int points = 0;
  int times = 0;
  int places = 0;         ///< of space, at all of which a field was compared at every point and time; 0: none
  int failed_points = 0;  ///< where the integrator gave no trajectory, or was not asked
  /// Points where some output errs by more than the tolerance, failed ones included; nothing where errors are
  /// not compared with a tolerance, and in files of earlier programs.
  std::optional<int> wrong_points;
  int climbed_points = 0;  ///< ends of climbs, beside `points`
  int refuted_before = 0;  ///< certificates that found earlier fields of the same build wrong
  std::string failure;     ///< what the integrator said where it failed first; not stored in files
  std::uint64_t seed = 0;
  std::string integrator;
  double integrator_tolerance = 0.0;
  double residual = 0.0;  ///< of the equations, in scales of the states, in files of former builders; else 0
  ErrorBudget spent;
  std::optional<NormDefect> norm_defect;  ///< of a codebook that holds a whole quaternion
  std::vector<OutputError> outputs;
};

/// The share of the box that may err by more than the tolerance, with 95 % confidence: Clopper and Pearson's
/// limit for `wrong` of `points` random points; about 3/points for none. A build that was refuted and
/// certified again must meet more: every earlier refutation halves the allowed chance of error.
/// @throws ArgumentError unless 0 <= wrong <= points, points > 0 and refuted_before >= 0
double share_above(int wrong, int points, int refuted_before = 0);

}  // namespace samara::codebooks
