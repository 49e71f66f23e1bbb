#pragma once

#include "report.h"

namespace samara::benchmarks {

/// 200 modes in [0.02, 200]/L: variance, D_LL from 0.03 to 3 L and divergence against the exact band.
void modes_case(const Options& options);
/// IEC's series, 600 s at 20 Hz, U 10 m/s at 30 m: twelve bands of the spectrum, coherence over 5 and 15 m.
void series_case(const Options& options);
/// Velocity, gradient and rate at a place, beside a plain loop over the modes.
void point_case(const Options& options);
/// The leaf of the tutorial, 1000 times from 2 m to the ground.
void meadow_case(const Options& options);

}  // namespace samara::benchmarks
