#include "samara/motion/planning/motion_plan.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/model/model_file.h"
#include "samara/identification/series/series_codebook.h"
#include "samara/io/text_file.h"
#include "samara/io/toml_document.h"
#include "samara/motion/database/database_file.h"
#include "samara/motion/planning/book_tangents.h"
#include "samara/motion/planning/plan_checks.h"
#include "samara/motion/planning/segment_choices.h"

namespace samara::motion {

namespace {

using io::TomlTable;

constexpr const char* kKind = "a motion to plan";  // of such a file, in messages

class PlanReader {
 public:
  PlanReader(const TomlTable& root, const std::string& text) : root_(root) {
    plan_.source = root.file();
    plan_.text = text;
  }

  MotionPlan read() {
    root_.expect_keys({"model", "database", "codebook", "body", "release", "path", "landing", "sequence",
                       "duration", "box", "turbulence", "search"});
    read_model();
    read_body();
    read_release();
    read_box();
    read_path();
    read_landing();
    read_database();
    read_rest();
    read_codebook();
    if (!plan_.sketch && !plan_.landing && !plan_.sequence) {
      throw root_.error("path",
                        "is missing, and [landing] and [sequence] too: expected one of them, to say "
                        "what the body is to do");
    }
    return plan_;
  }

 private:
  std::filesystem::path folder() const { return std::filesystem::path(root_.file()).parent_path(); }
  /// A file that the plan names.
  std::filesystem::path named(const std::string& file) {
    plan_.files.push_back((folder() / file).string());
    return plan_.files.back();
  }

  void read_model() {
    try {
      const std::string model = root_.string("model");
      plan_.model = codebooks::open_model(model, folder());
      if (codebooks::is_model_file(model)) named(model);
      planar_ = MotionStates(plan_.model->info()).is_planar();
    } catch (const ArgumentError& error) {
      throw root_.error("model", error.what());
    }
    const models::ModelInfo& info = plan_.model->info();
    for (const auto& parameter : info.parameters) units_[parameter.name] = parameter.unit;
    for (const auto& state : info.states) units_[state.name + "(0)"] = state.unit;
    time_ = models::time_unit(info);
    length_ = units_.at("x(0)");
  }

  const std::string& unit_of(const TomlTable& table, const std::string& key) const {
    const auto it = units_.find(key);
    if (it != units_.end()) return it->second;
    std::vector<std::string> known;
    for (const auto& [name, unit] : units_) known.push_back(name);
    throw table.error(key, fmt::format("the model has no parameter or initial value of this name{}",
                                       suggestion(key, known)));
  }

  void read_body() {
    const auto body = root_.optional_table("body");
    if (!body) return;
    for (const std::string& key : body->keys()) plan_.fixed[key] = body->quantity(key, unit_of(*body, key));
  }

  void set_initial(const TomlTable& table, const std::string& key, const std::string& name, double value) {
    if (!plan_.fixed.emplace(name, value).second)
      throw table.error(key, fmt::format("stands beside {} in [body], expected one of the two", name));
  }

  void read_release() {
    const TomlTable release = root_.table("release");
    release.expect_keys(planar_ ? std::vector<std::string>{"height", "tilt"}
                                : std::vector<std::string>{"height", "tilt", "axis"});
    const double height = release.positive("height", length_);
    set_initial(release, "height", planar_ ? "y(0)" : "z(0)", height);
    const auto tilt = release.optional_quantity("tilt", "1");
    if (!tilt && release.has("axis"))
      throw release.error("axis", "is that of a tilt, which is missing: expected both, or none");
    const double axis = release.optional_quantity("axis", "1").value_or(0.0);
    if (!tilt) return;
    if (planar_) return set_initial(release, "tilt", "theta(0)", *tilt);
    const double sine = std::sin(0.5 * *tilt);
    set_initial(release, "tilt", "qw(0)", std::cos(0.5 * *tilt));
    set_initial(release, "tilt", "qx(0)", sine * std::cos(axis));
    set_initial(release, "tilt", "qy(0)", sine * std::sin(axis));
    set_initial(release, "tilt", "qz(0)", 0.0);
  }

