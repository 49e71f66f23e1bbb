#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/codebooks/book/attitude_length.h"
#include "samara/codebooks/query/prepared_fields.h"
#include "samara/codebooks/query/query.h"
#include "samara/codebooks/query/trajectory_query.h"

/// What Query and TrajectoryQuery have in common.
namespace samara::codebooks {

/// Prepared fields, shared by the copies of a query.
struct Prepared {
  std::shared_ptr<const PreparedFields> fields;
  Precision precision = Precision::double_precision;
  std::optional<AttitudeLength> attitude = {};
};

/// Reads the options, and prepares what they ask for.
Prepared prepare(const Codebook& book, const QueryOptions& options, std::optional<std::vector<double>> times);

/// Calls run(first, last) for ranges of 0 .. count - 1, on as many threads as asked for.
/// @throws ArgumentError for fewer than 0 threads; of what ranges throw, that of the first one
void in_ranges(Eigen::Index count, int threads, const std::function<void(Eigen::Index, Eigen::Index)>& run);

}  // namespace samara::codebooks
