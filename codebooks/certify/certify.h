#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "samara/base/progress.h"
#include "samara/codebooks/book/book_model.h"

namespace samara::codebooks {

struct CertifyOptions {
  int points = 2000;                            ///< scrambled Sobol' points in the box
  std::uint64_t seed = 2026;                    ///< of the scrambling
  double tolerance = 0.0;                       ///< wanted largest error, recorded and compared with
  std::map<std::string, double> absolute = {};  ///< floor of an output's range, SI
  /// Characteristic size of an output, SI: a range that is its rounding is none. Those of a model are known.
  std::map<std::string, double> sizes = {};
  /// Relative, per step. Empty: a hundredth of `tolerance` (less where an output moves by little of its size),
  /// between 1e-13 and 1e-10, so that the certificate measures the codebook and not the integrator.
  std::optional<double> integrator_tolerance = {};
  /// From the worst points, where these stand far above the others; a climb asks at up to some hundred points more.
  int climbs = 4;
  int threads = 0;  ///< 0: all cores
  ProgressCallback progress = {};
};

/// Measures a codebook against CVODES, see Certificate. The result does not depend on the number of threads.
/// `met` here means tolerance and integrations only; the builder adds whether it came to an end.
/// @throws ArgumentError if points < 1, or the model does not fit the codebook's coordinates.
Certificate certify(const Codebook& book, const models::ParametricModel& model,
                    const CertifyOptions& options);

}  // namespace samara::codebooks
