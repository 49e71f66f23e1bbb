#pragma once

#include <string>

#include "samara/flow/files/flow_file.h"
#include "terminal/output.h"

namespace samara::apps {

/// What a flow file says, for people and for programs.
std::string to_table(const flow::StoredFlow& stored, const std::string& path);
Json to_json(const flow::StoredFlow& stored);

}  // namespace samara::apps