  /// The least and the most that a coefficient is in the series of a fit, at its instants: between them it is straight.
  std::vector<double> range_of_series(const TomlTable& box, const std::string& key) {
    const codebooks::Codebook book = codebooks::load(named(box.string(key)));
    try {
      const auto course = identification::codebook_course(book, plan_.model->info());
      const std::vector<std::string>& names = course->followed();
      const auto found = std::ranges::find(names, key);
      if (found == names.end())
        throw ArgumentError(fmt::format("the series has {}, expected {}", join(names), key));
      std::vector<double> range, values(names.size());
      for (const codebooks::Piece& piece : book.pieces()) {
        const codebooks::PieceOutline outline = piece.outline();
        for (const double t : outline.axes.front().nodes()) {
          course->values(t, {}, values);
          range.push_back(values[static_cast<std::size_t>(found - names.begin())]);
        }
      }
      const auto [least, most] = std::ranges::minmax(range);
      return {least, most};
    } catch (const ArgumentError& error) {
      throw box.error(key, error.what());
    }
  }

  void read_box() {
    const TomlTable box = root_.table("box");
    for (const std::string& key : box.keys()) {
      const std::string& unit = unit_of(box, key);
      if (key.ends_with("(0)")) throw box.error(key, "is an initial value, expected a coefficient");
      const std::vector<double> range =
          box.is_string(key) ? range_of_series(box, key) : box.quantities(key, unit);
      if (range.size() != 2 || !(range[0] < range[1]))
        throw box.error(key, "expected two values, [from, to], the first less than the second");
      SteeredCoefficient coefficient{.name = key, .lower = range[0], .upper = range[1]};
      const auto given = plan_.fixed.find(key);
      coefficient.natural = given != plan_.fixed.end() ? given->second : 0.5 * (range[0] + range[1]);
      if (coefficient.natural < range[0] || coefficient.natural > range[1]) {
        throw box.error(key, fmt::format("is {} to {}, expected it to hold {}, which stands in [body]",
                                         range[0], range[1], coefficient.natural));
      }
      plan_.fixed[key] = coefficient.natural;
      plan_.box.push_back(coefficient);
    }
    if (plan_.box.empty())
      throw root_.error("box", "is empty, expected at least one coefficient that may change");
    check_points(box);
  }

  /// The natural values, and the corners that differ from them in one coefficient.
  void check_points(const TomlTable& box) {
    try {
      std::map<std::string, double> fixed = plan_.fixed;
      models::ParametricModel(plan_.model, fixed, {}).check({});
      for (const SteeredCoefficient& coefficient : plan_.box) {
        for (const double value : {coefficient.lower, coefficient.upper}) {
          fixed[coefficient.name] = value;
          models::ParametricModel(plan_.model, fixed, {}).check({});
        }
        fixed[coefficient.name] = coefficient.natural;
      }
    } catch (const ArgumentError& error) {
      throw InputError(plan_.source, box.line(plan_.box.front().name), error.what());
    }
    if (!plan_.sinks())
      throw root_.error("body",
                        "is lighter than what it is in, or as light: at rest it does not begin to sink, "
                        "and never comes down");
  }

