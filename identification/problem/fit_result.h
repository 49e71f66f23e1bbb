#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "samara/base/termination.h"
#include "samara/identification/forecasts/baseline_scores.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/identification/problem/warnings.h"
#include "samara/identification/statistics/identifiability.h"
#include "samara/identification/statistics/profile.h"
#include "samara/identification/statistics/whiteness.h"

namespace samara::identification {

/// A coordinate that all captures share.
struct Coefficient {
  std::string name = {};
  std::string unit = {};
  double value = 0.0;
  double lower = 0.0;  ///< of its box
  double upper = 0.0;
  /// From the scatter between clusters of captures. Empty for fewer than two clusters, at a bound, and where
  /// the captures do not determine the coefficient.
  std::optional<double> standard_error = {};
  /// As if all frames were independent: usually much too small.
  std::optional<double> naive_standard_error = {};
  bool at_bound = false;
  bool determined = true;
  /// Of what is known of it, the part that each cluster of captures gives; they sum to 1, less what priors
  /// give. Empty for fewer than two clusters, and where there is no error.
  std::vector<double> cluster_shares = {};
  /// So many clusters that say equally much would give as rough an error (cluster_errors.h): where it is
  /// below 2.5 one or two carry the coefficient, and its standard error is at least what the scatter of all
  /// clusters in all coefficients gives.
  std::optional<double> effective_clusters = {};
  /// By how much it would move, to first order, if the steps of the trajectories were half as long. Empty
  /// where trajectories are not made of steps of one length, at a bound, and where not determined.
  std::optional<double> integration_shift = {};
};

/// One capture's own: an initial value, the "offset of x", the "scale" of its camera, or a "turn" of it.
struct Nuisance {
  std::string name = {};
  std::string unit = {};
  double value = 0.0;
  std::optional<double> standard_error = {};  ///< naive
  bool at_bound = false;
};

/// Root mean square of measured - model, in the unit of the output.
struct OutputRms {
  std::string output;
  std::string unit;
  double rms = 0.0;
};

struct CaptureFit {
  std::string id = {};
  std::string file = {};
  std::string checksum = {};  ///< of the bytes of the file; empty: not known
  std::string whole = {};     ///< id of the capture of which it is all, or a span
  std::map<std::string, std::string> labels = {};
  std::vector<std::string> notes = {};       ///< what reading and cleaning did to it
  std::map<std::string, double> known = {};  ///< values of UnknownOptions::known, SI
  int cluster = 0;                           ///< number of its cluster, from 0
  int frames = 0;                            ///< in the span, with something to compare
  int segments = 1;
  double start = 0.0;     ///< s, of the first segment, in the capture's times
  double interval = 0.0;  ///< s, between the frames that are means of several; 0 where frames are no means
  /// At the start of the first segment.
  std::vector<Nuisance> nuisances = {};
  std::vector<OutputRms> residuals = {};
  /// For pictures: the frames used, and per fitted output what was measured (NaN if missing) and what the
  /// model says, its offset included. Frames x outputs, SI.
  Eigen::VectorXd times = {};
  Eigen::MatrixXd measured = {};
  Eigen::MatrixXd model = {};
};

struct StartRecord {
  Termination status = Termination::failed;  ///< or converged, max_iterations
  std::string message = {};
  std::vector<double> coefficients = {};  ///< where it ended, in the order of FitResult::coefficients
  double cost = 0.0;
  int iterations = 0;
  bool reached_best = false;
};

/// Where another start ended that the captures cannot tell from the answer: see other_optima.h.
struct OtherOptimum {
  std::vector<double> coefficients = {};     ///< in the order of FitResult::coefficients
  std::vector<double> standard_errors = {};  ///< there; NaN where there is none
  double cost = 0.0;
  double excess = 0.0;        ///< of its cost over that of the answer
  double excess_error = 0.0;  ///< standard error of that, from clusters; NaN for fewer than two
};

/// What the fit found of the noise of one output, or of several that share a level.
struct NoiseLevel {
  std::vector<std::string> outputs = {};  ///< "attitude" for the turns of attitudes, about each axis
  std::string unit = {};
  double value = 0.0;               ///< standard deviation; where it was not estimated, what was assumed
  double degrees_of_freedom = 0.0;  ///< values compared, less the unknowns that they determine
  bool estimated = false;
  double standard_error() const;  ///< of the value, for normal noise
};

/// A search of the whole box before the fit itself.
struct GlobalSearch {
  std::string method = {};  ///< to_string(GlobalMethod)
  int evaluations = 0;      ///< points of the box looked at
  double cost = 0.0;        ///< the least met, segments not joined; NaN if no point had a trajectory
  double seconds = 0.0;
};

/// Fits of the same captures with clusters weighted at random, and the means of priors drawn anew, from the
/// answer on (D. B. Rubin, Ann. Statist. 9 (1981) 130-134): unlike clustered standard errors, which follow
/// the slopes at the answer, they move away from it, and show where it bends. They do not look for other
/// optima.
struct Bootstrap {
  int replicates = 0;  ///< that did not fail
  int converged = 0;   ///< of them; the others stopped at the limit on iterations, short of their minimum
  std::uint64_t seed = 1;
  Eigen::MatrixXd coefficients = {};  ///< replicates x coefficients, SI
  /// Their scatter, widened by sqrt((C + 1)/(C - 1)) for C clusters: beside the clustered standard errors.
  /// NaN at a bound.
  std::vector<double> standard_errors = {};
};

/// One unknown of a posterior, SI.
struct PosteriorUnknown {
  std::string name = {};  ///< of the coefficient; or of the capture, and after a colon of its own unknown
  double mean = 0.0;
  double deviation = 0.0;
  double lower = 0.0, median = 0.0, upper = 0.0;  ///< 95 % lie between lower and upper, 2.5 % on either side
  double rhat = 0.0;       ///< 1 where the chains agree; above 1.01 they have not found the same (chains.h)
  double effective = 0.0;  ///< independent draws that tell the mean as well
};

/// Draws of all unknowns together (posterior.h): unlike errors, which are those of a parabola at the answer, they
/// follow bends, corners of the box, and several valleys if chains reach them. Frames count as independent.
struct Posterior {
  int chains = 0;
  std::uint64_t seed = 1;
  double acceptance = 0.0;  ///< mean share of proposals taken
  int divergences = 0;   ///< proposals whose energy was lost: where there are some, draws may lack a corner
  long evaluations = 0;  ///< trajectories of single captures
  std::vector<PosteriorUnknown> unknowns = {};  ///< coefficients first, in their order
  Eigen::MatrixXd draws = {};                   ///< draws, chain after chain, x unknowns, SI

