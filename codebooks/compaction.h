#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "samara/codebooks/solution.h"

namespace samara::codebooks {

struct CompactionRequest {
  double tolerance = 0.0;                       ///< of the plan
  double share = 0.9;                           ///< to spend of what the builder left of it
  std::map<std::string, double> absolute = {};  ///< least range per output
  std::uint64_t seed = 1;
};

/// A solution by slabs with fewer numbers (pgd/slab_join.h), by a part of what the builder left of the
/// tolerance. Other solutions, and those that did not converge, stay as they are. Errors are over the ranges
/// of the outputs as the fields show them.
Solution compacted(const Solution& solution, const CompactionRequest& request);

}  // namespace samara::codebooks
