#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>

#include "options/arguments.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/stochastic/air_along_path.h"

namespace samara::apps {

/// The fluid that realisations fly through.
struct NamedAir {
  std::shared_ptr<const models::AirSource> source;
  std::string description;  ///< for the files and the summary
  /// What tells it from all other air, seed and contents of files included; empty where a file is a pipe.
  std::string identity = {};
  double shortest_gust = std::numeric_limits<double>::infinity();  ///< of a wind, as winds.h says [s]
};

/// Whether the call says what fluid it is.
bool has_air(const SimulateArguments& arguments);

/// @param model of the body: its viscosity is that of the fluid, where it has one, and a wind is averaged over its
/// outline
/// @param body_radius [m] over which the body averages the fluid that it sees
/// @throws ArgumentError for words that do not make a flow; InputError for a bad file of a wind or a flow.
NamedAir air_of(const SimulateArguments& arguments, const models::ParametricModel& model, std::uint64_t seed,
                double body_radius);

}  // namespace samara::apps
