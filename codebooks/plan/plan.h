#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "samara/models/bodies/body_description.h"
#include "samara/models/fields/field_model.h"
#include "samara/models/interface/parametric_model.h"
#include "samara/pgd/axes/axis.h"

namespace samara::codebooks {

/// The least relative tolerance a plan may ask for: the integrator at its tightest is not surely better.
inline constexpr double kLeastTolerance = 1e-10;

/// Calls that a build by sampling may make where the plan sets no limit.
inline constexpr long kMostSampledCalls = 100'000;

/// One free coordinate of a plan: a parameter, an initial value "s(0)", or an input of a command.
struct BoxEntry {
  std::string name;
  double lower = 0.0;  ///< SI
  double upper = 0.0;
  std::optional<int> nodes = {};  ///< of its axis; empty: chosen by the builder
  pgd::Basis basis = pgd::Basis::chebyshev;
  pgd::Transform transform = pgd::Transform::none;
  /// Whether the plan says how the axis is to be discretised, which sampling and slabs do by themselves.
  bool prescribes_axis() const { return nodes || basis != pgd::Basis::chebyshev; }
};

/// A number that a command takes or gives.
struct CommandQuantity {
  std::string name;
  std::string unit;  ///< an SI unit: numbers go to the program and come back as they are
};

/// A program instead of a model, see command_function.h for how it is talked to. A line holds the inputs in
/// order and, if the plan has a time, the times at which it wants the outputs; the answer holds the outputs
/// in order, at the first time, then at the second, ..
struct PlannedCommand {
  std::vector<std::string> run;  ///< program and arguments
  std::vector<CommandQuantity> inputs;
  std::vector<CommandQuantity> outputs;
  double timeout = 60.0;    ///< s, of one batch
  int batch = 1000;         ///< most points of one
  bool persistent = false;  ///< whether the program is kept between batches
};

/// What is asked of a build: the box, the time, the tolerance, the builder.
struct BuildRequest {
  std::string title;
  std::vector<BoxEntry> box;               ///< in the order of the file
  double end = 0.0;                        ///< s; time runs from 0; 0: there is no time (commands only)
  double relative = 1e-3;                  ///< of each output's range over box and time
  std::map<std::string, double> absolute;  ///< floor per output, SI
  /// Share of the box that the certificate must show to be within the tolerance, at 95 % confidence: it takes
  /// 3/(1 - assurance) points, and more after refutations (share_above()). Empty: kCertificatePoints of them.
  std::optional<double> assurance;

  struct Builder {
    std::string kind = "auto";  ///< "auto", "pgd" or "sampling"
    /// "auto" (then "slabs"), one of pgd::strategy_names(), or "newton", by which "cross" is meant.
    std::string strategy = "auto";
    int max_cells = 1;  ///< of kind "pgd": most cells the box is split into
    /// Evaluations of f and its Jacobian beyond which no slab begins; of sampling, trajectories, or
    /// points given to the command, and never more; 0: no limit of the plan's. A trial of "auto" has its own.
    long max_calls = 0;
    /// Most nodes of a parameter's axis (of a cell), and most of a rank; the builder's own limits where left out.
    std::optional<int> max_nodes = {}, max_rank = {};
    /// Random points at which the builder checks itself before the certificate does: of "pgd" those of a cell that are
    /// marched along, of "sampling" those called off the grid.
    std::optional<int> guards = {};
    int threads = 0;  ///< 0: all cores
    std::uint64_t seed = 1;
  } builder;

  /// Whether it prescribes any axis.
  bool prescribes_axes() const;
};

/// A plan of a build (PLAN.toml): a model (of trajectories or of a field) or a command, what is fixed, and what is
/// asked.
struct Plan : BuildRequest {
  std::string model;  ///< its name; empty where there is a command
  /// Of the model; null where there is a command, or a field.
  std::shared_ptr<const models::Model> definition;
  const models::FieldModel* field = nullptr;  ///< of the model, where it is one of a field of space
  std::optional<PlannedCommand> command;      ///< instead of a model
  std::map<std::string, double> fixed;        ///< SI
  std::map<std::string, double> of_body;      ///< those of `fixed` that come from the table [body]

  std::string source;      ///< file the plan came from, for messages; empty if none
  std::string model_file;  ///< of the model, if it is in a file of its own
  std::string text;        ///< the plan as read

  /// How many points its certificate takes: what the assurance asks for, the more the more often certificates have
  /// found earlier fields wrong; by default kCertificatePoints, or fewer of a command, if the plan allows fewer
  /// calls, or if a call takes longer than a minute: then as many as the builder has called.
  int certificate_points(double seconds_per_call = 0.0, double calls = 0.0, int refuted_before = 0) const;
  /// Of the scrambling: other equations, fixed values, boxes, times and relative tolerances, and another kind,
  /// strategy or seed of the builder give other points. All else changes nothing: titles, absolute tolerances, axes,
  /// limits of the builder.
  std::uint64_t certificate_seed() const;

  /// The text, that of a model in another file, and what a mesh gave: plans that differ in none of them have the same
  /// checkpoints.
  std::string whole_text() const;
  /// The model with the plan's fixed and free coordinates.
  /// @throws ArgumentError as ParametricModel does, and for a plan of a command or a field.
  models::ParametricModel parametric_model() const;
};

/// Parameters of the model `kirchhoff_body` for a body in a fluid. A program that links samara::mesh_files makes it of
/// body_in_fluid() and kirchhoff_parameters() (models/added_mass/body_in_fluid.h); plans do not need that library else.
using BodyReader = std::function<std::map<std::string, double>(const models::BodyDescription&)>;

/// Reads a plan. Quantities are SI numbers or strings with a unit.
/// @param body_reader for plans with a table [body], whose mesh lies relative to the plan; its errors get the plan's
/// line
/// @throws InputError, with file and line, for unknown keys, parameters or units, an interval that is empty
/// or reversed, values that are not finite, a body without a reader, and whatever else cannot be a plan.
Plan read_plan(const std::filesystem::path& path, const BodyReader& body_reader = {});

/// The same from text; `name` stands for the file in messages.
/// @param model that the plan is of, whatever it says; null: the one that it says
Plan parse_plan(const std::string& text, const std::string& name,
                const std::shared_ptr<const models::Model>& model = {}, const BodyReader& body_reader = {});

}  // namespace samara::codebooks
