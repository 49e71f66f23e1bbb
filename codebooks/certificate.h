#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace samara::codebooks {

/// How far one output of a codebook is from the independent integrator. Errors are divided by
/// max(range of the output over box and time, the plan's absolute tolerance for it), unless they say SI. All
/// numbers are NaN, and `worst` is empty, where no integration succeeded.
struct OutputError {
  std::string name;
  std::string unit;
  double range = 0.0;   ///< max(range over the certificate's points and times, absolute tolerance), SI
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
  double discretisation = 0.0;
  double compression = 0.0;
  double nonlinearity = 0.0;
  double total() const { return discretisation + compression + nonlinearity; }
};

/// Error of a codebook against CVODES at tight tolerance, on scrambled Sobol' points that no builder saw, at
/// all times of a grid finer than the builder's.
struct Certificate {
  double tolerance = 0.0;  ///< what the plan asked for
  bool met = false;        ///< builder converged, no integration failed, and every output's max <= tolerance
  double max_error = 0.0;  ///< largest OutputError::max; NaN where no integration succeeded
  int points = 0;
  int times = 0;
  int failed_points = 0;  ///< where the integrator gave no trajectory, or was not asked
  std::string failure;    ///< what the integrator said where it failed first; not stored in files
  std::uint64_t seed = 0;
  std::string integrator;
  double integrator_tolerance = 0.0;
  double residual = 0.0;  ///< of the equations, as the builder reports it, in scales of the states
  ErrorBudget spent;
  std::optional<NormDefect> norm_defect;  ///< of a codebook that holds a whole quaternion
  std::vector<OutputError> outputs;
};

}  // namespace samara::codebooks
