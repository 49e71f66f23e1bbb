#pragma once

#include "samara/models/interface/parametric_model.h"
#include "samara/motion/database/motion_database.h"

namespace samara::motion {

/// The model of a database with its coefficients free; in wind its sibling in gusts, and after the coefficients the
/// parameters by which that is told of the air along the path of its body (models/stochastic/gust_layout.h).
/// @throws ArgumentError if there is no such sibling
models::ParametricModel steered_model(const MotionDatabase& database, bool in_wind);

}  // namespace samara::motion
