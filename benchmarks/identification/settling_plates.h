#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "discs.h"
#include "samara/identification/smoothing/flutter.h"
#include "windows.h"

/// Plastic plates of 10 x 10 mm that settle in water (J. Lofty, Cardiff), seen as positions alone: discs of
/// the same area, volume and mass, with the inertia of the square.
namespace samara::benchmarks::identification {

struct PlateKind {
  std::string material;
  double volume;   ///< m^3, of the source
  double density;  ///< kg/m^3, of handbooks: not measured
  double part;     ///< s, about three swings: of the statistics
  int frames;      ///< of a window: one swing
  int ahead;       ///< frames from its end to what is predicted: 0.4 swings
};
inline constexpr double kWater = 1000.0;  ///< kg/m^3
const PlateKind& plate_kind(const std::string& material);

/// Drops of which the source's index finds no jump, gap or swapped label, without their first second: as
/// examples/captures/settling_plates.toml reads them.
std::vector<samara::identification::Capture> plate_drops(const std::filesystem::path& folder,
                                                         const PlateKind& kind);

/// All others of the kind, such as they are.
std::vector<samara::identification::Capture> flagged_plate_drops(const std::filesystem::path& folder,
                                                                 const PlateKind& kind);

/// Aspect (of the box around it) and area of the silhouette: real parts as seen along x, imaginary ones as seen along
/// y. Frames x 2.
Eigen::MatrixXcd silhouettes_of(const samara::identification::Capture& drop);

/// Medians over drops.
samara::identification::Flutter measured_flutter(const std::vector<samara::identification::Capture>& drops,
                                                 const PlateKind& kind);

std::unique_ptr<samara::models::TrajectoryFamily> plate_family(const PlateKind& kind);
samara::identification::FitOptions settling_options();

/// Medians over falls of 12 s from several tilts, the first 4 s left out; nothing if none exists.
std::optional<samara::identification::Flutter> simulated_flutter(const PlateKind& kind,
                                                                 const Coefficients& coefficients);

/// One cost of windows and statistics, of the logarithms of the coefficients:
///
///   1/2 d . C^-1 d + 1/2 sum_k (log(simulated_k/measured_k)/weight_k)^2
///
/// d from the optimum of the windows, C its covariance between drops, by the bootstrap where there is one;
/// weights 1 % of the fall speed, 1 % of the frequency, 3 % of the amplitude.
struct JointCost {
  double windows = 0.0, statistics = 0.0;
};
struct JointFit {
  Coefficients coefficients;
  JointCost cost;
  samara::identification::Flutter simulated;
};
JointFit fit_jointly(const PlateKind& kind, const samara::identification::FitResult& windows,
                     const samara::identification::Flutter& measured, int sweeps);

}  // namespace samara::benchmarks::identification
