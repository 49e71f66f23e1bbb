#include "samara/codebooks/certify/builder_end.h"

#include <fmt/format.h>

#include "samara/base/termination.h"

namespace samara::codebooks {

bool is_left_to_certificate(const BuildRecord& record, const ErrorBudget& spent, double tolerance) {
  if (record.status == Termination::converged) return true;
  return record.builder == "pgd" && record.status == Termination::missed && spent.nonlinearity <= tolerance;
}

bool is_only_unfinished(const BuildRecord& record, const Certificate& certificate) {
  const bool has_erred = record.status == Termination::missed || record.status == Termination::refuted;
  return !certificate.met && record.status != Termination::converged && !has_erred &&
         certificate.failed_points == 0 && certificate.max_error <= certificate.tolerance;
}

std::string verdict(const BuildRecord& record, const Certificate& certificate) {
  if (!certificate.met) return is_only_unfinished(record, certificate) ? "not converged" : "missed";
  if (certificate.points >= kCertificatePoints) return "met";
  return fmt::format("met at {} points", certificate.points);
}

}  // namespace samara::codebooks
