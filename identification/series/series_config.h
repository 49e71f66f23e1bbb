#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "samara/identification/problem/fit_config.h"
#include "samara/identification/series/coefficient_series.h"

/// The series that the config of a fit asks for:
///
///     [series]
///     coefficients = ["C_R"]                          # these change along the captures
///     span = "40 ms"
///     stride = "20 ms"                                # spans slide, unjoined; else they adjoin, joined
///     order = 2                                       # first or second differences are small
///     smoothness = { C_R = 0.2 }                      # their size; else the captures choose
namespace samara::identification {

/// Empty if the text of the config has no table [series].
/// @param name stands for the file in messages
/// @throws InputError as read_fit_config()
std::optional<SeriesOptions> parse_series_config(std::string_view text, const std::string& name,
                                                 const ConfigNames& names);

}  // namespace samara::identification
