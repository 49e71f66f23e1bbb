#pragma once

#include <optional>
#include <string>

#include "samara/models/stochastic/ensemble.h"
#include "samara/models/stochastic/gust_layout.h"

namespace samara::apps {

/// Paths that a picture shows, at most.
inline constexpr long kPathsInPicture = 40;

/// The cloud as SVG: kept paths from the side (x and height), the mean path where the statistics are those of the
/// place, and, for bodies in space that land, where they do from above.
/// @param ground its height [m]
std::string cloud_picture(const models::Ensemble& cloud, const models::GustLayout& layout,
                          std::optional<double> ground);

}  // namespace samara::apps
