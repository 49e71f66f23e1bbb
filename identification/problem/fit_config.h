#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "samara/codebooks/book/codebook.h"
#include "samara/identification/problem/fit_options.h"
#include "samara/models/interface/model.h"
#include "samara/models/laws/registry.h"

/// Options of a fit from a TOML file:
///
///     span = "0.4 s"
///     stride = "0.4 s"                                # a span every 0.4 s, not one at the start of a capture
///     outputs = ["x", "theta"]
///     loss = { kind = "huber", scale = "2 mm" }       # or scale = { x = "2 mm", theta = "3 deg" }
///     shared = ["C_D"]
///     per_capture = ["v(0)"]
///     offsets = ["x"]
///     cluster_by = ["drop"]
///     starts = 3
///     max_iterations = 500
///     profiles = true
///     bootstrap = 100                                 # or { replicates = 100, seed = 1 }
///     segments = "60 ms"                              # or { length = "60 ms", stages = [0.05, 0.5, 5, 50] }
///     global = "crs"                                  # or { method = "crs", budget = 300, seed = 1 }
///     step = "1 ms"                                   # of a model without a codebook: Runge-Kutta steps
///     averaged_frames = 5                             # of the running mean that the source took
///     round_body = true                               # a disc: turns about its axis change nothing
///     rounds = 2                                      # start states found again after the fit, and so on
///     log_scale = ["C_D"]
///     attitude_scale = "2 deg"                        # of a body with qw, qx, qy, qz
///     noise = "estimated"                             # or { levels = { x = "a", y = "a" }, rounds = 10 }
///     camera = { scale = 0.02, rotation = "1 deg" }   # unknown of each capture: deviations beforehand
///     delay = { range = ["-20 ms", "20 ms"] }         # of each capture's clock; "delay" is a coordinate
///     gain = { theta = { range = [0.95, 1.05] } }     # of a sensor; "gain of theta" is a coordinate
///
///     [fixed]
///     fluid_density = "998.2 kg/m^3"
///
///     [box]                                           # needed for a model, may narrow the box of a codebook
///     C_D = [0.6, 2.0]
///     "v(0)" = ["-0.4 m/s", "0.8 m/s"]
///
///     [initial]                                       # of the first start
///     C_D = 1.1
///
///     [known]                                         # by a label of each capture, SI, or else by the
///     thickness = "thickness_m"                       # first value of a channel; { label, times, power }
///
///     [priors]                                        # logarithmic = true: median and relative deviation
///     C_D = { mean = 1.1, deviation = 0.2 }
///
///     [periods]                                       # of outputs; those in rad have 360 deg
///     theta = "180 deg"
///
/// Tables [series] and [prediction] are for series_config.h and prediction_config.h. Every key may be left
/// out; fit_options.h has the meanings and defaults. To fit a model without a codebook, its family takes
/// what is fixed of it, and `box`, of the options:
///
///     const auto model = models::find_model("vertical_fall");
///     const FitOptions options = read_fit_config("fit.toml", config_names(model->info()));
///     const auto family = reference_trajectories(model, fixed_of_model(options), options.unknowns.box);
namespace samara::identification {

/// What a config may name, with the units that its numbers are checked against.
struct ConfigNames {
  std::map<std::string, std::string> coordinates;  ///< parameters and initial values "s(0)" -> unit
  std::map<std::string, std::string> outputs;      ///< -> unit
};

ConfigNames config_names(const models::ModelInfo& model);
/// Its coordinates, and what its plan fixed.
ConfigNames config_names(const codebooks::Codebook& book);

/// @throws InputError with file and line: unknown keys or names (the nearest is named), wrong kinds, units of
///   another dimension, values outside their meaning.
FitOptions read_fit_config(const std::filesystem::path& path, const ConfigNames& names);
/// The same from a text. @param name stands for the file in messages.
FitOptions parse_fit_config(std::string_view text, const std::string& name, const ConfigNames& names);

}  // namespace samara::identification
