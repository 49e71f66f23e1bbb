#pragma once

#include <string>

#include "samara/flow/files/flow_file.h"

namespace samara::flow {

/// The text of an XDMF file by which ParaView opens a flow file that lies beside it: all fields in the centres of
/// cells.
/// @param file name of the flow file as seen from there
std::string format_xdmf(const StoredFlow& flow, const std::string& file);

}  // namespace samara::flow
