#pragma once

#include <memory>
#include <span>

#include "samara/identification/captures/capture.h"
#include "samara/identification/fit/fit_objective.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/models/trajectories/trajectory_family.h"

/// From captures to coefficients with uncertainty.
///
/// A frame at time t of capture c, output o, is compared with
///
///     measured(t) = y_o(t; q_c) + offset_(c,o) + noise,
///
/// where the coordinates q_c are shared by all captures (parameters, by default) or the capture's own
/// (initial values), and an offset is free where the motion does not depend on the place; an attitude is
/// compared by the turn between the two. Minimised is 1/2 sum rho((measured - model)/scale) within the box,
/// with a loss that tames outliers, by damped Newton steps with exact derivatives (separable_descent.h; where
/// segments are joined, or nothing is the captures' own, those of Levenberg and Marquardt, by Ceres), from
/// several starts or what a search of the box found; to the cost come 1/2 ((q - mean)/deviation)^2 for each
/// prior, and where captures are cut into segments 1/2 (weight (end - next start))^2 for each join. Unknowns
/// that reach a bound are held there while the rest is minimised, and let go if the cost would fall.
///
/// Uncertainty. Frames of one motion are not independent (tracking, scale and what the model lacks are wrong
/// for the whole motion), so the errors of shared coefficients come from the scatter of the captures'
/// gradients g_c at the optimum, by clusters:
///
///     cov = H^-1 (sum_c A_c g_c g_c^T A_c^T + P) H^-1,   H = sum psi' J J^T + P, own unknowns eliminated,
///
/// with P the information of priors and A_c the correction for what a cluster decides by itself
/// (cluster_errors.h), which is C/(C - 1) in the product where all clusters say equally much; beside the
/// naive ones, Huber's var(psi)/mean(psi')^2 (J^T J)^-1 (to which priors add in the same way). Clustered
/// errors are themselves rough for few clusters, and know nothing of an error that all captures share. Shared
/// unknowns at a bound are taken as held; own ones as if they were free, with the deviation of a uniform
/// distribution over their box.
///
///     const auto book = codebooks::load("coin.h5");
///     const auto family = codebook_trajectories(book);
///     const FitResult result = fit(*family, read_captures("coin.toml"), {.compared = {.span = 0.4}});
///     std::cout << fit_text(result);
namespace samara::identification {

/// @throws ArgumentError for options outside their meaning, unknown names (the nearest is named), captures
///   that do not measure an output or measure it in another dimension, captures with fewer frames than
///   unknowns, frames outside the times of the family, and two captures of one id in memory; InputError where one of
///   a file is given twice. Numerical outcomes are in the result's status and warnings.
FitResult fit(const models::TrajectoryFamily& family, std::span<const Capture> captures,
              const FitOptions& options = {});

/// The same, and what was minimised (fit_objective.h): null where no start succeeded. The family must outlive it.
FitResult fit(const models::TrajectoryFamily& family, std::span<const Capture> captures,
              const FitOptions& options, std::shared_ptr<const FitObjective>& objective);

}  // namespace samara::identification
