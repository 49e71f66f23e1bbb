#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/models/stochastic/air_along_path.h"
#include "samara/models/stochastic/ensemble.h"

/// Many realisations of one motion in a fluid that is random: where a leaf lands, and how sure that is.
///
///   const ParametricModel leaf(find_model("immersed_body_in_gusts"), values, {});
///   const Ensemble cloud = realise(leaf, {}, *fluid_seen_in(uniform_turbulence(0.3, 0.2), 7), times, {.ground = 0.0});
///
/// Bodies fly side by side in the lanes of SIMD registers, and so do their gusts; packs of them are shared between
/// threads. A realisation has the same bits alone, among others, on any number of threads and after resume(); another
/// processor or library of mathematics may change last digits, and where flights tumble that is another sample.
namespace samara::models {

struct RealiseOptions {
  long realisations = 1000;
  long first = 0;  ///< number of the first one: any may be seen again by itself
  /// Upper bound [s]; steps end on the times asked for, and one is an update of the gust.
  double step = 1e-3;
  int threads = 0;                       ///< 0: as many as the machine has
  std::vector<std::string> states = {};  ///< whose statistics are kept; empty: those of the place
  std::optional<double> ground = {};     ///< height at which a body has landed [m]; it must start above
  long keep = 0;                         ///< trajectories of that many first realisations are kept
  /// Realisations in pairs of opposite noise: their number and `first` must be even.
  bool antithetic = false;
  /// Stop as soon as the standard error of the mean displacement at the last time (at the landing, with a ground) is
  /// within this share of its root mean square; looked at every 256 realisations; 0: do not.
  double relative_error = 0.0;
  long max_steps = 100000000;      ///< most steps of a realisation
  ProgressCallback progress = {};  ///< asked every 256 steps; cancels after the last 256 that were finished
  /// Given what is done, for checkpoints: after 1024 realisations or 10 s, then every 10 s, and where it is cancelled.
  std::function<void(const Ensemble&)> so_far = {};
};

/// A step that resolves the body's own motion, 1 ms or less [s]; whether it resolves the air's, the ensemble says.
double step_of_body(const ParametricModel& model, std::span<const double> point);

/// @param model with the parameters of gusts (gust_layout.h), none of them fixed or free
/// @param point its free coordinates (SI)
/// @param times not decreasing, from 0 on; those of the statistics
/// @throws ArgumentError if the model cannot fly through gusts, or a point, a time or an option is outside its meaning.
Ensemble realise(const ParametricModel& model, std::span<const double> point, const AirSource& air,
                 std::span<const double> times, const RealiseOptions& options = {});

/// Refuses what realise() would refuse, and flies nothing: for those who have other work to do before.
/// @throws ArgumentError as realise()
void check_realisations(const ParametricModel& model, std::span<const double> point, const AirSource& air,
                        std::span<const double> times, const RealiseOptions& options = {});

/// Goes on from an ensemble that was cancelled or stopped early, up to options.realisations: the result is that of an
/// undisturbed run, to the bit. All else is to be as it was; the air cannot be compared.
/// @throws ArgumentError as above, if it was not made by realise() or does not end on a multiple of 256, and if times,
///   states, values, step, ground, pairs or kept trajectories are others.
Ensemble resume(const Ensemble& begun, const ParametricModel& model, std::span<const double> point,
                const AirSource& air, std::span<const double> times, const RealiseOptions& options = {});

/// What an ensemble has come to as plain numbers, for checkpoints, and the ensemble again, for the same call:
/// bit for bit what resume() goes on from.
/// @throws ArgumentError if it was not made by realise(), or as realise(), or if the numbers are of another call
std::vector<double> numbers_of(const Ensemble& ensemble);
Ensemble ensemble_of(std::span<const double> numbers, const ParametricModel& model,
                     std::span<const double> point, const AirSource& air, std::span<const double> times,
                     const RealiseOptions& options = {});

}  // namespace samara::models
