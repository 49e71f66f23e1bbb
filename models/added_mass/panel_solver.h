#pragma once

#include <string>

#include <Eigen/Core>

#include "samara/base/progress.h"
#include "samara/base/termination.h"
#include "samara/models/bodies/triangle_mesh.h"

/// Added mass of a body of any shape, by panels.
///
/// A rigid body moves in an unbounded ideal fluid at rest at infinity; the potential phi_j of its unit motion
/// j (three linear, three angular velocities in body axes) has d(phi_j)/dn = v_j = n.u_j on the surface, n
/// into the fluid, and the kinetic energy of the fluid is 1/2 U^T K U with the symmetric, positive
/// semi-definite
///
///   K_ij = - fluid_density Int phi_i v_j dS      (H. Lamb, Hydrodynamics, 6th ed., 1932, art. 118 and 121).
///
/// phi is continuous and linear on the triangles of the mesh; its values at the corners solve the sum of two
/// equations, each of which breaks down on thin bodies where the other is sound:
///
///   W phi = b,  W_ab = Int Int curl psi_a . curl psi_b / (4 pi r),  curl psi = n x grad psi.
///     The body is replaced by fluid that moves with it, so that all its surface is a vortex sheet, and the
///     flow through the surface vanishes in the mean over every psi_a. As an energy of vortex loops W is
///     symmetric and positive, and the jump across a thin body (motions along its normal) is found well even
///     where its two faces nearly touch, with errors of K quadratic in those of phi. What is equal on both
///     faces (motions in its plane) it hardly sees.
///   phi(x) - Int (phi(y)-phi(x)) dG/dn dS = - Int G v dS at the corners: Green's formula, G = 1/(4 pi r). It
///     finds what is equal on both faces, and hardly sees the jump.
///
/// (A combination as A. J. Burton and G. F. Miller, Proc. R. Soc. Lond. A 323 (1971) 201-210, use it against
/// spurious resonances.) Measured on the leaf 7.3:4.2:0.03 with 1728 panels: Green's formula alone misses M_z
/// by 18 % and J_y by 24 %; vortex loops alone miss M_x and J_z by 4 % as quadrature errors are multiplied by
/// a/c; the sum is within 0.9 % for M_z, J_x, J_y and 2.1 % for M_x, M_y, J_z, most of it the mesh's own
/// smaller volume.
///
/// Integrals over panels near each other are exact within, by three points outside; panels farther apart than
/// 1.5 times the sum of their radii see each other's moments up to the second. (Twice that reach costs twice
/// the time and changes the added mass at 1280 panels by up to 0.2 %.) Errors fall with the square of the
/// panel size if panels close up towards rims (see mesh_shapes.h); most of them is the volume that an
/// inscribed mesh lacks. On a sharp edge the fluid's velocity is infinite: the order is lower unless panels
/// shrink towards it.
///
/// Cost: 1.5 n^2 pairs for n panels, and 2 n^2 bytes (200 MB for 10000 panels).
///
///   const PanelAddedMass plate = panel_added_mass(box_mesh({0.1, 0.1, 0.001}, 16, 16), 1.2);
namespace samara::models {

struct PanelOptions {
  int threads = 0;  ///< 0: all. Results do not depend on it
  /// Systems with at most this many unknowns (corners) are solved by factorisation, others by GMRES.
  int direct_up_to = 300;
  /// GMRES stops when every residual, scaled by the diagonal, is below this times its right-hand side.
  double tolerance = 1e-8;
  int max_iterations = 400;    ///< after which the system is factorised after all
  double max_gigabytes = 8.0;  ///< meshes that need more are refused: 8 n^2 bytes for n corners
  /// Stages "assembling" and "iterating" (of max_iterations); a factorisation cannot be interrupted.
  ProgressCallback progress = {};
};

struct PanelAddedMass {
  /// converged; not_finite: the matrix or the residual is infinite or NaN; cancelled: there is no matrix; failed:
  /// it was not called.
  Termination status = Termination::failed;
  /// Symmetric; linear motions first; kg, kg m, kg m^2. About the reference point, in the mesh's axes.
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  /// Largest |K_ij - K_ji| / sqrt(K_ii K_jj) before it was made symmetric, about the mesh's middle: a lower bound on
  /// the order of the error of the discretisation. (Zero also on meshes with the symmetries of an ellipsoid.) The
  /// diagonal of a turn, which vanishes for a sphere, counts as at least l^2 times the smallest of the linear motions,
  /// l half the body's largest extent.
  double asymmetry = 0.0;
  int panels = 0;
  int unknowns = 0;
  bool direct = false;    ///< factorised, rather than iterated
  int iterations = 0;     ///< of GMRES
  double residual = 0.0;  ///< largest |residual| / |right-hand side| at the end
  double assembly_seconds = 0.0;
  double solve_seconds = 0.0;
  std::string message = "panel_added_mass was not called";  ///< how the system was solved, with the numbers

  bool is_usable() const { return status == Termination::converged; }
};

/// The added mass of the body within a closed mesh [m] in a fluid of density `fluid_density` [kg/m^3], about
/// a point [m] given in the mesh's axes.
/// @throws ArgumentError if the mesh is not closed and oriented outward (require_closed), the density is not
///   positive, the point is not finite, or an option is out of range.
PanelAddedMass panel_added_mass(const TriangleMesh& mesh, double fluid_density,
                                const Eigen::Vector3d& reference_point = Eigen::Vector3d::Zero(),
                                const PanelOptions& options = {});

}  // namespace samara::models
