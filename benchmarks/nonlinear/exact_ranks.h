#pragma once

#include "samara/codebooks/plan/plan.h"

namespace samara::benchmarks {

/// The largest rank of the exact solution as a tensor train, its axes in the order of the plan: trajectories at
/// all nodes of a Chebyshev grid, unfolded axis by axis, with as few terms as leave no output off by more than
/// `error` of its range. For plans of a model with three axes.
int exact_rank(const codebooks::Plan& plan, double error);

}  // namespace samara::benchmarks
