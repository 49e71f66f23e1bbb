#include "samara/motion/sweeps/sweep_file.h"

#include <cmath>
#include <system_error>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "samara/base/errors.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

namespace samara::motion {

namespace {

constexpr const char* kFormat = "samara-sweep";
constexpr const char* kVersion = "0.1";
constexpr const char* kCheckpointMark = "samara-sweep-checkpoint";

std::string thresholds_text(const PatternThresholds& thresholds) {
  nlohmann::ordered_json object;
  for (const NamedThreshold& one : named_thresholds()) object[one.name] = thresholds.*one.value;
  return object.dump();
}

PatternThresholds thresholds_of(const io::Hdf5Reader& file) {
  PatternThresholds thresholds;
  const auto object = nlohmann::json::parse(file.text_attribute("/", "thresholds"), nullptr, false);
  if (!object.is_object()) throw file.error("/", "the attribute thresholds is no JSON object");
  for (const auto& [name, value] : object.items()) {
    try {
      set_threshold(thresholds, name, value.is_number() ? value.get<double>() : 0.0);
    } catch (const ArgumentError& error) {
      throw file.error("/", fmt::format("the attribute thresholds: {}", error.what()));
    }
  }
  return thresholds;
}

template <class Enum>
Eigen::VectorXd numbers(const std::vector<Enum>& values) {
  Eigen::VectorXd all(static_cast<Eigen::Index>(values.size()));
  for (std::size_t k = 0; k < values.size(); ++k)
    all[static_cast<Eigen::Index>(k)] = static_cast<double>(values[k]);
  return all;
}

/// Whole numbers below `count`.
std::vector<int> codes(const io::Hdf5Reader& file, const std::string& path, Eigen::Index rows, int count) {
  std::vector<int> all;
  for (const double value : file.vector(path, {.rows = rows})) {
    if (!(value >= 0.0 && value < count) || value != std::floor(value))
      throw file.error(path,
                       fmt::format("has the number {}, expected a whole one from 0 to {}", value, count - 1));
    all.push_back(static_cast<int>(value));
  }
  return all;
}

void write_falls(io::Hdf5Writer& file, const Sweep& sweep) {
  const Eigen::Index falls = sweep.fall_count();
  Eigen::MatrixXd features(falls, static_cast<Eigen::Index>(kFeatures));
  Eigen::VectorXd margins(falls);
  std::vector<Pattern> patterns;
  std::vector<Seen> seen;
  for (Eigen::Index n = 0; n < falls; ++n) {
    const auto k = static_cast<std::size_t>(n);
    for (std::size_t f = 0; f < kFeatures; ++f)
      features(n, static_cast<Eigen::Index>(f)) = sweep.features[k].values[f];
    margins[n] = sweep.labels[k].margin;
    patterns.push_back(sweep.labels[k].pattern);
    seen.push_back(sweep.features[k].seen);
  }
  std::vector<std::string> names, units;
  for (const FeatureInfo& info : feature_infos()) {
    names.push_back(info.name);
    units.push_back(info.unit);
  }
  file.write_matrix("/features", features);
  file.write_texts("/feature_names", names);
  file.write_texts("/feature_units", units);
  file.write_vector("/labels", numbers(patterns));
  file.write_texts("/label_names", pattern_names());
  file.write_vector("/margins", margins);
  file.write_vector("/seen", numbers(seen));
  file.write_vector("/status", numbers(sweep.status));
  std::vector<std::string> status_names;
  for (int k = 0; k <= static_cast<int>(FallStatus::inherited); ++k)
    status_names.push_back(to_string(static_cast<FallStatus>(k)));
  file.write_texts("/status_names", status_names);
  file.write_vector("/reached", sweep.reached);
  file.write_matrix("/landing", sweep.landing);
}

void write_rounds(io::Hdf5Writer& file, const Sweep& sweep) {
  if (!sweep.round_of_point.empty()) file.write_vector("/rounds/of_point", numbers(sweep.round_of_point));
  if (sweep.rounds.empty()) return;
  Eigen::MatrixXd table(static_cast<Eigen::Index>(sweep.rounds.size()), 3);
  for (Eigen::Index k = 0; k < table.rows(); ++k) {
    const RefiningRound& round = sweep.rounds[static_cast<std::size_t>(k)];
    table.row(k) << static_cast<double>(round.points), static_cast<double>(round.run), round.agreement;
  }
  file.write_matrix("/rounds/done", table);
  file.write_texts("/rounds/done_names", {"points", "run", "agreement"});
}

/// Older files have none.
void read_rounds(const io::Hdf5Reader& file, Sweep& sweep) {
  if (!file.has("/rounds/of_point")) return;
  constexpr int kMostRounds = 1'000'000;
  sweep.round_of_point = codes(file, "/rounds/of_point", sweep.points.rows(), kMostRounds);
  if (!file.has("/rounds/done")) return;
  const Eigen::MatrixXd table = file.matrix("/rounds/done", {.columns = 3});
  for (const auto& row : table.rowwise()) {
    if (!(row[0] >= 0.0 && row[0] <= static_cast<double>(sweep.points.rows()) && row[1] >= 0.0 &&
          row[1] <= row[0]))
      throw file.error("/rounds/done",
                       fmt::format("has a round of {} points, {} of them run", row[0], row[1]));
    sweep.rounds.push_back({static_cast<Eigen::Index>(row[0]), static_cast<Eigen::Index>(row[1]), row[2]});
  }
}

void write_trajectories(io::Hdf5Writer& file, const Sweep& sweep) {
  if (sweep.trajectories.empty()) return;
  const Eigen::Index frames = sweep.trajectories.front().rows(), states = sweep.trajectories.front().cols();
  std::vector<double> all;
  all.reserve(sweep.trajectories.size() * static_cast<std::size_t>(frames * states));
  for (const Eigen::MatrixXd& one : sweep.trajectories) {
    for (Eigen::Index k = 0; k < frames; ++k) {
      for (Eigen::Index s = 0; s < states; ++s) all.push_back(one(k, s));
    }
  }
  file.write_block("/trajectories/states",
                   {static_cast<Eigen::Index>(sweep.trajectories.size()), frames, states}, all);
  file.write_vector("/trajectories/times", sweep.times);
  file.write_texts("/trajectories/state_names", sweep.state_names);
}

/// Features of this program by their names; files of others may have more, or fewer.
std::vector<Features> read_features(const io::Hdf5Reader& file, Eigen::Index falls) {
  const std::vector<std::string> names = file.texts("/feature_names");
  const Eigen::MatrixXd values = file.matrix(
      "/features", {.rows = falls, .columns = static_cast<Eigen::Index>(names.size()), .finite = false});
  const std::vector<int> seen = codes(file, "/seen", falls, 3);
  std::vector<Features> all(static_cast<std::size_t>(falls));
  for (std::size_t f = 0; f < kFeatures; ++f) {
    for (std::size_t column = 0; column < names.size(); ++column) {
      if (names[column] != feature_infos()[f].name) continue;
      for (std::size_t n = 0; n < all.size(); ++n)
        all[n].values[f] = values(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(column));
    }
  }
  for (std::size_t n = 0; n < all.size(); ++n) all[n].seen = static_cast<Seen>(seen[n]);
  return all;
}

void read_labels(const io::Hdf5Reader& file, Eigen::Index falls, Sweep& sweep) {
  if (file.texts("/label_names") != pattern_names())
    throw file.error("/label_names", "are not the patterns of this program");
  const std::vector<int> patterns = codes(file, "/labels", falls, static_cast<int>(kPatterns));
  const Eigen::VectorXd margins = file.vector("/margins", {.rows = falls, .finite = false});
  for (Eigen::Index n = 0; n < falls; ++n) {
    const auto k = static_cast<std::size_t>(n);
    PatternLabel label = motion::label(sweep.features[k], sweep.thresholds);
    if (static_cast<int>(label.pattern) != patterns[k]) label.why = "as the file says";
    label.pattern = static_cast<Pattern>(patterns[k]);
    label.margin = margins[n];
    sweep.labels.push_back(std::move(label));
  }
}

void read_trajectories(const io::Hdf5Reader& file, Eigen::Index falls, Sweep& sweep) {
  if (!file.has("/trajectories/states")) return;
  const io::Hdf5Block block = file.block("/trajectories/states", {.rows = falls, .finite = false});
  sweep.times = file.vector("/trajectories/times", {.rows = block.size[1]});
  sweep.state_names = file.texts("/trajectories/state_names");
  if (static_cast<Eigen::Index>(sweep.state_names.size()) != block.size[2])
    throw file.error("/trajectories/state_names", "are not as many as the states");
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const auto size = static_cast<std::size_t>(block.size[1] * block.size[2]);
  for (std::size_t n = 0; n < static_cast<std::size_t>(falls); ++n)
    sweep.trajectories.emplace_back(
        Eigen::Map<const Rows>(block.values.data() + n * size, block.size[1], block.size[2]));
}

void check_format(const io::Hdf5Reader& file) {
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kFormat)
    throw file.error("/", "the attribute format is not \"samara-sweep\": this is no sweep");
  const std::string version = file.text_attribute("/", "format_version");
  if (version.rfind("0.", 0) != 0)
    throw file.error("/",
                     fmt::format("is a sweep of format {}, expected 0.x: a newer program wrote it", version));
}

/// @param is_checkpoint otherwise a result
void write(const Sweep& sweep, const std::filesystem::path& path, bool is_checkpoint) {
  io::Hdf5Writer file(path);
  file.write_text_attribute("/", "format", kFormat);
  file.write_text_attribute("/", "format_version", kVersion);
  if (is_checkpoint) file.write_text_attribute("/", "checkpoint", kCheckpointMark);
  file.write_text_attribute("/", "generator", sweep.generator);
  file.write_text_attribute("/", "model", sweep.model);
  file.write_text_attribute("/", "thresholds", thresholds_text(sweep.thresholds));
  file.write_texts("/plan", {sweep.plan_text});
  file.write_texts("/model_text", {sweep.model_text});
  file.write_matrix("/points", sweep.points);
  file.write_texts("/point_names", sweep.names);
  file.write_texts("/point_units", sweep.units);
  file.write_vector("/lower", sweep.lower);
  file.write_vector("/upper", sweep.upper);
  for (std::size_t k = 0; k < sweep.axes.size(); ++k)
    file.write_vector("/axes/" + sweep.names[k],
                      Eigen::Map<const Eigen::VectorXd>(sweep.axes[k].data(),
                                                        static_cast<Eigen::Index>(sweep.axes[k].size())));
  Eigen::MatrixXd releases(static_cast<Eigen::Index>(sweep.releases.size()), 2);
  for (std::size_t k = 0; k < sweep.releases.size(); ++k)
    releases.row(static_cast<Eigen::Index>(k)) << sweep.releases[k].tilt, sweep.releases[k].axis;
  file.write_matrix("/releases", releases);
  write_falls(file, sweep);
  write_rounds(file, sweep);
  write_trajectories(file, sweep);
  file.commit();
}

}  // namespace

