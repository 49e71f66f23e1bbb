#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <pybind11/pybind11.h>

#include "samara/identification/captures/capture.h"
#include "samara/motion/patterns/pattern_rules.h"

/// What the files of this room take from Python alike.
namespace samara::python {

/// The rule's, those named with other values. @throws ArgumentError naming the nearest
motion::PatternThresholds thresholds_of(const std::map<std::string, double>& values);

/// Captures of files, then those of memory. @param sidecar of every table; empty: those beside them
std::vector<identification::Capture> captures_from(const std::vector<std::filesystem::path>& files,
                                                   const pybind11::list& tables,
                                                   const std::filesystem::path& sidecar);

/// Clusters, agreement with a person's labels, adjusted Rand index.
void add_pattern_tools(pybind11::module_& module);

}  // namespace samara::python
