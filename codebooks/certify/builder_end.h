#pragma once

#include <string>

#include "samara/codebooks/book/certificate.h"
#include "samara/codebooks/book/codebook.h"

/// What the way in which a builder ended says of the certificate of its codebook.
namespace samara::codebooks {

/// Whether the certificate decides if a codebook meets its tolerance. A march that went to the end of its time holds
/// its guard points well below the tolerance: where it only missed that, the certificate, which has more points, is
/// the judge. An error beyond the tolerance at a guard point is evidence that points of a certificate which miss it
/// do not outvote. Sampling that did not converge may have seen a feature that 2000 points do not.
bool is_left_to_certificate(const BuildRecord& record, const ErrorBudget& spent, double tolerance);

/// Whether a certificate is not met although none of its points errs by more than was asked: the builder ended at a
/// limit. One that saw larger errors itself (missed, refuted) is not of that kind.
bool is_only_unfinished(const BuildRecord& record, const Certificate& certificate);

/// "met"; "met at 300 points", where these are fewer than kCertificatePoints; "not converged"
/// (is_only_unfinished()); or "missed".
std::string verdict(const BuildRecord& record, const Certificate& certificate);

}  // namespace samara::codebooks
