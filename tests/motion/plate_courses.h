#pragma once

#include <map>
#include <memory>
#include <string>

#include "samara/models/interface/following_model.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/laws/registry.h"
#include "samara/motion/courses/coefficient_course.h"

/// A plate without units, 20 semi-chords high.
inline const std::map<std::string, double> kPlate = {
    {"inertia_ratio", 1.3}, {"theta(0)", 0.6}, {"y(0)", 20.0}, {"C_T", 1.0}, {"C_R", 3.0}, {"A", 1.4}};

/// The plate whose coefficients take this course.
inline samara::models::ParametricModel declared(const samara::motion::CoefficientCourse& course,
                                                std::map<std::string, double> fixed = kPlate) {
  for (const std::string& name : course.followed()) fixed.erase(name);
  return {samara::models::following(samara::models::find_model("falling_plate_nd"),
                                    std::make_shared<samara::motion::CoefficientCourse>(course)),
          fixed,
          {}};
}
