#pragma once

#include <string>

#include "samara/codebooks/book/codebook.h"

namespace samara::codebooks {

/// Where and when a codebook is made: here and now. @param plan text of the plan, or empty
/// @param seconds that the build took
Provenance made_now(std::string plan, double seconds);

}  // namespace samara::codebooks
