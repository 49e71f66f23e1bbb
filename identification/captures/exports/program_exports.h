#pragma once

#include <string>
#include <vector>

#include "samara/identification/captures/exports/export_formats.h"

/// Each program's own; internal to identification/. @param lines of the file, without ends
namespace samara::identification {

/// @param lines the first three are enough
bool is_tracker_export(const std::vector<std::string>& lines);
Export read_tracker_export(const std::vector<std::string>& lines, const ExportHints& hints);

bool is_motive_export(const std::vector<std::string>& lines);
Export read_motive_export(const std::vector<std::string>& lines, const ExportHints& hints);

}  // namespace samara::identification
