#include "samara/motion/sweeps/sweep_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/book/sobol_points.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/motion/sweeps/pattern_map.h"

namespace samara::motion {

namespace {

using io::TomlTable;

constexpr const char* kKind = "a plan of a sweep";  // of such a file, in messages

const std::vector<std::string> kAttitude = {"qw(0)", "qx(0)", "qy(0)", "qz(0)"};
constexpr const char* kAngle = "theta(0)";

std::map<std::string, std::string> settable(const models::ModelInfo& info) {
  std::map<std::string, std::string> units;
  for (const auto& parameter : info.parameters) units[parameter.name] = parameter.unit;
  for (const auto& state : info.states) units[state.name + "(0)"] = state.unit;
  return units;
}

/// @throws InputError at the key, naming the nearest
const std::string& unit_of(const TomlTable& table, const std::string& key,
                           const std::map<std::string, std::string>& units) {
  const auto it = units.find(key);
  if (it != units.end()) return it->second;
  std::vector<std::string> known;
  for (const auto& [name, unit] : units) known.push_back(name);
  throw table.error(
      key, fmt::format("the model has no parameter or initial value of this name{}", suggestion(key, known)));
}

std::shared_ptr<const models::Model> read_model(const TomlTable& root) {
  try {
    const auto model =
        codebooks::open_model(root.string("model"), std::filesystem::path(root.file()).parent_path());
    MotionStates states(model->info());  // refuses models without a body
    return model;
  } catch (const ArgumentError& error) {
    throw root.error("model", error.what());
  }
}

/// { from = .., to = .., count = .. } or a list of values.
SweepAxis read_axis(const TomlTable& axes, const std::string& key, const std::string& unit, bool sampled) {
  SweepAxis axis;
  axis.name = key;
  axis.unit = unit;
  if (!axes.is_table(key)) {
    const std::vector<double> values = axes.quantities(key, unit);
    if (sampled) throw axes.error(key, "is a list of values, expected from and to beside [sample]");
    if (values.empty()) throw axes.error(key, "has no values, expected at least one");
    for (const double value : values) {
      if (!axis.values.empty() && !(value > axis.values.back()))
        throw axes.error(key, fmt::format("has the value {} after {}, expected them to increase", value,
                                          axis.values.back()));
      axis.values.push_back(value);
    }
    axis.lower = axis.values.front();
    axis.upper = axis.values.back();
    return axis;
  }
  const TomlTable table = axes.table(key);
  table.expect_keys({"from", "to", "count"});
  axis.lower = table.quantity("from", unit);
  axis.upper = table.quantity("to", unit);
  if (!(axis.lower < axis.upper))
    throw axes.error(key, fmt::format("goes from {} to {}, expected from < to", axis.lower, axis.upper));
  if (sampled) {
    if (table.has("count")) throw table.error("count", "is of a grid, expected none beside [sample]");
    return axis;
  }
  const std::int64_t count = table.integer("count");
  if (count < 2 || count > kMostFalls)
    throw table.error("count", fmt::format("is {}, expected 2 to {}", count, kMostFalls));
  for (std::int64_t k = 0; k < count; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(count - 1);
    axis.values.push_back(k + 1 == count ? axis.upper : axis.lower + share * (axis.upper - axis.lower));
  }
  return axis;
}

void read_axes(const TomlTable& root, const std::map<std::string, std::string>& units, SweepPlan& plan) {
  if (const auto sample = root.optional_table("sample")) {
    sample->expect_keys({"count", "seed"});
    const std::int64_t count = sample->integer("count");
    if (count < 1 || count > kMostFalls)
      throw sample->error("count", fmt::format("is {}, expected 1 to {}", count, kMostFalls));
    plan.sample = static_cast<int>(count);
    const std::int64_t seed = sample->optional_integer("seed").value_or(1);
    if (seed < 0) throw sample->error("seed", fmt::format("is {}, expected 0 or more", seed));
    plan.seed = static_cast<std::uint64_t>(seed);
  }
  const TomlTable axes = root.table("axes");
  for (const std::string& key : axes.keys()) {
    const std::string& unit = unit_of(axes, key, units);
    if (plan.fixed.contains(key))
      throw axes.error(key, "is fixed in [fixed] and free in [axes], expected one of them");
    plan.axes.push_back(read_axis(axes, key, unit, plan.sample > 0));
  }
  if (plan.axes.empty()) throw root.error("axes", "is empty, expected at least one coordinate");
}

void read_releases(const TomlTable& root, SweepPlan& plan) {
  const auto table = root.optional_table("releases");
  if (!table) return;
  const bool planar = MotionStates(plan.model->info()).is_planar();
  table->expect_keys(planar ? std::vector<std::string>{"tilt"} : std::vector<std::string>{"tilt", "axis"});
  std::vector<std::string> moved = planar ? std::vector<std::string>{kAngle} : kAttitude;
  for (const std::string& name : moved) {
    const bool is_axis = std::ranges::find(plan.axes, name, &SweepAxis::name) != plan.axes.end();
    if (is_axis || plan.fixed.contains(name))
      throw table->error("tilt", fmt::format("stands beside {}, expected one of the two", name));
  }
  const std::vector<double> axes = table->optional_quantities("axis", "1").value_or(std::vector<double>{0.0});
  const std::vector<double> tilts = table->quantities("tilt", "1");
  if (tilts.empty() || axes.empty())
    throw table->error("tilt", "or axis has no values, expected at least one");
  for (const double axis : axes) {
    for (const double tilt : tilts) plan.releases.push_back({tilt, axis});
  }
}

void read_run(const TomlTable& root, SweepPlan& plan) {
  const TomlTable run = root.table("run");
  run.expect_keys({"until", "step", "interval", "settle", "height", "keep", "spread"});
  const models::ModelInfo& info = plan.model->info();
  const std::string time = models::time_unit(info);
  plan.until = run.positive("until", time);
  plan.step = run.positive("step", time);
  plan.interval = run.optional_positive("interval", time).value_or(4.0 * plan.step);
  plan.settle = run.optional_quantity("settle", time).value_or(0.5 * plan.until);
  const double frames = std::floor((plan.until - plan.settle) / plan.interval * (1.0 + 1e-12));
  if (!(plan.settle >= 0.0) || frames < 2.0 * static_cast<double>(kFewestFrames)) {
    const std::string key = run.has("settle") ? "settle" : run.has("interval") ? "interval" : "step";
    const double value = run.has("settle") ? plan.settle : run.has("interval") ? plan.interval : plan.step;
    throw run.error(key,
                    fmt::format("is {}, which leaves {} frames from {} until {}, expected at least {}", value,
                                std::max(0.0, frames), plan.settle, plan.until, 2 * kFewestFrames));
  }
  constexpr double kMostSteps = 1e9;
  if (plan.until / std::min(plan.step, plan.interval) > kMostSteps)
    throw run.error(
        "step", fmt::format("is {}, which takes more than {} steps, expected fewer", plan.step, kMostSteps));
  constexpr double kMostFrames = 1e6;
  if (plan.until / plan.interval > kMostFrames) {
    throw run.error(run.has("interval") ? "interval" : "step",
                    fmt::format("makes {:.3g} frames of a fall, expected at most {:.3g}: a longer interval",
                                plan.until / plan.interval, kMostFrames));
  }
  const std::string length = MotionStates(info).is_planar() && time == "1" ? "1" : "m";
  if (run.has("height")) plan.height = run.positive("height", length);
  plan.keep_trajectories = run.choice("keep", {"features", "trajectories"}) == "trajectories";
  plan.spread = run.optional_boolean("spread").value_or(false);
}

void read_rest(const TomlTable& root, SweepPlan& plan) {
  if (const auto labels = root.optional_table("labels")) {
    for (const std::string& key : labels->keys()) {
      try {
        set_threshold(plan.thresholds, key, labels->number(key));
      } catch (const ArgumentError& error) {
        throw labels->error(key, error.what());
      }
    }
  }
  if (const auto refine = root.optional_table("refine")) {
    refine->expect_keys({"rounds", "gain"});
    const std::int64_t rounds = refine->integer("rounds");
    if (rounds < 0 || rounds > 10)
      throw refine->error("rounds", fmt::format("is {}, expected 0 to 10", rounds));
    plan.refine = static_cast<int>(rounds);
    if (refine->has("gain")) {
      plan.refine_gain = refine->number("gain");
      if (!(*plan.refine_gain > 0.0 && *plan.refine_gain < 1.0))
        throw refine->error("gain",
                            fmt::format("is {}, expected more than 0 and below 1", *plan.refine_gain));
    }
  }
}

void check_falls(const TomlTable& root, const SweepPlan& plan) {
  double falls = static_cast<double>(plan.release_count());
  if (plan.is_grid()) {
    // Each round halves the intervals.
    for (const SweepAxis& axis : plan.axes)
      falls *= std::ldexp(static_cast<double>(axis.values.size()) - 1.0, plan.refine) + 1.0;
  } else {
    falls *= plan.sample * std::pow(1.2, plan.refine);
  }
  if (falls > kMostFalls) {
    throw root.error("axes", fmt::format("take {:.8g} falls{}, expected at most {}", falls,
                                         plan.refine > 0 ? " when they are refined" : "", kMostFalls));
  }
  if (plan.is_grid() && plan.refine > 0) {
    Eigen::Index points = 1;
    for (const SweepAxis& axis : plan.axes) points *= static_cast<Eigen::Index>(axis.values.size());
    if (points <= PatternMap::kNeighbours)
      throw root.table("refine").error(
          "rounds", fmt::format("is {} of a grid of {} points, expected at least {} to be refined",
                                plan.refine, points, PatternMap::kNeighbours + 1));
  }
  if (!plan.is_grid() && plan.refine > 0 && plan.sample <= PatternMap::kNeighbours) {
    throw root.table("sample").error("count", fmt::format("is {}, expected at least {} to be refined",
                                                          plan.sample, PatternMap::kNeighbours + 1));
  }
  const double frames = plan.until / plan.interval + 1.0;
  const double numbers = falls * frames * static_cast<double>(plan.model->info().states.size());
  constexpr double kMostNumbers = 2.5e8;
  if (plan.keep_trajectories && numbers > kMostNumbers)
    throw root.table("run").error(
        "keep", fmt::format("takes {:.2g} numbers, expected at most {:.2g}: a longer interval, "
                            "or features",
                            numbers, kMostNumbers));
}

/// The ends of the box, and its middle.
void check_points(const TomlTable& root, const SweepPlan& plan) {
  try {
    const models::ParametricModel model = plan.parametric_model();
    Eigen::MatrixXd points(3, static_cast<Eigen::Index>(plan.axes.size()));
    for (Eigen::Index k = 0; k < points.cols(); ++k) {
      const SweepAxis& axis = plan.axes[static_cast<std::size_t>(k)];
      points.col(k) << axis.lower, 0.5 * (axis.lower + axis.upper), axis.upper;
    }
    const Eigen::MatrixXd lanes = plan.lane_points(points);
    for (Eigen::Index n = 0; n < lanes.rows(); ++n) {
      const Eigen::VectorXd q = lanes.row(n);
      model.check({q.data(), static_cast<std::size_t>(q.size())});
    }
  } catch (const ArgumentError& error) {
    throw InputError(plan.source, root.line("axes"), error.what());
  }
}

SweepPlan plan_of(const TomlTable& root, const std::string& text) {
  root.expect_keys({"model", "fixed", "axes", "sample", "releases", "run", "labels", "refine"});
  SweepPlan plan;
  plan.source = root.file();
  plan.text = text;
  plan.model = read_model(root);
  const auto units = settable(plan.model->info());
  if (const auto fixed = root.optional_table("fixed")) {
    for (const std::string& key : fixed->keys())
      plan.fixed[key] = fixed->quantity(key, unit_of(*fixed, key, units));
  }
  read_axes(root, units, plan);
  read_releases(root, plan);
  read_run(root, plan);
  read_rest(root, plan);
  check_falls(root, plan);
  check_points(root, plan);
  return plan;
}

}  // namespace

Eigen::MatrixXd SweepPlan::points() const {
  const auto count = static_cast<Eigen::Index>(axes.size());
  if (!is_grid()) {
    Eigen::MatrixXd all = codebooks::sobol_points(static_cast<int>(count), sample, seed).transpose();
    for (Eigen::Index k = 0; k < count; ++k) {
      const SweepAxis& axis = axes[static_cast<std::size_t>(k)];
      all.col(k) = axis.lower + (axis.upper - axis.lower) * all.col(k).array();
    }
    return all;
  }
  Eigen::Index total = 1;
  for (const SweepAxis& axis : axes) total *= static_cast<Eigen::Index>(axis.values.size());
  Eigen::MatrixXd all(total, count);
  for (Eigen::Index n = 0; n < total; ++n) {
    Eigen::Index rest = n;
    for (Eigen::Index k = count - 1; k >= 0; --k) {
      const std::vector<double>& values = axes[static_cast<std::size_t>(k)].values;
      const auto size = static_cast<Eigen::Index>(values.size());
      all(n, k) = values[static_cast<std::size_t>(rest % size)];
      rest /= size;
    }
  }
  return all;
}

models::ParametricModel SweepPlan::parametric_model() const {
  std::vector<std::string> free;
  for (const SweepAxis& axis : axes) free.push_back(axis.name);
  if (!releases.empty()) {
    if (MotionStates(model->info()).is_planar()) {
      free.emplace_back(kAngle);
    } else {
      free.insert(free.end(), kAttitude.begin(), kAttitude.end());
    }
  }
  return {model, fixed, free};
}

Eigen::MatrixXd SweepPlan::lane_points(const Eigen::MatrixXd& points) const {
  if (releases.empty()) return points;
  const bool planar = MotionStates(model->info()).is_planar();
  const auto count = static_cast<Eigen::Index>(releases.size());
  Eigen::MatrixXd lanes(points.rows() * count, points.cols() + (planar ? 1 : 4));
  // A quarter turn has no exact cosine, which would push a planar motion out of its plane.
  const auto exact = [](double value) { return std::abs(value) < 1e-15 ? 0.0 : value; };
  for (Eigen::Index n = 0; n < lanes.rows(); ++n) {
    const Release& release = releases[static_cast<std::size_t>(n % count)];
    lanes.row(n).head(points.cols()) = points.row(n / count);
    const double sine = std::sin(0.5 * release.tilt);
    if (planar) {
      lanes(n, points.cols()) = release.tilt;
    } else {
      lanes.row(n).tail<4>() << std::cos(0.5 * release.tilt), sine * exact(std::cos(release.axis)),
          sine * exact(std::sin(release.axis)), 0.0;
    }
  }
  return lanes;
}

SweepPlan read_sweep_plan(const std::filesystem::path& path) {
  const std::string text = io::read_text_file(path, {.expected = kKind});
  return parse_sweep_plan(text, path.string());
}

SweepPlan parse_sweep_plan(const std::string& text, const std::string& name) {
  return plan_of(TomlTable::parse(text, name, kKind), text);
}

}  // namespace samara::motion
