#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>

#include "samara/base/progress.h"
#include "samara/codebooks/book/codebook.h"
#include "samara/models/interface/parametric_model.h"

namespace samara::codebooks {

struct CertifyOptions {
  int points = 2000;                            ///< scrambled Sobol' points in the box
  std::uint64_t seed = 2026;                    ///< of the scrambling
  double tolerance = 0.0;                       ///< wanted largest error, recorded and compared with
  std::map<std::string, double> absolute = {};  ///< floor of an output's range, SI
  /// Relative, per step. Empty: a hundredth of `tolerance`, between 1e-13 and 1e-10, so that the certificate
  /// measures the codebook and not the integrator.
  std::optional<double> integrator_tolerance = {};
  int threads = 0;  ///< 0: all cores
  ProgressCallback progress = {};
};

/// Measures a codebook against CVODES, see Certificate. The result does not depend on the number of threads.
/// `met` here means tolerance and integrations only; the builder adds whether it came to an end.
/// @throws ArgumentError if points < 1, or the model does not fit the codebook's coordinates.
Certificate certify(const Codebook& book, const models::ParametricModel& model,
                    const CertifyOptions& options);

/// The model a codebook is a solution of, with the codebook's coordinates free.
/// @throws ArgumentError if this library does not know the model, or the codebook holds what was sampled from
/// a command or a series of coefficients, which have no equations.
models::ParametricModel model_of(const Codebook& book);

}  // namespace samara::codebooks
