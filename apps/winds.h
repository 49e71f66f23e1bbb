#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include <Eigen/Core>

#include "samara/models/interface/model.h"

/// Winds from files, for bodies given by the parameters of their model.
namespace samara::apps {

/// What a wind needs to know of a flat body.
struct BodyOutline {
  double length = 0.0;        ///< [m]
  Eigen::Vector2d semi_axes;  ///< along its axes x and y [m]
};

/// @param values of parameters and initial values, SI
/// @throws ArgumentError unless the model is an immersed body with its semi-axes
BodyOutline outline_of(const std::shared_ptr<const models::Model>& model,
                       const std::map<std::string, double>& values);

/// The model of that body in the first realisation of a wind. @throws ArgumentError as above; InputError for a bad file
std::shared_ptr<const models::Model> model_in_wind(const std::string& file, std::uint64_t seed,
                                                   const std::shared_ptr<const models::Model>& model,
                                                   const std::map<std::string, double>& values);

}  // namespace samara::apps
