#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/pgd/fields/train_field.h"

/// Fewer numbers for fields that are solved: slabs of time put together, elements and nodes that are not
/// needed left out, ranks cut.
namespace samara::pgd {

struct CompactOptions {
  /// Largest change of an output, over its scale; how much of it was used is measured at trial points.
  double tolerance = 1e-4;
  std::uint64_t seed = 1;                   ///< of the trial points
  std::vector<std::string> kept_axes = {};  ///< names of parameter axes whose nodes stay
};

/// The same functions with fewer numbers.
///
/// Neighbouring fields over one box of parameters, whose times follow each other, become one field where that
/// takes at most half as many numbers again; where they met, the earlier one's values stand. Then, field by
/// field: elements of time are put together, parameter axes of one Chebyshev element lose nodes, and ranks
/// are cut (field_rounding.h).
/// @param fields trains of the same outputs and coordinates, time first, ascending in time
/// @param scale per output, positive
/// @throws ArgumentError if sizes or numbers are not as said
std::vector<TrainField> compacted(const std::vector<TrainField>& fields, const Eigen::VectorXd& scale,
                                  const CompactOptions& options);

}  // namespace samara::pgd
