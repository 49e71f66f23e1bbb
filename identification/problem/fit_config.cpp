#include "samara/identification/problem/fit_config.h"

#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/identification/captures/capture_cleaning.h"
#include "samara/identification/problem/measurement.h"
#include "samara/identification/problem/prior_formats.h"
#include "samara/io/toml_document.h"

namespace samara::identification {

namespace {

using io::TomlTable;

constexpr const char* kKind = "a config of a fit";  // of such a file, in messages
using Units = std::map<std::string, std::string>;

std::vector<std::string> names_of(const Units& units) {
  std::vector<std::string> names;
  for (const auto& [name, unit] : units) names.push_back(name);
  return names;
}

/// A list of known names.
std::vector<std::string> known_names(const TomlTable& table, const std::string& key, const Units& known) {
  const std::vector<std::string> names = table.strings(key);
  for (const std::string& name : names) {
    if (!known.contains(name)) {
      throw table.error(key, fmt::format("unknown name \"{}\"{}", name, suggestion(name, names_of(known))));
    }
  }
  return names;
}

/// The same, of names that are added to those that have the role by default: none would say nothing.
std::vector<std::string> added_names(const TomlTable& table, const std::string& key, const Units& known,
                                     const std::string& by_default) {
  std::vector<std::string> names = known_names(table, key, known);
  if (names.empty())
    throw table.error(key,
                      fmt::format("the list is empty; one name or more was expected, since {}", by_default));
  return names;
}

void require_positive_key(const TomlTable& table, const std::string& key, double value) {
  if (!(value > 0.0)) throw table.error(key, fmt::format("is {}; more than 0 was expected", value));
}

int positive_integer(const TomlTable& table, const std::string& key) {
  const std::int64_t value = table.integer(key);
  require_positive_key(table, key, static_cast<double>(value));
  if (value > std::numeric_limits<int>::max()) throw table.error(key, fmt::format("{} is too large", value));
  return static_cast<int>(value);
}

/// What is said of outputs that are not among those compared would have no effect.
/// @param compared empty: what all captures measure, which only they tell
void require_compared(const TomlTable& of_outputs, const std::vector<std::string>& compared) {
  for (const std::string& name : of_outputs.keys()) {
    if (compared.empty() || contains(compared, name)) continue;
    throw of_outputs.error(name, fmt::format("is not among the compared outputs ({})", join(compared)));
  }
}

LossOptions read_loss(const TomlTable& table, const Units& outputs,
                      const std::vector<std::string>& compared) {
  table.expect_keys({"kind", "scale"});
  LossOptions loss;
  try {
    if (table.has("kind")) loss.kind = loss_kind_from_string(table.string("kind"));
  } catch (const ArgumentError& error) {
    throw table.error("kind", error.what());
  }
  if (!table.has("scale")) return loss;
  if (!table.is_table("scale")) {
    loss.length_scale = table.positive_difference("scale", "m");
    return loss;
  }
  const TomlTable scales = table.table("scale");
  scales.expect_keys(names_of(outputs));
  require_compared(scales, compared);
  for (const std::string& name : scales.keys())
    loss.scales[name] = scales.positive_difference(name, outputs.at(name));
  return loss;
}

std::map<std::string, double> read_quantities(const TomlTable& table, const Units& coordinates) {
  table.expect_keys(names_of(coordinates));
  std::map<std::string, double> values;
  for (const std::string& name : table.keys()) values[name] = table.quantity(name, coordinates.at(name));
  return values;
}

models::Interval read_interval(const TomlTable& table, const std::string& key, const std::string& unit) {
  const std::vector<double> ends = table.quantities(key, unit);
  if (ends.size() != 2 || !(ends[0] < ends[1])) {
    throw table.error(key, "an interval, [lower, upper] with lower < upper, was expected");
  }
  return {ends[0], ends[1]};
}

std::map<std::string, models::Interval> read_box(const TomlTable& table, const Units& coordinates) {
  table.expect_keys(names_of(coordinates));
  std::map<std::string, models::Interval> box;
  for (const std::string& name : table.keys()) box[name] = read_interval(table, name, coordinates.at(name));
  return box;
}

/// `segments = "60 ms"`, or a table with stages.
SegmentOptions read_segments(const TomlTable& root) {
  SegmentOptions segments;
  if (!root.is_table("segments")) {
    segments.length = root.positive("segments", "s");
    return segments;
  }
  const TomlTable table = root.table("segments");
  table.expect_keys({"length", "stages"});
  segments.length = table.positive("length", "s");
  if (!table.has("stages")) return segments;
  segments.stages = table.numbers("stages");
  if (segments.stages.empty())
    throw table.error("stages", "the list is empty; one weight or more was expected");
  for (const double stage : segments.stages) require_positive_key(table, "stages", stage);
  return segments;
}

/// `global = "crs"`, or a table with budget and seed.
GlobalOptions read_global(const TomlTable& root) {
  GlobalOptions global;
  const auto method = [&](const TomlTable& table, const std::string& key) {
    try {
      global.method = global_method_from_string(table.string(key));
    } catch (const ArgumentError& error) {
      throw table.error(key, error.what());
    }
  };
  if (!root.is_table("global")) {
    method(root, "global");
    return global;
  }
  const TomlTable table = root.table("global");
  table.expect_keys({"method", "budget", "seed"});
  method(table, "method");
  if (table.has("budget")) global.budget = positive_integer(table, "budget");
  if (table.has("seed")) global.seed = static_cast<std::uint64_t>(positive_integer(table, "seed"));
  return global;
}

/// `key = 100`, or a table with a count of another name and a seed.
struct SeededCount {
  int count = 0;
  std::uint64_t seed = 1;
};
SeededCount read_seeded_count(const TomlTable& root, const char* key, const char* count, int least = 1) {
  const auto read_count = [least](const TomlTable& table, const char* name) {
    const int value = positive_integer(table, name);
    if (value < least) throw table.error(name, fmt::format("is {}; {} or more was expected", value, least));
    return value;
  };
  if (!root.is_table(key)) return {read_count(root, key)};
  const TomlTable table = root.table(key);
  table.expect_keys({count, "seed"});
  SeededCount result{read_count(table, count)};
  if (table.has("seed")) result.seed = static_cast<std::uint64_t>(positive_integer(table, "seed"));
  return result;
}

/// `noise = "estimated"`, or a table with levels and rounds.
NoiseOptions read_noise(const TomlTable& root, const Units& outputs) {
  NoiseOptions noise{.estimated = true};
  if (!root.is_table("noise")) {
    if (root.string("noise") == "estimated") return noise;
    throw root.error("noise", fmt::format("\"{}\" means nothing here; \"estimated\", or a table with levels "
                                          "and rounds, was expected",
                                          root.string("noise")));
  }
  const TomlTable table = root.table("noise");
  table.expect_keys({"levels", "rounds"});
  if (table.has("rounds")) noise.rounds = positive_integer(table, "rounds");
  if (!table.has("levels")) return noise;
  const TomlTable levels = table.table("levels");
  std::vector<std::string> known = names_of(outputs);
  known.push_back("attitude");
  levels.expect_keys(known);
  for (const std::string& name : levels.keys()) noise.levels[name] = levels.string(name);
  return noise;
}

CameraOptions read_camera(const TomlTable& root, const Units& outputs) {
  const TomlTable table = root.table("camera");
  table.expect_keys({"scale", "rotation", "axes", "angles"});
  CameraOptions camera;
  if (!table.has("scale") && !table.has("rotation")) {
    throw root.error("camera", "neither `scale` nor `rotation` is given; one of them, or both, was expected");
  }
  if (table.has("scale")) {
    camera.scale = table.number("scale");
    require_positive_key(table, "scale", *camera.scale);
  }
  if (table.has("rotation")) camera.rotation = table.positive_difference("rotation", "rad");
  if (table.has("axes")) camera.axes = known_names(table, "axes", outputs);
  if (table.has("angles")) camera.angles = known_names(table, "angles", outputs);
  return camera;
}

/// `delay = { range = ["-20 ms", "20 ms"] }`, and `gain = { theta = { range = [0.95, 1.05] } }`.
MeasurementOptions read_measurement(const TomlTable& root, const Units& outputs) {
  MeasurementOptions measurement;
  const auto range = [](const TomlTable& parent, const std::string& key, const std::string& unit) {
    const TomlTable table = parent.table(key);
    table.expect_keys({"range"});
    return read_interval(table, "range", unit);
  };
  if (root.has("delay")) measurement.delay = range(root, "delay", "s");
  if (!root.has("gain")) return measurement;
  const TomlTable gains = root.table("gain");
  gains.expect_keys(names_of(outputs));
  for (const std::string& name : gains.keys()) {
    const models::Interval gain = range(gains, name, "1");
    if (gain.contains(0.0)) {
      throw gains.table(name).error("range",
                                    fmt::format("it goes from {} to {}, and with a gain of 0 nothing is "
                                                "measured; an interval without 0 was expected",
                                                gain.lower, gain.upper));
    }
    measurement.gains[name] = gain;
  }
  return measurement;
}

/// Names with those of delay and gains.
ConfigNames with_measurement(ConfigNames names, const FitOptions& options) {
  for (const models::FamilyCoordinate& unknown : measurement_coordinates(options))
    names.coordinates[unknown.name] = unknown.unit;
  return names;
}

/// `mass = "m"`, or `mass = { label = "radius_m", times = 0.22, power = 2 }`.
std::map<std::string, KnownValue> read_known(const TomlTable& root, const Units& coordinates) {
  root.expect_keys(names_of(coordinates));
  std::map<std::string, KnownValue> known;
  for (const std::string& name : root.keys()) {
    if (!root.is_table(name)) {
      known[name] = root.string(name);
      continue;
    }
    const TomlTable table = root.table(name);
    table.expect_keys({"label", "times", "power"});
    known[name] = {table.string("label"), table.optional_number("times").value_or(1.0),
                   table.optional_number("power").value_or(1.0)};
  }
  return known;
}

std::map<std::string, double> read_periods(const TomlTable& table, const Units& outputs) {
  table.expect_keys(names_of(outputs));
  std::map<std::string, double> periods;
  for (const std::string& name : table.keys()) {
    periods[name] = table.quantity(name, outputs.at(name));
    if (periods[name] < 0.0) {
      throw table.error(name, fmt::format("the period is {}; 0 or more was expected", periods[name]));
    }
  }
  return periods;
}

ComparisonOptions read_comparison(const TomlTable& root, const Units& outputs) {
  ComparisonOptions compared;
  const std::string span = root.renamed("span", "window");
  if (root.has(span)) compared.span = root.positive(span, "s");
  if (root.has("stride")) compared.stride = root.positive("stride", "s");
  if (compared.stride && !compared.span) throw root.error("stride", "belongs to `span`, which is not there");
  if (root.has("outputs")) compared.outputs = known_names(root, "outputs", outputs);
  // Of what is not compared, too: predictions are scored by all that captures measure.
  if (root.has("periods")) compared.periods = read_periods(root.table("periods"), outputs);
  if (root.has("averaged_frames")) compared.averaged_frames = positive_integer(root, "averaged_frames");
  return compared;
}

/// @param of_model names without delay and gains, which have their ranges, no box
UnknownOptions read_unknowns(const TomlTable& root, const ConfigNames& names, const ConfigNames& of_model) {
  UnknownOptions unknowns;
  if (root.has("shared")) {
    unknowns.shared =
        added_names(root, "shared", names.coordinates, "parameters are shared unless per_capture names them");
  }
  if (root.has("per_capture")) {
    unknowns.per_capture = added_names(root, "per_capture", names.coordinates,
                                       "initial values are each capture's own unless shared names them");
  }
  if (root.has("offsets")) unknowns.offsets = known_names(root, "offsets", names.outputs);
  if (root.has("log_scale")) unknowns.log_scale = known_names(root, "log_scale", names.coordinates);
  if (root.has("fixed")) unknowns.fixed = read_quantities(root.table("fixed"), names.coordinates);
  if (root.has("known")) unknowns.known = read_known(root.table("known"), names.coordinates);
  if (root.has("box")) unknowns.box = read_box(root.table("box"), of_model.coordinates);
  for (const auto& [list, chosen] :
       {std::pair{"shared", &unknowns.shared}, std::pair{"per_capture", &unknowns.per_capture}}) {
    for (const std::string& name : *chosen) {
      if (!unknowns.fixed.contains(name)) continue;
      throw root.error(list,
                       fmt::format("\"{}\" is fixed in [fixed] as well; one of the two was expected", name));
    }
  }
  return unknowns;
}

/// @throws InputError if no attitude is among what the source knows, so that the key would have no effect
void require_attitude(const TomlTable& root, const std::string& key, const ConfigNames& names) {
  const bool has_attitude = std::ranges::any_of(kQuaternionChannels, [&](const std::string& part) {
    return names.outputs.contains(part) || names.coordinates.contains(part + "(0)");
  });
  if (!has_attitude)
    throw root.error(
        key, fmt::format("belongs to an attitude ({}), which is not there", join(kQuaternionChannels)));
}

double read_attitude_scale(const TomlTable& root, const ConfigNames& names,
                           const ComparisonOptions& compared) {
  require_attitude(root, "attitude_scale", names);
  const bool is_compared =
      compared.outputs.empty() || std::ranges::any_of(compared.outputs, [](const std::string& name) {
        return contains(kQuaternionChannels, name);
      });
  if (!is_compared) {
    throw root.error("attitude_scale", fmt::format("the attitude is not among the compared outputs ({})",
                                                   join(compared.outputs)));
  }
  return root.positive_difference("attitude_scale", "rad");
}

StartOptions read_starts(const TomlTable& root, const ConfigNames& names) {
  StartOptions starts;
  if (root.has("starts")) starts.count = positive_integer(root, "starts");
  if (root.has("initial")) starts.initial = read_quantities(root.table("initial"), names.coordinates);
  if (root.has("global")) starts.global = read_global(root);
  if (root.has("rounds")) starts.rounds = positive_integer(root, "rounds");
  // The spans of a series are segments.
  const bool has_segments = root.has("segments") || root.has("series");
  if (starts.rounds > 1 && !has_segments)
    throw root.error("rounds", "belongs to `segments`, which is not there");
  starts.round_body = root.optional_boolean("round_body").value_or(false);
  if (starts.round_body) require_attitude(root, "round_body", names);
  return starts;
}

UncertaintyOptions read_uncertainty(const TomlTable& root) {
  UncertaintyOptions uncertainty;
  uncertainty.cluster_by = root.optional_strings("cluster_by").value_or(std::vector<std::string>{});
  uncertainty.profiles = root.optional_boolean("profiles").value_or(false);
  if (root.has("bootstrap")) {
    const SeededCount asked = read_seeded_count(root, "bootstrap", "replicates", 2);  // one has no scatter
    uncertainty.bootstrap = {asked.count, asked.seed};
  }
  if (root.has("posterior")) {
    const SeededCount asked = read_seeded_count(root, "posterior", "samples");
    uncertainty.posterior = {asked.count, asked.seed};
  }
  return uncertainty;
}

FitOptions read_options(const TomlTable& root, const ConfigNames& of_model) {
  root.expect_keys(
      {"span",       "window",     "outputs",         "loss",      "shared",         "per_capture", "offsets",
       "cluster_by", "starts",     "max_iterations",  "profiles",  "segments",       "global",      "step",
       "rounds",     "round_body", "averaged_frames", "log_scale", "attitude_scale", "fixed",       "initial",
       "known",      "priors",     "periods",         "box",       "bootstrap",      "noise",       "camera",
       "stride",     "posterior",  "delay",           "gain",      "codebook",
       "series",        // series_config.h
       "prediction"});  // prediction_config.h
  FitOptions options;
  options.measurement = read_measurement(root, of_model.outputs);
  const ConfigNames names = with_measurement(of_model, options);
  options.compared = read_comparison(root, names.outputs);
  if (root.has("loss")) options.loss = read_loss(root.table("loss"), names.outputs, options.compared.outputs);
  if (root.has("attitude_scale"))
    options.loss.attitude_scale = read_attitude_scale(root, names, options.compared);
  if (root.has("noise")) options.noise = read_noise(root, names.outputs);
  options.unknowns = read_unknowns(root, names, of_model);
  if (root.has("priors")) {
    const TomlTable priors = root.table("priors");
    priors.expect_keys(names_of(names.coordinates));
    for (const std::string& name : priors.keys())
      options.priors.coordinates[name] = read_prior(priors.table(name), names.coordinates.at(name));
  }
  if (root.has("camera")) options.camera = read_camera(root, names.outputs);
  if (root.has("segments")) options.segments = read_segments(root);
  options.starts = read_starts(root, names);
  if (root.has("step")) options.solver.step = root.positive("step", "s");
  if (root.has("codebook"))
    options.solver.codebook =
        (std::filesystem::path(root.file()).parent_path() / root.string("codebook")).string();
  if (root.has("max_iterations")) options.solver.max_iterations = positive_integer(root, "max_iterations");
  options.uncertainty = read_uncertainty(root);
  return options;
}

}  // namespace

ConfigNames config_names(const models::ModelInfo& model) {
  ConfigNames names;
  for (const models::ParameterInfo& parameter : model.parameters)
    names.coordinates[parameter.name] = parameter.unit;
  for (const models::StateInfo& state : model.states) {
    names.coordinates[fmt::format("{}(0)", state.name)] = state.unit;
    names.outputs[state.name] = state.unit;
  }
  for (const models::OutputInfo& output : model.outputs) names.outputs[output.name] = output.unit;
  return names;
}

ConfigNames config_names(const codebooks::Codebook& book) {
  ConfigNames names;
  names.coordinates = book.model().fixed_units;
  for (const codebooks::Coordinate& c : book.coordinates()) {
    if (c.role != pgd::AxisRole::time) names.coordinates[c.name] = c.unit;
  }
  for (const pgd::OutputLabel& output : book.outputs()) names.outputs[output.name] = output.unit;
  for (const pgd::OutputLabel& output : codebooks::derived_outputs(book))
    names.outputs[output.name] = output.unit;
  return names;
}

FitOptions read_fit_config(const std::filesystem::path& path, const ConfigNames& names) {
  return read_options(TomlTable::read(path, kKind), names);
}

FitOptions parse_fit_config(std::string_view text, const std::string& name, const ConfigNames& names) {
  return read_options(TomlTable::parse(text, name, kKind), names);
}

}  // namespace samara::identification
