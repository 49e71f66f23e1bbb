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
  double residual = 0.0;  ///< of the equations, in scales of the states; 0 where none was formed
  /// Of a builder that had its claim certified, and was not refuted.
  std::optional<Certificate> certificate = {};
};

}  // namespace samara::codebooks
