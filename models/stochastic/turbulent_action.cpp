#include "samara/models/stochastic/turbulent_action.h"

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/require.h"
#include "samara/models/stochastic/langevin.h"

namespace samara::models {

namespace {

LangevinScales action_scales(const Turbulence& energy, const SeenOptions& options) {
  require_positive(energy.k, "k of the turbulence [m^2/s^2]");
  require_positive(energy.epsilon, "epsilon of the turbulence [m^2/s^3]");
  return {energy, options};
}

void check_path(const TurbulentPath& path, std::size_t energies) {
  const Eigen::Index n = path.times.size() - 1;
  if (n < 1) throw ArgumentError("the path has no interval, expected two times or more");
  if (path.velocities.rows() != n + 1 || path.still.rows() != n ||
      (path.fluid.rows() != 0 && path.fluid.rows() != n)) {
    throw ArgumentError(
        fmt::format("the path has {} times, {} velocities, {} accelerations and {} velocities of the "
                    "fluid, expected {} velocities, {} accelerations and 0 or {} of the fluid",
                    n + 1, path.velocities.rows(), path.still.rows(), path.fluid.rows(), n + 1, n, n));
  }
  if (energies != 1 && energies != static_cast<std::size_t>(n))
    throw ArgumentError(
        fmt::format("there are {} energies, expected 1 or {}, one for each interval", energies, n));
  if (!path.times.allFinite() || !path.velocities.allFinite() || !path.still.allFinite() ||
      !path.fluid.allFinite())
    throw ArgumentError("the path has a number that is not finite");
  for (Eigen::Index i = 0; i < n; ++i) {
    if (!(path.times[i + 1] > path.times[i]))
      throw ArgumentError(fmt::format("the time {} follows {}, expected times that increase",
                                      path.times[i + 1], path.times[i]));
  }
}

}  // namespace

TurbulentAction turbulent_action(const TurbulentPath& path, const std::vector<Turbulence>& energy,
                                 const SeenOptions& options) {
  check_path(path, energy.size());
  TurbulentAction action;
  action.by_still.resize(path.still.rows(), 3);
  for (Eigen::Index i = 0; i < path.still.rows(); ++i) {
    const Turbulence& here = energy[energy.size() == 1 ? 0 : static_cast<std::size_t>(i)];
    const LangevinScales scales = action_scales(here, options);
    const double h = path.times[i + 1] - path.times[i];
    Eigen::RowVector3d slip = path.velocities.row(i);
    if (path.fluid.rows() > 0) slip -= path.fluid.row(i);
    const Eigen::RowVector3d random =
        (path.velocities.row(i + 1) - path.velocities.row(i)) / h - path.still.row(i) + slip / scales.T;
    const double weight = h / (scales.C_0 * here.epsilon);
    action.value += 0.5 * weight * random.squaredNorm();
    action.by_still.row(i) = -weight * random;
  }
  return action;
}

double turbulent_action(const Eigen::Vector3d& extra, double duration, const Turbulence& energy,
                        const SeenOptions& options) {
  require_positive(duration, "duration [s]");
  if (!extra.allFinite()) throw ArgumentError("an extra acceleration is not finite");
  const LangevinScales scales = action_scales(energy, options);
  return 0.5 * extra.squaredNorm() * duration / (scales.C_0 * energy.epsilon);
}

}  // namespace samara::models
