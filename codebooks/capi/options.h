#pragma once

#include "samara/codebooks/capi/samara.h"
#include "samara/codebooks/query/query.h"

namespace samara::codebooks {

/// What a caller in C asks of a query; internal to codebooks/. @param options null: nothing special
/// @throws ArgumentError for null names, names that are held twice or without a value, an unknown precision
QueryOptions options_of(const samara_options* options);

}  // namespace samara::codebooks
