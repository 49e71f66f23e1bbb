#pragma once

#include <string>
#include <vector>

#include "samara/identification/captures/exports/export_formats.h"

/// Internal to identification/.
namespace samara::identification {

/// @param lines the first three are enough
bool is_kinovea_export(const std::vector<std::string>& lines);
/// @param lines of the file, without ends
Export read_kinovea_export(const std::vector<std::string>& lines, const ExportHints& hints);

}  // namespace samara::identification
