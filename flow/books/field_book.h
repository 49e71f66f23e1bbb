#pragma once

#include <string>
#include <vector>

#include "samara/codebooks/build/build.h"
#include "samara/flow/files/flow_plan.h"

/// The mean fields of the flow about a body as a codebook over the angle of attack and the Reynolds number: every
/// output is a train of modes of its snapshots (proper orthogonal decomposition), whose coefficients are polynomials of
/// the box,
///
///   u(node, angle, Re) = sum_r mode_r(node) c_r(angle, Re).
///
/// Nodes are the cells of the flow's grid, which is the same for all angles: the body turns in it, and the codebook's
/// mesh says where the centres are, in body lengths from the body's centre. It is an ordinary codebook: queries with
/// gradients by angle and Reynolds number, files, ParaView.
///
/// Flows are solved on a grid of Leja points of the box that grows where the next point along a coordinate is not
/// foretold. Within closed cells p and the logarithms go on smoothly. Near the body no polynomial of the angle follows
/// what the grid cuts: the tolerance is asked of 95 % of all places at every point, and the largest error anywhere
/// is told beside it, in Certificate::integrator; `worst` says where that is.
namespace samara::flow {

/// u, v, (w) and p, of the mean flow in units of U and the fluid's density; with turbulence log10_k and log10_epsilon,
/// which cannot turn negative between flows; of laminar flows k, of what sheds.
std::vector<pgd::OutputLabel> field_outputs(const FlowCase& flow);

/// @param options as of codebooks::build(); a checkpoint keeps every flow that was solved, and the warning is told
/// what flows warn of
/// @throws ArgumentError as check_book() does; NoResultError where a flow of its grid is not found; InputError for a
/// checkpoint of another plan or solver
codebooks::BuildResult build_field_book(const FlowPlan& plan, const codebooks::BuildOptions& options = {});

/// Root mean square over the places of what twice the cells change, every output over the range that the book has at
/// these points or the plan's floor: the larger of both ends of the box.
/// @param options as of build_field_book(); these flows are kept in finer_checkpoint(), which stays
/// @throws NoResultError if one of these flows is not found; InputError for flows of another plan or solver there
Eigen::VectorXd field_discretisation(const FlowPlan& plan, const codebooks::Codebook& book,
                                     const codebooks::BuildOptions& options);

}  // namespace samara::flow
