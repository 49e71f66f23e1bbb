#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include <Eigen/Core>

#include "samara/models/interface/parametric_model.h"

/// Winds from files, for bodies given by the parameters of their model.
namespace samara::apps {

/// What a wind needs to know of a body.
struct BodyOutline {
  double length = 0.0;  ///< [m]
  Eigen::Vector2d semi_axes =
      Eigen::Vector2d::Zero();  ///< of a flat one, along its axes x and y; else zero [m]
};

/// @param radius of a disc in place of the body's own outline; 0: no mean over an outline
/// @throws ArgumentError if the model has no parameters that say its size
BodyOutline outline_of(const models::ParametricModel& model, std::optional<double> radius);

/// The immersed body in the first realisation of a wind. @param values of parameters and initial values, SI
/// @throws ArgumentError for another model; InputError for a bad file
std::shared_ptr<const models::Model> model_in_wind(const std::string& file, std::uint64_t seed,
                                                   const std::shared_ptr<const models::Model>& model,
                                                   const std::map<std::string, double>& values);

}  // namespace samara::apps
