#pragma once

#include <functional>
#include <string>
#include <vector>

#include "samara/codebooks/build/build.h"
#include "samara/flow/files/flow_plan.h"

/// The flow about a body as a codebook: coefficients of the loads, Strouhal number and the energy near the body over
/// the angle of attack and the Reynolds number. All is dimensionless, so that one book serves all sizes, speeds and
/// fluids, and it is an ordinary codebook: queries with gradients, statistics, fits.
///
/// Flows are solved on a grid of Leja points of the box that grows where the next point along a coordinate is
/// not foretold to half the tolerance: a flow takes minutes, and sampling for sources that take milliseconds
/// would spend a hundred of them on its own checks. Its certificate is measured against fresh solves at
/// points that the builder did not see; what the grid of cells is worth is another error, which
/// discretisation() measures with twice the cells.
namespace samara::flow {

/// Rows of its outputs: C_D, C_L, C_M, deviation C_L_rms, strouhal, bubble_end, k_near, and epsilon_near with
/// turbulence.
std::vector<codebooks::CommandQuantity> energy_outputs(const FlowCase& flow);

/// Their values. k and epsilon are means over the fluid within half a length of the body.
Eigen::VectorXd energy_of(const FlowResult& result, const FlowCase& flow);

/// The outputs at values of the plan's box, in its order: angle_of_attack [rad], log10_reynolds.
/// @param warning is told what the flow warns of @throws NoResultError if it is not found there
Eigen::VectorXd solve_energy(const FlowPlan& plan, const std::vector<double>& point,
                             const ProgressCallback& progress,
                             const std::function<void(const std::string&)>& warning = {});

/// @param plan with a box  @param options as of codebooks::build(); a checkpoint keeps every flow that was solved,
/// and the warning is told what flows warn of
/// @throws ArgumentError as check_book() does; NoResultError where a flow of its grid is not found; InputError for a
/// checkpoint of another plan or solver
codebooks::BuildResult build_energy_book(const FlowPlan& plan, const codebooks::BuildOptions& options = {});

/// Change of every output by twice the cells, over the plan's floor and the range that the book has at these points:
/// the largest over both ends of the box.
/// @param options as of build_energy_book(); these flows are kept in finer_checkpoint(), which stays
/// @throws NoResultError if one of these flows is not found; InputError for flows of another plan or solver there
Eigen::VectorXd discretisation(const FlowPlan& plan, const codebooks::Codebook& book,
                               const codebooks::BuildOptions& options);

/// The same codebook, whose build record says so in words: the certificate, which is of one grid, stays as it is.
codebooks::Codebook with_discretisation(const codebooks::Codebook& book, const Eigen::VectorXd& change);

}  // namespace samara::flow
