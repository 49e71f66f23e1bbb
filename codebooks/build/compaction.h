#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/codebooks/build/solution.h"
#include "samara/codebooks/plan/plan.h"

namespace samara::codebooks {

struct CompactionRequest {
  double tolerance = 0.0;                       ///< of the plan
  double share = 0.9;                           ///< to spend of what the builder left of it
  std::map<std::string, double> absolute = {};  ///< least range per output
  std::uint64_t seed = 1;
  std::vector<std::string> kept_axes = {};  ///< whose nodes the plan prescribes
};

/// What a plan asks of compaction. @param share as in CompactionRequest
CompactionRequest compaction_of(const Plan& plan, double share);

/// The same solution with fewer numbers, by a part of what the builder left of the tolerance: slabs are joined and
/// made compact (pgd/evolution/slab_join.h), sums of products get fewer terms (pgd/tensors/compression.h). Nothing if
/// that saves nothing, for trains of sampling, which are rounded already, and for solutions that did not converge.
/// Errors are over the ranges of the outputs as the fields show them.
std::optional<Solution> compacted(const Solution& solution, const CompactionRequest& request);

}  // namespace samara::codebooks
