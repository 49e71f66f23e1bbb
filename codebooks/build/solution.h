#pragma once

#include <optional>
#include <vector>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// What a builder hands over, before the certificate.
struct Solution {
  std::vector<Piece> pieces;
  BuildRecord record;
  ErrorBudget spent;
  /// Of a builder that had its claim certified, and was not refuted.
  std::optional<Certificate> certificate = {};
};

}  // namespace samara::codebooks
