#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "samara/io/svg_chart.h"

/// What the JSON of a fit shows, as panels of a picture (io/svg_chart.h).
namespace samara::identification {

/// What was measured and what the fitted model says, a panel per output.
/// @param capture its id, with its file where several have it ("drop, second.csv"); empty: the first
/// @throws InputError if the file is none of a fit; ArgumentError if there is no such capture, or several
std::vector<io::SvgPanel> capture_panels(const std::filesystem::path& fit, const std::string& capture = {});

/// The profile of every coefficient that has one, with the threshold of its interval.
/// @throws InputError as above; ArgumentError if the fit has no profiles
std::vector<io::SvgPanel> profile_panels(const std::filesystem::path& fit);

}  // namespace samara::identification
