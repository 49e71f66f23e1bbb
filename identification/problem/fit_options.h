#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "samara/base/progress.h"
#include "samara/identification/problem/priors.h"
#include "samara/identification/statistics/loss.h"
#include "samara/models/trajectories/interval.h"
#include "samara/models/trajectories/trajectory_family.h"

namespace samara::identification {

/// The loss and the sizes at which it bends. Residuals are divided by these sizes, so they also weigh outputs
/// of different kinds against each other.
struct LossOptions {
  LossKind kind = LossKind::huber;
  /// m, of every output that is a length: a few times the noise of a good video.
  double length_scale = 2e-3;
  /// rad, of an attitude, if all captures measure its four outputs: the residual is the vector of the turn
  /// between measured and model, in body axes.
  double attitude_scale = 0.035;
  /// Of single outputs, by name, SI. Needed for outputs that are no lengths, unless there is one output only
  /// and the kind is none.
  std::map<std::string, double> scales = {};
};

/// Noise levels from the residuals, in turn with the fit: the variance of an output is what its residuals
/// leave for each of its values, less the unknowns that these determine (W. Foerstner, Allg.
/// Vermess.-Nachr. 86 (1979) 446; in the end, restricted maximum likelihood). With a robust loss it is that
/// of normal noise without outliers (P. J. Huber, Robust Statistics, 1981, ch. 7), and the loss bends where
/// it keeps 95 % of the efficiency of least squares. It begins with `loss.scales`, and for outputs that have
/// none there, with the scatter of frames about a smooth curve.
struct NoiseOptions {
  bool estimated = false;
  /// Outputs, or "attitude", by the name of the level that they share; those not named keep their scale.
  /// Empty: every output has a level of its own.
  std::map<std::string, std::string> levels = {};
  int rounds = 10;  ///< at most; they end when no level moves by more than a percent
};

/// What is not known of the camera, for each capture: every length it saw may be too large or too small by
/// one factor, and its axes may be turned against those of the model, both about the origin.
struct CameraOptions {
  /// Standard deviation, beforehand, of the relative error of lengths: 0.02 is 2 %. Empty: no such unknown.
  std::optional<double> scale = {};
  /// rad: standard deviation, beforehand, of the turn about each axis. Empty: no such unknown.
  std::optional<double> rotation = {};
  /// Outputs that are coordinates of the place, in right-handed order. Empty: those in which the model has a
  /// translation symmetry. A turn needs two or three; the attitude turns with three.
  std::vector<std::string> axes = {};
  /// Outputs that turn with two axes: angles that grow from the first to the second. Empty: those in rad.
  std::optional<std::vector<std::string>> angles = {};
};

/// What is not known of the clock of captures and of the sensors that measured them. The delay, and the gain of
/// each output, are coordinates beside those of the model, by the names "delay" and "gain of x": of each
/// capture's own unless named in `UnknownOptions::shared`. What is said of coordinates there, in `starts.initial`
/// and in `priors` holds for them.
struct MeasurementOptions {
  /// s: between which bounds the time lies that the clock of a capture reads 0 after the release, where the
  /// model starts. A frame at t is compared with the model at t + delay: positive where the clock was started
  /// late. Empty: the clock is right.
  std::optional<models::Interval> delay = {};
  /// Of compared outputs: between which bounds the gain lies, where measured = gain * (what the camera sees of the
  /// model) + offset.
  std::map<std::string, models::Interval> gains = {};
};

/// The names of the coordinates of a measurement.
constexpr const char* kDelay = "delay";
std::string gain_name(const std::string& output);  ///< "gain of x"

/// Where the value of a coordinate that is known for each capture stands: in a label, or, where the capture
/// has no such label, in the first value of a channel of that name. SI, times * value^power: the mass of a
/// disc of paper of which the radius is known is {"radius_m", 0.07 * pi, 2}.
struct KnownValue {
  std::string label;
  double times = 1.0;
  double power = 1.0;

