#pragma once

#include "samara/codebooks/call_memory.h"
#include "samara/codebooks/certify.h"

namespace samara::codebooks {

/// Measures a codebook against the command it was sampled from, which is called at the certificate's points.
/// The first point without an answer ends it; the points behind count as failed, too.
Certificate certify(const Codebook& book, CallMemory& calls, const CertifyOptions& options);

}  // namespace samara::codebooks
