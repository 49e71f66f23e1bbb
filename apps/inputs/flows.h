#pragma once

#include <string>
#include <vector>

#include "samara/flow/files/flow_file.h"

namespace samara::apps {

/// A flow of a flow file, or that of a codebook of fields at values of its box.
/// @param set NAME=VALUE of these, as `option` was given them: none for a flow file
/// @throws ArgumentError for values that are none of the file's; InputError for another file
flow::StoredFlow flow_of_file(const std::string& path, const std::vector<std::string>& set,
                              const std::string& option);

}  // namespace samara::apps