  KnownValue() = default;
  KnownValue(std::string of_label, double factor = 1.0, double exponent = 1.0)
      : label(std::move(of_label)), times(factor), power(exponent) {}
  KnownValue(const char* of_label) : label(of_label) {}
};

/// What of the captures is compared with the model.
struct ComparisonOptions {
  /// s: only this much of each capture, from its first frame. Empty: all of it.
  std::optional<double> span = {};
  /// s: from the start of one span to the next, each with unknowns of its own: see spans() in capture.h.
  /// Empty: one span a capture, from its first frame.
  std::optional<double> stride = {};
  /// Names; empty: every output that all captures measure.
  std::vector<std::string> outputs = {};
  /// Outputs that repeat, with their periods: differences are taken on the circle. Those in rad do by 2 pi,
  /// unless they are named here; 0 for none.
  std::map<std::string, double> periods = {};
  /// Each frame is the running mean of so many frames of the source, centred on it, which come at the interval of the
  /// capture's own (of a mean of blocks of a faster camera this is not true): the model's frames go through the same
  /// mean, from a start that lies half of them earlier. Odd; frames must come at equal times.
  int averaged_frames = 1;
};

/// Which coordinates of the family are fitted, and where they may lie.
struct UnknownOptions {
  /// Coordinates with one value for all captures. Parameters are, unless named in `per_capture`.
  std::vector<std::string> shared = {};
  /// Coordinates with a value of each capture's own. Initial values are, unless named in `shared`.
  std::vector<std::string> per_capture = {};
  /// Coordinates held at a value (SI).
  std::map<std::string, double> fixed = {};
  /// Coordinates that are known for each capture, in the family's box. Captures that are left out of a fit
  /// and predicted (prediction.h) may lack the value: there the coordinate is one of their own unknowns.
  std::map<std::string, KnownValue> known = {};
  /// Intervals within the family's box that the fit must not leave (SI).
  std::map<std::string, models::Interval> box = {};
  /// Shared coordinates that move by factors, not by differences; their boxes must be positive.
  std::vector<std::string> log_scale = {};
  /// Outputs that get a free constant for each capture, added to the model. Empty: those in which the model
  /// has a translation symmetry and whose initial value is not a coordinate.
  std::optional<std::vector<std::string>> offsets = {};
};

/// Multiple shooting: every capture is cut into segments with a start state of each own. That a segment ends
/// where the next begins is a penalty on the difference, which is raised in stages until it is a constraint:
/// so that motion which forgets its start within a swing does not hide the coefficients.
struct SegmentOptions {
  /// s: segments are as near to it as frames allow. About one swing of the body or less, and less than the
  /// time in which neighbours part by a factor of e. Empty: one segment is the whole capture.
  std::optional<double> length = {};
  /// Weights of a difference between segments, relative to how well a segment alone determines its start.
  std::vector<double> stages = {0.05, 0.5, 5.0, 50.0, 500.0};
};

/// Global searches of NLopt (S. G. Johnson, github.com/stevengj/nlopt).
enum class GlobalMethod {
  none,
  controlled_random,  ///< "crs": P. Kaelo, M. M. Ali, J. Optim. Theory Appl. 130 (2006) 253-264
  direct,             ///< "direct": J. M. Gablonsky, C. T. Kelley, J. Global Optim. 21 (2001) 27-37
  evolution,          ///< "isres": T. P. Runarsson, X. Yao, IEEE Trans. Syst. Man Cybern. C 35 (2005) 233-243
};

/// "none", "crs", "direct", "isres".
std::string to_string(GlobalMethod method);
/// @throws ArgumentError naming the nearest.
GlobalMethod global_method_from_string(const std::string& name);

/// A search of the whole box of the shared coordinates, whose best point is the first start.
struct GlobalOptions {
  GlobalMethod method = GlobalMethod::none;
  int budget = 300;  ///< points of the box that are looked at
  std::uint64_t seed = 1;
};

/// Where the descents to a minimum begin.
struct StartOptions {
  /// From the centre of the box, or from `initial`, and from quasi-random points inside the box; 1 to 10000.
  int count = 3;
  /// Where the first start has shared coordinates (SI), in place of the centre of their boxes.
  std::map<std::string, double> initial = {};
  GlobalOptions global = {};
  /// Where `segments.length` is given and segments are not joined: how often at most start states are found
  /// (from the coefficients of the last time, the last start states among the candidates) and all is fitted.
  /// It ends earlier where the cost falls no more.
  int rounds = 1;
  /// The body moves alike after any turn about its z axis: start attitudes do not turn that way. Not with
  /// joined segments.
  bool round_body = false;
};

struct SolverOptions {
  /// s: a model without a codebook is integrated by Runge-Kutta steps of this length (step_trajectories.h).
  /// Empty: by the reference integrator. Read by whoever makes the family; fit() takes the family as it is.
  std::optional<double> step = {};
  /// File of a codebook of the model that gives what it covers (mixed_trajectories.h); empty: none. Read likewise.
  std::string codebook = {};
  /// Of each start and round: steps of the shared unknowns, where those of each capture settle between them.
  int max_iterations = 500;
};

/// Errors from fits with random weights, cluster by cluster: see FitResult::bootstrap.
struct BootstrapOptions {
  int replicates = 0;  ///< 0: none; 50 tell an error to 10 %
  std::uint64_t seed = 1;
};

/// Draws of all unknowns from what captures, priors and boxes say of them together: see FitResult::posterior.
struct PosteriorOptions {
  /// In four chains; 0: none. A thousand tell the ends of a 95 % interval to 7 % of a deviation.
  int samples = 0;
  std::uint64_t seed = 1;
};

/// What is said of the errors of coefficients.
struct UncertaintyOptions {
  /// Columns of the captures' labels: captures with the same labels there count as one observation of the
  /// coefficients. Empty: each capture is one.
  std::vector<std::string> cluster_by = {};
  /// The profile of every shared coefficient: some ten fits each, with it held. Whether it is
  /// determined, bounded to one side, or not at all, and an interval that follows bends.
  bool profiles = false;
  BootstrapOptions bootstrap = {};
  PosteriorOptions posterior = {};

  /// Without what takes further fits or draws: for fits of which only the values are asked.
  UncertaintyOptions without_intervals() const { return {.cluster_by = cluster_by}; }
};

struct FitOptions {
  ComparisonOptions compared = {};
  LossOptions loss = {};
  NoiseOptions noise = {};
  UnknownOptions unknowns = {};
  PriorOptions priors = {};
  CameraOptions camera = {};
  MeasurementOptions measurement = {};
  SegmentOptions segments = {};
  StartOptions starts = {};
  SolverOptions solver = {};
  UncertaintyOptions uncertainty = {};
  /// Told before each start; where it asks for an end, starts that remain are left out (the first never is).
  ProgressCallback progress = {};
};

/// Delay and gains that the options ask for, in the order of their coordinates.
std::vector<std::string> measurement_names(const FitOptions& options);

/// What is fixed of the model, for whoever makes its family: without the delay and the gains.
std::map<std::string, double> fixed_of_model(const FitOptions& options);

/// @throws ArgumentError naming field, value and requirement.
void validate(const FitOptions& options);

}  // namespace samara::identification
