#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "samara/models/parametric_model.h"
#include "samara/pgd/axis.h"

namespace samara::codebooks {

/// The least relative tolerance a plan may ask for: the integrator at its tightest is not surely better.
inline constexpr double kLeastTolerance = 1e-10;

/// One free coordinate of a plan: a parameter or an initial value "s(0)".
struct BoxEntry {
  std::string name;
  double lower = 0.0;  ///< SI
  double upper = 0.0;
  std::optional<int> nodes;  ///< of its axis; empty: chosen by the builder
  pgd::Basis basis = pgd::Basis::chebyshev;
  pgd::Transform transform = pgd::Transform::none;
};

/// A plan of a build (PLAN.toml): a model, what is fixed, the box, the time, the tolerance, the builder.
struct Plan {
  std::string model;
  std::string title;
  std::map<std::string, double> fixed;     ///< SI
  std::vector<BoxEntry> box;               ///< in the order of the file
  double end = 0.0;                        ///< s; time runs from 0
  double relative = 1e-3;                  ///< of each output's range over box and time
  std::map<std::string, double> absolute;  ///< floor per output, SI

  struct Builder {
    std::string kind = "auto";      ///< "auto", "pgd" or "sampling"
    std::string strategy = "auto";  ///< "auto", "slabs" or "newton"
    int max_cells = 1;              ///< of the strategy "slabs"
    /// Of f and its Jacobian; of sampling, trajectories; 0: no limit of the plan's. A trial of "auto" has its
    /// own.
    long max_calls = 0;
    int threads = 0;  ///< 0: all cores
    std::uint64_t seed = 1;
  } builder;

  std::string source;  ///< file the plan came from, for messages; empty if none
  std::string text;    ///< the plan as read

  /// The model with the plan's fixed and free coordinates.
  /// @throws ArgumentError as models::find_model() and ParametricModel do.
  models::ParametricModel parametric_model() const;
};

/// Reads a plan. Quantities are SI numbers or strings with a unit.
/// @throws InputError, with file and line, for unknown keys, parameters or units, an interval that is empty
/// or reversed,
///   values that are not finite, and whatever else cannot be a plan.
Plan read_plan(const std::filesystem::path& path);

/// The same from text; `name` stands for the file in messages.
Plan parse_plan(const std::string& text, const std::string& name);

}  // namespace samara::codebooks
