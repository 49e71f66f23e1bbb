#pragma once

#include "samara/codebooks/plan/plan.h"

namespace samara::benchmarks {

/// Builds a codebook of a short time over all states that matter, and composes it to 0.5 s from random starts in
/// the middle half of its box, against CVODES; what an answer takes, against Runge-Kutta steps.
void flow_map_case(const codebooks::Plan& plan);

}  // namespace samara::benchmarks