  Sketch read_formula(const TomlTable& path, const std::string& key) const {
    const TomlTable formula = path.table(key);
    const models::ModelInfo& info = plan_.model->info();
    const auto layout = StateLayout::of(info);
    if (!layout->has_velocities) throw path.error(key, "is of models with velocities, expected a file");
    const auto number = [&](const char* name, const std::string& unit) {
      return formula.quantity(name, unit);
    };
    const std::string &speed = info.states[layout->velocity[0]].unit,
                      &rate = info.states[layout->rate[0]].unit;
    std::vector<double> state(info.states.size());
    models::ParametricModel(plan_.model, plan_.fixed, {}).initial({}, state);
    const Eigen::Vector3d from = layout->place(state);
    try {
      if (planar_) {
        formula.expect_keys({"descent_speed", "horizontal_speed", "vertical_speed", "angular_frequency"});
        return sketch_of(models::SideToSidePath{.descent_speed = number("descent_speed", speed),
                                                .horizontal_speed = number("horizontal_speed", speed),
                                                .vertical_speed = number("vertical_speed", speed),
                                                .angular_frequency = number("angular_frequency", rate)},
                         from, 0.0);
      }
      formula.expect_keys(
          {"descent_speed", "amplitude_x", "amplitude_y", "modulation", "lobes", "angular_frequency"});
      return sketch_of(models::RosePath{.descent_speed = number("descent_speed", speed),
                                        .amplitude_x = number("amplitude_x", length_),
                                        .amplitude_y = number("amplitude_y", length_),
                                        .modulation = formula.optional_number("modulation").value_or(0.0),
                                        .lobes = formula.optional_number("lobes").value_or(4.0),
                                        .angular_frequency = number("angular_frequency", rate)},
                       from, 0.0);
    } catch (const ArgumentError& error) {
      throw path.error(key, error.what());
    }
  }

  void read_path() {
    const auto path = root_.optional_table("path");
    if (!path) return;
    path->expect_keys({"file", planar_ ? "side_to_side" : "rose", "deviation"});
    const std::string key = path->has("file") ? "file" : planar_ ? "side_to_side" : "rose";
    if (path->keys().size() > (path->has("deviation") ? 2U : 1U))
      throw path->error(key, "stands beside another line, expected one of them");
    plan_.sketch = key == "file" ? read_sketch(named(path->string("file")), planar_, {length_, time_})
                                 : read_formula(*path, key);
    if (path->has("deviation")) plan_.deviation = path->positive("deviation", length_);
    const double height = plan_.fixed.at(planar_ ? "y(0)" : "z(0)");
    const double begins = plan_.sketch->top();
    const double tolerance = 2.0 * plan_.semi_length() + 0.02 * height;
    if (begins < height - tolerance) {
      throw path->error(
          key, fmt::format("begins at height {:.6g}, under the release at {:.6g}: expected a sketch that "
                           "begins where the body is let go",
                           begins, height));
    }
    plan_.ground = plan_.sketch->is_timed() ? 0.0 : std::max(0.0, plan_.sketch->bottom());
    if (plan_.ground >= height) {
      throw path->error(
          key, fmt::format("ends at height {:.6g}, not below the release at {:.6g}", plan_.ground, height));
    }
    if (!plan_.sketch->is_timed()) return;
    plan_.duration = plan_.sketch->end_time();
    if (!(*plan_.duration > 0.0))
      throw path->error("file",
                        fmt::format("ends at the time {}, expected one after 0, at which the body is let "
                                    "go",
                                    *plan_.duration));
  }

  void read_database() {
    const auto file = root_.optional_string("database");
    if (file) {
      plan_.database = std::make_shared<const MotionDatabase>(load_database(named(*file)));
      try {
        const SegmentChoices check(plan_);
      } catch (const ArgumentError& error) {
        throw root_.error("database", error.what());
      }
    }
    if (const auto path = root_.optional_table("path")) refuse(*path, "file", require_rise);
    const auto sequence = root_.optional_table("sequence");
    if (!sequence) return;
    plan_.sequence = read_sequence(*sequence, folder(), plan_.database.get());
    if (const auto chain = sequence->optional_string("chain"); chain && *chain != kChainOfSource)
      named(*chain);
    if (plan_.sequence->segments.empty() || plan_.sequence->is_drawn()) return;
    const char* const key = plan_.sequence->is_of_patterns() ? "patterns" : "kinds";
    refuse(*sequence, key, require_patterns_in_box);
    refuse(*sequence, key, require_ways);
  }

  void read_codebook() {
    const auto file = root_.optional_string("codebook");
    if (!file) return;
    plan_.codebook = std::make_shared<const codebooks::Codebook>(codebooks::load(named(*file)));
    try {
      const BookTangents check(plan_);
    } catch (const ArgumentError& error) {
      throw root_.error("codebook", error.what());
    }
  }

