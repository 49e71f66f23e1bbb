#pragma once

#include <span>
#include <string>
#include <vector>

#include "samara/models/interface/model.h"

/// Models of fields: equations in space and time, which codebooks/fields discretises and solves for a box of
/// parameters at once. They are no Model: nothing integrates them as x' = f(t, x, p).
namespace samara::models {

struct FieldModel {
  /// The only state is the field; it has no initial value to set: parameters say how it begins.
  ModelInfo info;
  std::string place;   ///< name of the coordinate of space [m], from 0 to the parameter `extent`
  std::string extent;  ///< its length, which is fixed: it cannot be free
  /// Parameters in which the field is linear, all of them together.
  std::vector<std::string> linear_in;
  /// The exact field at time t >= 0 [s] and place [m]. @param p all parameters, in the order of the model
  double (*exact)(double t, double place, std::span<const double> p) = nullptr;
  std::string exact_source;  ///< of that solution, in words
};

/// Names of all of them, sorted.
std::vector<std::string> field_model_names();

/// Null where there is none of this name.
const FieldModel* find_field_model(const std::string& name);

/// Heat conduction in a rod whose ends are held at given temperatures.
const FieldModel& heat_rod();

}  // namespace samara::models
