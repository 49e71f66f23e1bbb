#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_result.h"

/// Flights of a table tennis ball whose spin another camera saw (Gossard et al., SpinDOE, arXiv:2303.03879).
///
///     v' = g - k (C_D + c S) |v| v + k r C_L(S)/S (R w) x v,   C_L = C_M S/(1 + b S),   S = r |w|/|v|,
///
/// k = rho A/(2 m), w the spin as labelled, R the turn from its camera's axes to the table's.
namespace samara::benchmarks::identification {

using samara::identification::Capture;
using samara::identification::FitResult;

/// Up to the first bounce, on a regular grid of frames. Labels: "number" of the file, "x_spin" and its like.
struct Flights {
  std::vector<Capture> labelled;  ///< numbers whose labels belong to them
  std::vector<Capture> shifted;   ///< numbers where labels stand in other rows
};
/// @param sidecar of the tables
/// @param least_frames flights with fewer are left out
Flights read_flights(const std::filesystem::path& folder, const std::filesystem::path& sidecar,
                     int least_frames);

/// Where a fit of the labelled flights begins.
struct RotationStart {
  double about_x = 0.0;  ///< rad, of the turn R
  double C_M = 0.5;
  bool half_turned = false;  ///< and half a turn about the table's y axis, along which balls fly
};

enum class SpinDrag { none, fitted };  ///< c

/// C_D, C_M, b and R from flights with labels, the start of each flight its own.
FitResult fit_labelled(const std::vector<Capture>& flights, const RotationStart& start,
                       SpinDrag spin_drag = SpinDrag::none);
/// C_D alone.
FitResult fit_drag_only(const std::vector<Capture>& flights);

struct LiftCoefficient {
  double value = 0.0;
  double standard_error = 0.0;  ///< from the clustered covariance
};
LiftCoefficient lift_coefficient(const FitResult& fitted, double S);

/// m: the distance between flight and fit, rms over a flight, median over flights.
double median_flight_rms(const FitResult& fitted);

/// The spin of a flight from how it bends, beside its label turned into the table's axes: the parts
/// perpendicular to the mean velocity, rad/s (the part along it bends nothing).
struct SpinComparison {
  std::string number;
  Eigen::Vector3d effective, labelled;
};
std::vector<SpinComparison> compare_spins(const std::vector<Capture>& flights, const FitResult& fitted);

/// Distances of predictors at one time after what they saw, by name: "model" (start and spin from the window
/// itself), "labels", "drag only", "parabola"; one for each flight that lasts so long.
using Distances = std::map<std::string, std::vector<double>>;

struct Horizon {
  double window = 0.15;  ///< s of each flight that are seen
  double end = 0.30;     ///< s after its first frame, where the distance is taken
};
/// A flight that lasts as long: what was seen of it, where it was later, and where the model says, with start and
/// spin from what was seen.
struct FlightMoment {
  std::string number = {};
  Capture seen = {};
  double time = 0.0;                         ///< s, in the times of what was seen
  Eigen::RowVector3d next = {}, model = {};  ///< m; the model's infinite where it has no motion
};
/// @param stride frames from one window of a flight to the next; 0: the first one alone
std::vector<FlightMoment> flight_moments(const std::vector<Capture>& flights, const FitResult& fitted,
                                         const Horizon& horizon, Eigen::Index stride = 0);

/// @param fitted from other flights, as is `drag_only`
Distances predict_flights(const std::vector<Capture>& flights, const FitResult& fitted,
                          const FitResult& drag_only, const Horizon& horizon);

/// Labelled flights by cross validation: each is predicted by a fit that has not seen it.
/// @param starts of each fit, of which the one with the lowest cost counts: chosen without the flights left
/// out
Distances predict_left_out_flights(const std::vector<Capture>& flights, std::span<const RotationStart> starts,
                                   int folds, const Horizon& horizon, SpinDrag spin_drag = SpinDrag::none);

}  // namespace samara::benchmarks::identification
