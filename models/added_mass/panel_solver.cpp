#include "samara/models/added_mass/panel_solver.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <Eigen/LU>
#include <fmt/format.h>
#include <tbb/task_arena.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/base/shared_progress.h"
#include "samara/models/added_mass/panel_gmres.h"
#include "samara/models/added_mass/panel_system.h"
#include "samara/models/added_mass/reference_point.h"

namespace samara::models {

namespace {

using added_mass::PanelSystem;
using added_mass::RowMajorMatrix;
using added_mass::SixColumns;
using Clock = std::chrono::steady_clock;
using Eigen::Index;
using Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

void require_options(const PanelOptions& options) {
  constexpr const char* kWhere = "panel_added_mass";
  require(options.threads >= 0, "threads", options.threads, "0 (all) or more", kWhere);
  require(options.tolerance > 0.0 && options.tolerance < 1.0, "tolerance", options.tolerance,
          "a number between 0 and 1", kWhere);
  require(options.max_iterations >= 0, "max_iterations", options.max_iterations, "0 or more", kWhere);
  require(options.direct_up_to >= 0, "direct_up_to", options.direct_up_to, "0 or more", kWhere);
}

void require_memory(const TriangleMesh& mesh, const PanelOptions& options) {
  const auto n = static_cast<double>(mesh.vertices.cols());
  if (8e-9 * n * n > options.max_gigabytes) {
    throw ArgumentError(
        fmt::format("panel_added_mass: a mesh of {} corners needs {:.1f} GB, the limit is {:g}; a coarser "
                    "mesh will do, or "
                    "raise max_gigabytes",
                    mesh.vertices.cols(), 8e-9 * n * n, options.max_gigabytes));
  }
}

/// A mesh of size 1 about the origin, and the way back.
struct Normalised {
  TriangleMesh mesh;
  Vector3d centre;
  double length;

  explicit Normalised(const TriangleMesh& original) : mesh(original) {
    const Vector3d high = mesh.vertices.rowwise().maxCoeff(), low = mesh.vertices.rowwise().minCoeff();
    centre = 0.5 * (high + low);
    length = 0.5 * (high - low).maxCoeff();
    mesh.vertices = (mesh.vertices.colwise() - centre) / length;
  }
};

PanelAddedMass& cancelled(PanelAddedMass& result, const char* when) {
  result.status = Termination::cancelled;
  result.message = fmt::format("cancelled while {} {} unknowns", when, result.unknowns);
  return result;
}

/// The potentials; of no use if the result is cancelled.
SixColumns solve(const PanelSystem& system, const PanelOptions& options, PanelAddedMass& result) {
  SixColumns phi;
  result.direct = result.unknowns <= options.direct_up_to;
  if (!result.direct) {
    SharedProgress progress(options.progress, "iterating", options.max_iterations);
    const auto outcome = added_mass::gmres(system.matrix, system.rhs, options.tolerance,
                                           options.max_iterations, progress, phi);
    result.iterations = outcome.iterations;
    if (progress.cancelled()) {
      cancelled(result, "iterating");
      return phi;
    }
    result.direct = !outcome.converged;
  }
  if (result.direct) phi = system.matrix.partialPivLu().solve(system.rhs);
  const SixColumns rest = system.rhs - system.matrix * phi;
  for (Index c = 0; c < 6; ++c) {
    // A motion that moves no fluid (a ball turning) leaves only round-off on the right.
    const double norm = std::max(system.rhs.col(c).norm(), 1e-12 * system.rhs.norm());
    const double residual = rest.col(c).norm() / norm;
    if (std::isnan(residual) || residual > result.residual) result.residual = residual;  // NaN stays
  }
  result.message =
      result.direct
          ? fmt::format(
                "{} unknowns by factorisation{}", result.unknowns,
                result.iterations > 0 ? fmt::format(" after {} iterations of GMRES", result.iterations) : "")
          : fmt::format("{} unknowns by {} iterations of GMRES, residual {:.1e}", result.unknowns,
                        result.iterations, result.residual);
  return phi;
}

/// Largest difference from symmetry, in the measure of the diagonal. @param K of a body of size 1
double asymmetry_of(const Matrix6d& K) {
  // A turn that moves no fluid (of a sphere) has no measure of its own: that of the motion that drags least along, at
  // the body's size from the axis, is the least.
  Eigen::Array<double, 6, 1> size = K.diagonal().array().abs();
  const double least = std::max(size.head<3>().minCoeff(), 1e-12 * size.maxCoeff());
  size = size.max(least).sqrt();
  return ((K - K.transpose()).array() / (size.matrix() * size.matrix().transpose()).array()).abs().maxCoeff();
}

PanelAddedMass solve_unit_problem(const TriangleMesh& mesh, const PanelOptions& options) {
  PanelAddedMass result;
  result.panels = static_cast<int>(mesh.triangles.cols());
  result.unknowns = static_cast<int>(mesh.vertices.cols());
  const auto start = Clock::now();
  SharedProgress progress(options.progress, "assembling", added_mass::assembly_pieces(mesh));
  const PanelSystem system = added_mass::assemble(mesh, progress);
  result.assembly_seconds = seconds_since(start);
  if (progress.cancelled()) return cancelled(result, "assembling");
  const auto solve_start = Clock::now();
  const SixColumns phi = solve(system, options, result);
  result.solve_seconds = seconds_since(solve_start);
  if (result.status == Termination::cancelled) return result;
  const Matrix6d K = -phi.transpose() * system.flux;
  result.asymmetry = asymmetry_of(K);
  result.matrix = 0.5 * (K + K.transpose());
  return result;
}

}  // namespace

PanelAddedMass panel_added_mass(const TriangleMesh& mesh, double fluid_density,
                                const Vector3d& reference_point, const PanelOptions& options) {
  require_closed(mesh);
  require_positive(fluid_density, "fluid density [kg/m^3]", "panel_added_mass");
  if (!reference_point.allFinite())
    throw ArgumentError("panel_added_mass: the reference point is not finite");
  require_options(options);
  require_memory(mesh, options);
  const Normalised unit(mesh);
  PanelAddedMass result;
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] { result = solve_unit_problem(unit.mesh, options); });
  if (result.status == Termination::cancelled) return result;
  // In units of length: M ~ L^3, coupling ~ L^4, J ~ L^5.
  Eigen::Matrix<double, 6, 1> scale;
  scale << Vector3d::Ones(), Vector3d::Constant(unit.length);
  const double mass = fluid_density * unit.length * unit.length * unit.length;
  result.matrix = mass * scale.asDiagonal() * result.matrix * scale.asDiagonal();
  const Matrix6d K = added_mass_about(result.matrix, reference_point - unit.centre);
  result.matrix = 0.5 * (K + K.transpose());  // once more: products round each half for itself
  result.status = Termination::converged;
  if (!result.matrix.allFinite() || !std::isfinite(result.residual)) {
    result.status = Termination::not_finite;
    result.message =
        fmt::format("the added mass is not finite, residual {:.1e}: {}", result.residual, result.message);
  }
  return result;
}

}  // namespace samara::models