void save(const Sweep& sweep, const std::filesystem::path& path) {
  write(sweep, path, false);
}

void save_checkpoint(const Sweep& sweep, const std::filesystem::path& path) {
  write(sweep, path, true);
}

bool is_sweep_checkpoint(const std::filesystem::path& file) {
  return io::is_hdf5_with(file, kCheckpointMark);
}

Sweep load_sweep(const std::filesystem::path& path) {
  const io::Hdf5Reader file(path);
  check_format(file);
  Sweep sweep;
  sweep.model = file.text_attribute("/", "model");
  sweep.thresholds = thresholds_of(file);
  const std::vector<std::string> plan = file.texts("/plan");
  if (plan.size() != 1) throw file.error("/plan", "is not one text");
  sweep.plan_text = plan.front();
  sweep.generator = file.text_attribute("/", "generator");
  // Older files do not say it.
  if (file.has("/model_text")) {
    const std::vector<std::string> model = file.texts("/model_text");
    if (model.size() != 1) throw file.error("/model_text", "is not one text");
    sweep.model_text = model.front();
  }
  sweep.names = file.texts("/point_names");
  sweep.units = file.texts("/point_units");
  const auto count = static_cast<Eigen::Index>(sweep.names.size());
  if (count == 0 || sweep.units.size() != sweep.names.size())
    throw file.error("/point_units", "are not as many as /point_names");
  sweep.points = file.matrix("/points", {.columns = count});
  sweep.lower = file.vector("/lower", {.rows = count});
  sweep.upper = file.vector("/upper", {.rows = count});
  if (file.has("/axes")) {
    for (const std::string& name : sweep.names) {
      const Eigen::VectorXd values = file.vector("/axes/" + name);
      sweep.axes.emplace_back(values.begin(), values.end());
    }
  }
  const Eigen::MatrixXd releases = file.matrix("/releases", {.columns = 2});
  for (const auto& row : releases.rowwise()) sweep.releases.push_back({row[0], row[1]});
  const std::vector<Eigen::Index> labels = file.shape("/labels");
  if (labels.size() != 1)
    throw file.error("/labels", fmt::format("has {} dimensions, expected 1", labels.size()));
  const Eigen::Index falls = labels.front();
  // A checkpoint has only begun.
  if (falls > sweep.points.rows() * sweep.release_count())
    throw file.error("/labels", "are more than points and releases");
  sweep.features = read_features(file, falls);
  read_labels(file, falls, sweep);
  for (const int code : codes(file, "/status", falls, static_cast<int>(FallStatus::inherited) + 1))
    sweep.status.push_back(static_cast<FallStatus>(code));
  sweep.reached = file.vector("/reached", {.rows = falls});
  sweep.landing = file.matrix("/landing", {.rows = falls, .columns = 3, .finite = false});
  read_trajectories(file, falls, sweep);
  read_rounds(file, sweep);
  return sweep;
}

bool is_sweep(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return false;
  try {
    const io::Hdf5Reader file(path);
    return file.has_attribute("/", "format") && file.text_attribute("/", "format") == kFormat;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace samara::motion
