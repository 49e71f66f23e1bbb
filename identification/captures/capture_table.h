#pragma once

#include <vector>

#include "samara/identification/captures/capture.h"
#include "samara/identification/captures/sidecar.h"
#include "samara/io/delimited_table.h"

/// From a table and what its columns mean to captures; internal to identification/.
namespace samara::identification {

/// @throws InputError as read_captures()
std::vector<Capture> captures_from_table(const io::DelimitedTable& table, const Sidecar& sidecar);

}  // namespace samara::identification
