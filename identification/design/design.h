#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "samara/base/progress.h"
#include "samara/identification/problem/fit_result.h"
#include "samara/identification/problem/warnings.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

/// The next experiment: which releases, seen how long and in which outputs, shrink the errors of a fit the
/// most.
///
/// The fit so far says of the coefficients c what its covariance says, F_0 = cov^-1. One capture more,
/// released at r, adds what it would add to the next fit with the captures' own unknowns o (starts, offsets,
/// camera) eliminated,
///
///     I(r; c) = J_c^T J_c - (J_c^T J_o) (J_o^T J_o + P)^-1 (J_o^T J_c),
///
/// with the derivatives J of all that is seen, from the family itself, over the noise of each output (what
/// the fit found or, where it did not look, what its residuals leave), and P of priors of own unknowns.
/// Expected is
///
///     cov(c) = (F_0 + sum_i I(r_i; c))^-1,
///
/// and chosen is what makes it small in the mean over draws of c from what is known so far, since a design
/// for one value of c may be poor for its neighbour (K. Chaloner, I. Verdinelli, Statist. Sci. 10 (1995)
/// 273-304):
///
///     D:  mean of log det cov,     A:  mean of sum_k cov_kk/s_k^2,     s_k = max(|c_k|, standard error of c_k),
///
/// both of the coefficients asked for only, if some are named. D does not depend on the units of coefficients
/// at all, A counts relative errors. Releases are taken from Sobol' points of the box, added one by one and
/// exchanged while that helps (V. V. Fedorov, Theory of Optimal Experiments, 1972), then each is moved by
/// NLopt's subplex with the others held, in turns (R. K. Meyer, C. J. Nachtsheim, Technometrics 37 (1995)
/// 60-69).
///
/// Where the fit's errors are clustered, because residuals are not white or clusters scatter by more than
/// chance, the noise of new captures is raised by the same factor: a new capture then says as much as an old
/// one of its kind did.
///
/// What it does not know: errors that all captures share; what the model lacks at releases never seen; and that
/// errors follow slopes, so that valleys beside the answer are not in them.
///
///     const FitResult fitted = read_fit("fit.json");
///     const Design design = design_experiment(*codebook_trajectories(book), fitted, {.captures = 3});
///     std::cout << design_text(design);
namespace samara::identification {

enum class DesignCriterion {
  determinant,  ///< "D": the volume of what remains possible
  trace,        ///< "A": the mean square of relative errors
};

/// "D", "A".
std::string to_string(DesignCriterion criterion);
/// @throws ArgumentError for other texts.
DesignCriterion design_criterion_from_string(const std::string& name);

struct DesignOptions {
  int captures = 1;  ///< further ones; 1 to 100
  /// s, of each capture. Empty: that of the longest capture of the fit, at most the family's.
  std::optional<double> duration = {};
  /// Of each capture, equally spaced from 0 to `duration`. Empty: at the median interval of the fit's captures.
  std::optional<int> frames = {};
  /// Coordinates that can be chosen; the others are held where the captures of the fit were in the mean.
  /// Empty: all that were not coefficients: initial values, and what was each capture's own or known of it.
  std::vector<std::string> release = {};
  /// SI: narrower intervals for them; from and to the same value, they are held there.
  std::map<std::string, models::Interval> box = {};
  /// What the camera sees. Empty: what the fit compared. "attitude" stands for the four outputs of one.
  std::vector<std::string> outputs = {};
  /// SI: standard deviation of the noise of outputs, where the camera is another one.
  std::map<std::string, double> noise = {};
  DesignCriterion criterion = DesignCriterion::determinant;
  std::vector<std::string> coefficients = {};  ///< whose errors count; empty: all
  int times = 0;                               ///< how many best frames to choose; 0: none are chosen
  int draws = 8;                               ///< of the coefficients; 1: only the answer of the fit itself
  std::uint64_t seed = 1;                      ///< of draws and first points
  ProgressCallback progress = {};  ///< where it asks for an end, releases are left as they are then
};

/// @throws ArgumentError naming field, value and requirement.
void validate(const DesignOptions& options);

/// What is known of a coefficient, SI.
struct ExpectedError {
  std::string name = {};
  std::string unit = {};
  double value = 0.0;
  /// Standard error of the fit; where it gave none, that of a uniform distribution over the box.
  double now = 0.0;
  bool was_determined = true;  ///< whether the fit gave one
  double expected = 0.0;       ///< after the proposed captures: root mean square over draws
};

/// A coordinate of the release, SI.
struct ReleaseCoordinate {
  std::string name = {};
  std::string unit = {};
  double lower = 0.0;  ///< the same as `upper` where it is held
  double upper = 0.0;
};

struct ProposedCapture {
  std::vector<double> release = {};  ///< in the order of Design::coordinates, SI
  double followed = 1.0;             ///< part of the draws that have a trajectory there, to the end
};

/// Errors are means as the criterion takes them, over that of the fit so far: 1 is no gain.
struct OutputWorth {
  std::string output = {};  ///< or "attitude"
  std::string unit = {};
  double noise = 0.0;    ///< standard deviation, SI
  double alone = 1.0;    ///< error if nothing else is seen
  double without = 1.0;  ///< error if all but this is seen
};

/// The same releases, seen up to a time.
struct FilmLength {
  double duration = 0.0;  ///< s
  double error = 1.0;
  double share = 0.0;  ///< of the precision that the whole films add, 1/mean variance
};

/// The same releases and times, with fewer frames.
struct FrameCount {
  int frames = 0;
  double error = 1.0;
};

struct Design {
  std::string model = {};
  std::string source = {};
  DesignCriterion criterion = DesignCriterion::determinant;
  std::vector<std::string> of = {};  ///< the coefficients whose errors count
  double duration = 0.0;             ///< s
  int frames = 0;
  bool errors_are_clustered = false;
  double inflation = 1.0;  ///< of the variance of noise, for what is common to the frames of a capture
  int draws = 0;

