#pragma once

#include "samara/models/interface/parametric_model.h"

namespace samara::benchmarks {

/// A card of 7 cm x 4 cm x 0.2 mm in air, released at rest, its normal 10 degrees off the vertical about an
/// axis in its plane, `axis` rad from body x; coefficients C_D90, C_T, C_R are free.
models::ParametricModel oblique_card(double axis = 0.6);

/// The sweep of the source: 9 values each from 0.31 to 2.71. Points x 3.
Eigen::MatrixXd coefficient_grid();

}  // namespace samara::benchmarks
