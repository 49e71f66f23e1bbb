#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <string>

#include "samara/models/interface/model.h"
#include "samara/models/wind/wind.h"

/// Winds from files, for bodies given by the parameters of their model.
namespace samara::apps {

/// The file of a wind may be a pipe, which is read once: what is asked of it later is kept.
struct ModelInWind {
  std::shared_ptr<const models::Model> model;
  double shortest_gust = std::numeric_limits<double>::infinity();  ///< as shortest_gust() says
  bool has_turbulence = false;                                     ///< which a seed draws
};

/// The immersed body in the first realisation of a wind. @param values of parameters and initial values, SI
/// @throws ArgumentError for another model; InputError for a bad file
ModelInWind model_in_wind(const std::string& file, std::uint64_t seed,
                          const std::shared_ptr<const models::Model>& model,
                          const std::map<std::string, double>& values);

/// Duration of the shortest gust of a wind [s]; infinite: there is none.
double shortest_gust(const models::wind::Wind& wind);

/// Warns where steps of that length [s] leap over gusts that are so short [s].
void warn_of_gusts(double shortest, double step);

}  // namespace samara::apps
