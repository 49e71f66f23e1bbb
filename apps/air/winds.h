#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "samara/models/interface/model.h"

/// Winds from files, for bodies given by the parameters of their model.
namespace samara::apps {

/// The immersed body in the first realisation of a wind. @param values of parameters and initial values, SI
/// @throws ArgumentError for another model; InputError for a bad file
std::shared_ptr<const models::Model> model_in_wind(const std::string& file, std::uint64_t seed,
                                                   const std::shared_ptr<const models::Model>& model,
                                                   const std::map<std::string, double>& values);

/// Duration of the shortest gust of a wind [s]; infinite: there is none. @throws InputError for a bad file
double shortest_gust(const std::string& file);

/// Warns where steps of that length [s] leap over its gusts. @throws InputError for a bad file
void warn_of_gusts(const std::string& file, double step);

}  // namespace samara::apps
