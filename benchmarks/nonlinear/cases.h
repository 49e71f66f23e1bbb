#pragma once

#include "report.h"

/// The cases of the benchmark nonlinear, by subject; each prints its measurements.
namespace samara::benchmarks {

inline constexpr const char* kNonlinear = "nonlinear";

/// Every strategy that a plan may name.
void run_plans(const Options& options);
/// (6.22) by decoupling, against the sweep; and on the domain where it ceases to exist.
void run_products(const Options& options);
/// (6.24) over six initial velocities.
void run_kirchhoff7(const Options& options);
/// The reference plate in slabs.
void run_plates(const Options& options);
/// Piecewise-linear approximation of the plate, in separated form.
void run_piecewise_linear(const Options& options);
/// Six strategies on five problems.
void run_strategies(const Options& options);
/// Each of them where it meets 1e-6, and at what order.
void run_strategy_orders(const Options& options);
/// The immersed body, four sets of coefficients, two releases.
void run_bodies(const Options& options);
/// A priori, by sampling, by a full sweep.
void run_builders(const Options& options);

/// Builds that are killed, and resumed.

}  // namespace samara::benchmarks
