#pragma once

#include "report.h"

namespace samara::benchmarks {

/// Particles of the fluid: concentration where the energy has a gradient, variance and increments at long steps.
void run_particles(const Options& options);
/// A thousand flights of a card through gusts, beside a scalar loop; the same bits however they are flown.
void run_flights(const Options& options);

}  // namespace samara::benchmarks