  void refuse(const TomlTable& table, const char* key, void (*require)(const MotionPlan&)) const {
    try {
      require(plan_);
    } catch (const ArgumentError& error) {
      throw table.error(key, error.what());
    }
  }

  void read_landing() {
    const auto landing = root_.optional_table("landing");
    if (!landing) return;
    std::vector<std::string> keys = {"x", "deviation"};
    if (!planar_) keys.push_back("y");
    landing->expect_keys(keys);
    plan_.landing = Eigen::Vector3d(landing->quantity("x", length_), 0.0, plan_.ground);
    if (!planar_) plan_.landing->y() = landing->quantity("y", length_);
    if (!landing->has("deviation")) return;
    if (plan_.sketch) throw landing->error("deviation", "stands beside [path], expected it there");
    plan_.deviation = landing->positive("deviation", length_);
  }

  static int count(const TomlTable& table, const std::string& key, std::int64_t least, std::int64_t most,
                   int otherwise) {
    const std::int64_t value = table.optional_integer(key).value_or(otherwise);
    if (value < least || value > most)
      throw table.error(key, fmt::format("is {}, expected {} to {}", value, least, most));
    return static_cast<int>(value);
  }

  void read_rest() {
    if (root_.has("duration")) {
      if (plan_.duration)
        throw root_.error("duration", "stands beside a sketch with times, expected one of the two");
      plan_.duration = root_.positive("duration", time_);
    }
    if (const auto turbulence = root_.optional_table("turbulence")) {
      turbulence->expect_keys({"intensity"});
      plan_.turbulence = turbulence->number("intensity");
      if (!(plan_.turbulence > 0.0) || plan_.turbulence > 10.0)
        throw turbulence->error("intensity",
                                fmt::format("is {}, expected more than 0 and at most 10", plan_.turbulence));
    }
    const models::Scales scales = plan_.scales();
    const double time = plan_.semi_length() / scales.velocity;
    plan_.search.step = 0.01 * time;
    plan_.search.ramp = time;
    const auto search = root_.optional_table("search");
    if (search) read_search(*search);
    const double steps = plan_.steps();
    if (steps <= MotionPlan::kMostSteps) return;
    const std::string what =
        fmt::format("makes about {:.3g} steps of {:.3g} of this fall, expected at most {:.0e}", steps,
                    plan_.search.step, MotionPlan::kMostSteps);
    if (search && search->has("step")) throw search->error("step", what);
    throw root_.error("release", what + ": give a step in [search]");
  }

  void read_search(const TomlTable& search) {
    search.expect_keys({"beam", "children", "sweeps", "step", "ramp", "seed"});
    plan_.search.beam = count(search, "beam", 1, 4096, plan_.search.beam);
    plan_.search.children = count(search, "children", 2, 4096, plan_.search.children);
    plan_.search.sweeps = count(search, "sweeps", 0, 100, plan_.search.sweeps);
    plan_.search.seed = static_cast<std::uint64_t>(count(search, "seed", 0, 2000000000, 1));
    if (search.has("step")) plan_.search.step = search.positive("step", time_);
    if (search.has("ramp")) plan_.search.ramp = search.positive("ramp", time_);
    if (plan_.search.ramp < plan_.search.step) {
      throw search.error(search.has("ramp") ? "ramp" : "step",
                         fmt::format("makes a ramp of {} in steps of {}, expected a ramp of one step or more",
                                     plan_.search.ramp, plan_.search.step));
    }
  }

  const TomlTable& root_;
  MotionPlan plan_;
  bool planar_ = false;
  std::map<std::string, std::string> units_;
  std::string time_, length_;
};

}  // namespace

MotionPlan read_motion_plan(const std::filesystem::path& path) {
  return parse_motion_plan(io::read_text_file(path, {.expected = kKind}), path.string());
}

MotionPlan parse_motion_plan(const std::string& text, const std::string& name) {
  const TomlTable root = TomlTable::parse(text, name, kKind);
  return PlanReader(root, text).read();
}

}  // namespace samara::motion
