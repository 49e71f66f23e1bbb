#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/motion/patterns/pattern_rules.h"

/// A sweep: the same fall at many points of a box of coordinates, from one or several releases.
namespace samara::motion {

/// One free coordinate: a parameter of the model, or an initial value "s(0)".
struct SweepAxis {
  std::string name, unit;
  double lower = 0.0, upper = 0.0;  ///< SI
  /// Its values on a grid, increasing; empty: points are drawn between lower and upper.
  std::vector<double> values;
};

/// How a body is let go: tilted about a horizontal axis from its default attitude.
struct Release {
  double tilt = 0.0;  ///< rad; of a planar model theta(0)
  double axis = 0.0;  ///< rad, from the first body axis; of a planar model 0
};

struct SweepPlan {
  std::shared_ptr<const models::Model> model;
  std::map<std::string, double> fixed;  ///< SI
  std::vector<SweepAxis> axes;
  int sample = 0;  ///< scrambled Sobol' points; 0: the grid of all values
  std::uint64_t seed = 1;
  std::vector<Release> releases;  ///< none: the model's own initial values

  double until = 0.0;                 ///< s, end of a fall
  double step = 0.0;                  ///< s, of the integration
  double interval = 0.0;              ///< s, between frames
  double settle = 0.0;                ///< s, left out by the features
  std::optional<double> height = {};  ///< m: a fall ends so far below its release
  bool keep_trajectories = false;
  bool spread = false;  ///< whether Lyapunov exponents are found, which takes several times as long
  PatternThresholds thresholds;
  /// Rounds of new points where labels disagree, see refining.h.
  int refine = 0;
  /// Least growth of the agreement by a round, see refining.h; none: all rounds are run.
  std::optional<double> refine_gain = {};

  std::string source;  ///< file it came from, for messages
  std::string text;

  bool is_grid() const { return sample == 0; }
  /// Points x axes, SI; of a grid the last axis runs fastest.
  Eigen::MatrixXd points() const;
  /// Releases to be run from; one that changes nothing where the plan has none.
  std::size_t release_count() const { return releases.empty() ? 1 : releases.size(); }
  /// The model with the axes free, then what releases and exponents move, see lane_points().
  models::ParametricModel parametric_model() const;
  /// Coordinates of every fall: point after point, each from all releases.
  Eigen::MatrixXd lane_points(const Eigen::MatrixXd& points) const;
};

/// Most falls of a sweep.
inline constexpr long kMostFalls = 10'000'000;

/// SWEEP.toml:
///
///     model = "immersed_body"
///     [fixed]                       # SI, or with units
///     a = "3.5 cm"
///     [axes]                        # a grid; values may be listed: C_T = [0.3, 0.6, 1.2]
///     C_D90 = { from = 0.31, to = 2.71, count = 9 }
///     [sample]                      # or Sobol' points between from and to: count = 2000, seed = 1
///     [releases]                    # each point is run from each tilt about each axis
///     tilt = ["10 deg"]
///     axis = ["0 deg", "35 deg"]
///     [run]                         # height = "2 m", interval, settle, spread, keep = "trajectories"
///     until = "3 s"
///     step = "1 ms"
///     [labels]                      # any threshold: steady_tilt = 0.2
///     [refine]
///     rounds = 5
///     gain = 0.005                  # ends where a round adds less to the share that is told right
///
/// @throws InputError, with file and line, for unknown keys, names or units, empty or reversed ranges, coordinates
/// outside their meaning, a model whose motions have no patterns, or more than kMostFalls falls.
SweepPlan read_sweep_plan(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages.
SweepPlan parse_sweep_plan(const std::string& text, const std::string& name);

}  // namespace samara::motion
