#pragma once

#include "samara/pgd/nonlinear/strategy.h"

namespace samara::pgd {

/// X = x0 + S (A X + b). Without A in train algebra, on the first core only; else from dense pointwise
/// solves at the parameter entries that a cross asks for.
/// @returns what ends StrategySlab::separate()
Outcome<TensorTrain> solve(const StrategySlab& slab, const LinearSlab& linear, CrossPivots& pivots);

}  // namespace samara::pgd