  /// Whether chains agree on all unknowns, without divergences and with 400 effective draws of each.
  bool is_settled() const;
};

struct FitResult {
  /// converged; not_determined: converged, but coefficients can change together without changing the residuals;
  /// max_iterations: the best point so far; failed: no start succeeded, the values mean nothing.
  Termination status = Termination::failed;
  std::string message = "the fit did not run";  ///< why it stopped, in one sentence
  Warnings warnings = {};

  std::string model = {};
  std::string source = {};  ///< as models::FamilyInfo
  std::string loss = {};
  std::map<std::string, double> fixed = {};  ///< everything that was held, SI
  /// How captures were seen, all names resolved: what a fit of further captures takes over. Outputs, roles of
  /// coordinates, boxes, offsets, camera, means of frames, priors of each capture's own; known coordinates
  /// stand in labels of their own names. Nothing else is set.
  FitOptions setup = {};

  std::vector<Coefficient> coefficients = {};
  /// Of the coefficients, from the scatter between clusters where there are two or more, else naive. Rows and
  /// columns of coefficients without a standard error are NaN.
  Eigen::MatrixXd covariance = {};
  Eigen::MatrixXd correlation = {};
  /// Of the coefficients, frames taken as independent; NaN likewise.
  Eigen::MatrixXd naive_covariance = {};
  /// Second derivative of the cost by the coefficients, priors included, own unknowns eliminated.
  Eigen::MatrixXd information = {};
  int clusters = 0;
  std::vector<std::string> cluster_names = {};  ///< what their captures have in common: "flight 98"

  std::vector<CaptureFit> captures = {};
  std::vector<OutputRms> residuals = {};  ///< over all captures

  /// 1/2 sum of rho over frames and outputs, residuals divided by their loss scale: no unit.
  double cost = 0.0;
  int residual_count = 0;
  /// Of multiple shooting: the largest difference between the end of a segment and the start of the next,
  /// over how well a segment alone determines its start. Joins hold where it is small beside 1.
  std::optional<double> join_defect = {};
  /// The largest of the coefficients' integration_shift over its standard error: what the length of the steps
  /// does to the answer. Empty where trajectories are not made of steps of one length.
  std::optional<double> integration_shift = {};
  std::vector<NoiseLevel> noise = {};  ///< if it was to be estimated
  int noise_rounds = 0;                ///< so often the levels were estimated, and all fitted again
  std::vector<StartRecord> starts = {};
  int starts_at_best = 0;  ///< starts that ended at the best cost
  std::vector<OtherOptimum> other_optima = {};
  int iterations = 0;    ///< over all starts
  long evaluations = 0;  ///< trajectories of single captures
  double seconds = 0.0;

  // What may be claimed; empty where it was not asked for or could not be computed.
  std::vector<Profile> profiles = {};  ///< of coefficients, by name
  std::optional<Identifiability> identifiability = {};
  std::optional<Whiteness> whiteness = {};
  std::vector<PredictionScore> predictions = {};          ///< on captures or spans left out of the fit
  std::vector<PredictionScore> capture_predictions = {};  ///< the same of each capture by itself
  std::optional<GlobalSearch> global_search = {};
  std::optional<Bootstrap> bootstrap = {};
  std::optional<Posterior> posterior = {};

  /// Null if the coefficient has none.
  const Profile* find_profile(const std::string& coefficient) const;

  /// Converged, with every coefficient determined.
  bool is_usable() const { return status == Termination::converged; }
};

/// The error of which two to either side hold 95 %: the standard error, or that of the bootstrap where there
/// is one and it is larger, times t/1.96 with the quantile t of Student's distribution for the clusters on
/// which it rests; the naive error where there is no other. Empty where there is none.
/// @param coefficient one of the result's
std::optional<double> widened_error(const FitResult& result, const Coefficient& coefficient);

/// The one or two clusters that carry a coefficient, by number; empty where more do.
std::vector<int> carriers(const FitResult& result, const Coefficient& coefficient);

/// What may be said of a coefficient, in words, from its profile if it is determined at all and has one, else
/// from its widened error: "1.17 +- 0.098", "1.05 to 1.31 (95 %)", "at least 0.83 (95 %)", "not determined",
/// "at a bound of its box"; "not converged, stopped at 1.17", "1.68 +- 0.11 or 0.87 +- 0.08" where another
/// optimum is as good, "1.17 +- 0.098, by flight 98 almost alone" where one or two clusters carry it.
/// @param coefficient one of the result's
std::string verdict(const FitResult& result, const Coefficient& coefficient);

}  // namespace samara::identification
