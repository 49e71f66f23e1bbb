#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/identification/captures/capture.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/warnings.h"
#include "samara/models/interface/model.h"

/// Coefficients that change along a motion ("instantaneous coefficients"), as a series in time that a
/// simulation can replay.
///
/// A span of the capture gets a value of each coefficient at its centre; between centres (and the first and
/// last frame, which have values too) coefficients are straight lines. All values are fitted at once, with
/// the start states of the spans and the coefficients that stay constant:
///
///     1/2 sum rho((measured - model)/scale) + 1/2 sum_j sum_k (D c_j)_k^2/s_j^2,
///
/// where D takes first or second differences of neighbouring values, and s_j is the size of a difference that
/// is to be expected. A series can follow anything; what it may follow, s_j says. It is the caller's, or it
/// is chosen: of several factors f in s_j = f |constant fit of c_j| the one of the largest restricted
/// likelihood (Laplace's approximation; S. N. Wood, J. R. Stat. Soc. B 73 (2011) 3-36), which prefers no
/// change where the capture shows none.
///
/// Spans either adjoin and are joined (the motion is one, as in a replay), or slide by `stride`, each with
/// a start state of its own: then what the model misses in one span does not spoil the next. A frame counts in
/// each span in which it lies, by one over the mean number of these: less than once near the ends of a capture,
/// where spans are fewer, and more than once between.
///
/// Errors. With D the information of the captures about all shared values, P that of the differences, and phi
/// the variance of a residual, cov = phi (D + P)^-1, phi = 2 cost/(n - own - trace((D + P)^-1 D)), and errors
/// grow by sqrt((1 + r)/(1 - r)) where residuals are correlated from frame to frame. The diagonal of the
/// resolution (D + P)^-1 D says how much of a value its own frames have decided, and how much its neighbours
/// through smoothness.
///
///     const auto series = fit_series(find_model("falling_plate"), captures, options,
///                                    {.coefficients = {"C_R"}, .span = 0.04});
///     codebooks::save(series_codebook(series), "series.h5");
namespace samara::identification {

struct SeriesOptions {
  /// Parameters of the model that change along the captures; free in the box of the fit, which holds at every
  /// instant.
  std::vector<std::string> coefficients = {};
  /// Length of a span [s], or in the model's unit of time.
  double span = 0.0;
  /// From span to span, at most the span; each then has a start state of its own. Strides are so much shorter that
  /// the last span ends at the last frame. Empty: spans adjoin and are joined.
  std::optional<double> stride = {};
  int order = 2;  ///< of the differences that are small: 1 or 2
  /// Of coefficients, in their units: the size of a difference between neighbours a stride apart. Those that
  /// are not named get one common factor times their constant value, chosen by the captures.
  std::map<std::string, double> scales = {};
};

/// @throws ArgumentError naming field, value and requirement.
void validate(const SeriesOptions& options);

/// What a value at an instant rests on.
enum class InstantBasis {
  frames,      ///< half of it or more on the frames around it
  neighbours,  ///< on smoothness: the frames around it do not tell it from its neighbours
  bound,       ///< at a bound of its box: the best value is probably outside
  nothing,     ///< not determined: its error is as large as that of a uniform distribution over the box
};

/// "frames", "neighbours", "bound", "nothing".
std::string to_string(InstantBasis basis);

struct SeriesCoefficient {
  std::string name = {};
  std::string unit = {};
  double scale = 0.0;                    ///< of differences, as used
  double constant = 0.0;                 ///< its value where nothing may change
  Eigen::VectorXd values = {};           ///< at the instants, SI
  Eigen::VectorXd standard_errors = {};  ///< NaN at a bound and where nothing determines the value
  Eigen::VectorXd shares = {};           ///< diagonal of the resolution: 1 is frames alone
  std::vector<InstantBasis> basis = {};
  /// The most that steps of half the length would move a value by, in its standard errors. Empty: steps have no length,
  /// or no value an error.
  std::optional<double> integration_shift = {};
};

/// One smoothness that was tried.
struct SmoothnessTrial {
  double factor = 0.0;
  double criterion = 0.0;  ///< -2 log of the restricted likelihood, up to a constant; NaN if there was no fit
  double effective = 0.0;  ///< how many free values the series has used: trace of the resolution
};

struct CoefficientSeries {
  Termination status = Termination::failed;  ///< as of `fit`; also if none came about
  std::string message = "the fit did not run";
  Warnings warnings = {};  ///< those of `fit` first

  std::string model = {};
  std::string time_unit = {};
  bool joined = true;
  int spans = 0;
  Eigen::VectorXd instants = {};  ///< in the captures' times
  std::vector<SeriesCoefficient> coefficients = {};
  /// The factor of the scales that were not given; empty if all were.
  std::optional<double> factor = {};
  std::vector<SmoothnessTrial> trials = {};
  double effective = 0.0;           ///< free values used by all coefficients
  double correlation_factor = 1.0;  ///< by which errors grew because residuals are correlated
  /// What a replay needs besides: fixed parameters, coefficients that stayed constant, and of the capture that begins
  /// first what is known of it or its own, and the state at its first frame ("s(0)", offsets added to what they
  /// shift; not of averaged frames, nor where nothing is compared at the first instant).
  std::map<std::string, double> replay = {};
  std::map<std::string, std::string> replay_units = {};

  FitResult constant = {};  ///< the same fit where nothing changes
  FitResult fit = {};       ///< with a coefficient "C_R@0.125" for each value
};

/// Fits first with constant coefficients, to which `options.starts` belong; the others begin from there.
/// @param model whose coefficients are fitted
/// @param captures their times are on one axis: all see the same series
/// @param options with `unknowns.fixed`, `unknowns.box` (of the coefficients too), and for fixed steps
///   `solver.step`
/// @throws ArgumentError as fit(), and for spans longer than half of the captures, coefficients that are no
///   parameters or not free, options outside their meaning, profiles and a bootstrap, a delay and gains; where
///   spans slide, for segments, noise to be estimated, and all that belongs to the start of a capture: states that
///   are not free, their priors, a camera, and parameters of each capture.
CoefficientSeries fit_series(const std::shared_ptr<const models::Model>& model,
                             std::span<const Capture> captures, const FitOptions& options,
                             const SeriesOptions& series);

}  // namespace samara::identification
