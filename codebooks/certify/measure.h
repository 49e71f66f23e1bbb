#pragma once

#include <Eigen/Core>

#include "samara/codebooks/certify/certify.h"
#include "samara/codebooks/certify/certify_field.h"
#include "samara/codebooks/source/call_memory.h"

/// Certificates, and where they found a codebook wrong.
namespace samara::codebooks {

struct Measured {
  Certificate certificate;
  /// Points and ends of climbs (parameters x points) with errors above the tolerance, the worst first; at
  /// most twenty.
  Eigen::MatrixXd wrong;
};

/// When to stop comparing.
enum class Extent {
  all_points,
  until_wrong,  ///< after the first slice with an error above the tolerance; the others count as failed
};

/// Against CVODES, see certify().
Measured measure(const Codebook& book, const models::ParametricModel& model, const CertifyOptions& options,
                 Extent extent);

/// Against the command it was sampled from, which is called at the certificate's points. The first point
/// without an answer ends it; later points count as failed, too.
Measured measure(const Codebook& book, CallMemory& calls, const CertifyOptions& options, Extent extent);

/// Of a field of space, against its reference.
Measured measure(const Codebook& book, const FieldReference& reference, const CertifyOptions& options,
                 Extent extent);

}  // namespace samara::codebooks
