#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/models/interface/parametric_model.h"
#include "samara/motion/planning/motion_sequence.h"
#include "samara/motion/planning/sketch.h"

namespace samara::codebooks {
class Codebook;
}

/// What a fall is asked to be: MOTION.toml, as a value.
namespace samara::motion {

/// A coefficient that may change while the body falls.
struct SteeredCoefficient {
  std::string name;
  double lower = 0.0, upper = 0.0;
  /// Its value for the body as it is: where a fall begins, and what turbulence moves it from.
  double natural = 0.0;
};

struct MotionSearch {
  int beam = 64;      ///< falls that are kept at each event
  int children = 48;  ///< ways that each of them is continued
  int sweeps = 2;     ///< of windows over the fall that was found; none where only a sequence is asked
  double step = 0.0;  ///< s, of the integration
  double ramp = 0.0;  ///< s, in which coefficients go from value to value
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: as many as the machine has
};

struct MotionPlan {
  std::shared_ptr<const models::Model> model;
  /// SI, parameters and initial values, the natural coefficients among them.
  std::map<std::string, double> fixed;
  std::vector<SteeredCoefficient> box;

  std::optional<Sketch> sketch;
  std::optional<Eigen::Vector3d> landing;  ///< where the body is to come down, m, its height unused
  double ground = 0.0;                     ///< m, height at which the fall ends
  std::optional<double> duration;          ///< s, after which the fall ends
  /// Root mean square distance from the sketch, or distance from the landing place, that is good enough [m].
  std::optional<double> deviation;
  /// Of the surrounding air, u'/U: how far it makes coefficients roam is what their changes cost. 0: no such cost.
  double turbulence = 0.0;
  /// Falls of this body: their coefficients are tried where they did what is asked, in states like its own.
  std::shared_ptr<const MotionDatabase> database;
  /// Windows of this body (codebooks/composition/flow_map.h), of which the refining of a fall takes tangents.
  std::shared_ptr<const codebooks::Codebook> codebook;
  std::optional<MotionSequence> sequence;
  MotionSearch search;

  std::string source;              ///< file it came from, for messages
  std::vector<std::string> files;  ///< others that it names
  std::string text;

  /// Semi-length of the body, the unit of deviations in costs; the model's length where it does not say [m].
  double semi_length() const;
  models::Scales scales() const;
  double release_height() const;
  bool starts_at_rest() const;
  /// Whether the body, at rest as it is let go, begins to sink.
  bool sinks() const;
  /// About how many steps the fall takes: to the ground at the model's velocity scale, or to its duration.
  double steps() const;
  /// Plans of more are refused: they would be searched for hours.
  static constexpr double kMostSteps = 1e6;
};

/// What a fall costs, in semi-lengths squared: the parts of one sum, see fall_cost.h.
struct FallCost {
  double path = 0.0, changes = 0.0, turbulence = 0.0, kinds = 0.0, landing = 0.0;
  double total() const { return path + changes + turbulence + kinds + landing; }
};

/// One round of the search, or one sweep of what comes after it.
struct PlanningStep {
  std::string stage;   ///< "beam" or "windows"
  double cost = 0.0;   ///< of the best fall so far
  double depth = 0.0;  ///< m, how far the best one has fallen
  long pieces = 0;     ///< falls from one decision to the next that were run
};

/// What a plan's codebook did where tangents were asked for.
struct BookUse {
  long windows = 0;            ///< of the codebook that were asked, cut short where a fall was looked at
  long served = 0, asked = 0;  ///< steps of falls: whose tangents they gave, and all

  /// 0 where none were asked for.
  double share() const { return asked > 0 ? static_cast<double>(served) / static_cast<double>(asked) : 0.0; }
  BookUse operator+(const BookUse& more) const {
    return {windows + more.windows, served + more.served, asked + more.asked};
  }
};

/// MOTION.toml:
///
///     model = "falling_plate"
///     database = "motions.h5"       # of samara database, beside this file: falls to take coefficients from
///     codebook = "windows.h5"       # of samara build, a flow map of this body: for tangents
///     duration = "2 s"              # after which the fall ends, if it has not landed
///     [body]                        # parameters and initial values: SI, or with units
///     semi_chord = "7 mm"
///     [release]                     # height = where it is let go above the ground, tilt (and axis, in space)
///     height = "40 cm"
///     tilt = "34 deg"
///     [path]
///     file = "sketch.csv"           # beside this file
///     deviation = "5 mm"            # that is good enough
///     # or, in place of a file, a line by formula, see sketch_of(): in a plane
///     side_to_side = { descent_speed = "30 cm/s", horizontal_speed = "50 cm/s", vertical_speed = "10 cm/s",
///                      angular_frequency = "12 rad/s" }
///     # in space rose = { descent_speed, amplitude_x, amplitude_y, modulation, lobes, angular_frequency }
///     [landing]                     # beside or instead of [path]: x = "10 cm" (and y, in space), deviation
///     [sequence]                    # kinds or patterns, see motion_sequence.h, beside these or alone
///     [box]                         # what may change, and how far
///     C_T = [0.8, 1.4]
///     C_R = "series.h5"             # as far as it goes in the series of samara fit --series
///     [turbulence]
///     intensity = 0.1
///     [search]                      # beam, children, sweeps, step, ramp, seed
///
/// @throws InputError, with file and line, for unknown keys, names or units, values outside their meaning, an empty
/// or reversed range, a sketch that rises (or, with times, faster than falls of the database, or above the release)
/// or begins below the release, a body that does not sink, a database or codebook of another body, a codebook that is
/// no flow map, a sequence that is given and of which the database has no fall within the box or no way from one to
/// the next, or a plan that asks for nothing.
MotionPlan read_motion_plan(const std::filesystem::path& path);
/// The same from text; `name` stands for the file in messages, files it names are beside it.
MotionPlan parse_motion_plan(const std::string& text, const std::string& name);

}  // namespace samara::motion