  std::vector<ExpectedError> coefficients = {};
  std::vector<ReleaseCoordinate> coordinates = {};
  std::vector<ProposedCapture> captures = {};
  double error = 1.0;         ///< expected, over that of the fit so far
  double random_error = 1.0;  ///< median of as many releases anywhere in the box; NaN where none was chosen
  std::vector<OutputWorth> outputs = {};      ///< the one most missed first
  std::vector<FilmLength> lengths = {};       ///< frame by frame, of long films every so many
  double sufficient_duration = 0.0;           ///< s, with nine tenths of the precision
  std::vector<FrameCount> frame_counts = {};  ///< a half, a quarter, an eighth
  std::vector<double> times = {};             ///< s, the best ones, if they were asked for
  double times_error = 1.0;                   ///< with these alone
  Warnings warnings = {};
  long evaluations = 0;  ///< trajectories
  double seconds = 0.0;
};

/// @param fitted by fit(), or read by read_fit(), of the family's model
/// @throws ArgumentError for options outside their meaning; for a fit that has no coefficients, or whose model,
/// coefficients, own coordinates or outputs the family does not have, or whose errors or noise are not
/// positive numbers; for films longer than the family's times or with fewer frames than unknowns.
/// @throws NoResultError if no release in the box has a trajectory to the end of the film.
Design design_experiment(const models::TrajectoryFamily& family, const FitResult& fitted,
                         const DesignOptions& options = {});

/// The same of given releases: nothing is searched.
/// @param releases each in the order of Design::coordinates, SI; Design::captures has them
/// @throws as design_experiment(), NoResultError if none of them has a trajectory, and ArgumentError for
/// releases of another size or outside the box.
Design assess_releases(const models::TrajectoryFamily& family, const FitResult& fitted,
                       std::span<const std::vector<double>> releases, const DesignOptions& options = {});

}  // namespace samara::identification
