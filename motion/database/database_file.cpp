#include "samara/motion/database/database_file.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "samara/base/errors.h"
#include "samara/base/version.h"
#include "samara/io/hdf5_reader.h"
#include "samara/io/hdf5_writer.h"

namespace samara::motion {

namespace {

constexpr const char* kMotions = "samara-motions";
constexpr const char* kMotionsVersion = "0.1";

const std::vector<std::string>& symmetry_names() {
  static const std::vector<std::string> names = {"none", "half turn", "ellipsoid", "disc"};
  return names;
}

/// A column of numbers, one of each of some things.
template <class Items, class Number>
Eigen::VectorXd column_of(const Items& items, const Number& number) {
  Eigen::VectorXd all(static_cast<Eigen::Index>(items.size()));
  Eigen::Index k = 0;
  for (const auto& item : items) all[k++] = static_cast<double>(number(item));
  return all;
}

/// Whole numbers from 0 to `count` - 1.
std::vector<Eigen::Index> numbers_below(const io::Hdf5Reader& file, const std::string& path,
                                        Eigen::Index rows, Eigen::Index count) {
  std::vector<Eigen::Index> all;
  for (const double value : file.vector(path, {.rows = rows})) {
    if (!(value >= 0.0 && value < static_cast<double>(count)) || value != std::floor(value))
      throw file.error(path,
                       fmt::format("has the number {}, expected a whole one from 0 to {}", value, count - 1));
    all.push_back(static_cast<Eigen::Index>(value));
  }
  return all;
}

void write_head(io::Hdf5Writer& file, const MotionDatabase& database) {
  file.write_text_attribute("/", "format", kMotions);
  file.write_text_attribute("/", "format_version", kMotionsVersion);
  file.write_text_attribute("/", "generator", fmt::format("samara {}", version()));
  file.write_text_attribute("/", "model", database.model);
  file.write_text_attribute("/", "symmetry", symmetry_names()[static_cast<std::size_t>(database.symmetry)]);
  file.write_number_attribute("/", "step", database.step);
  file.write_number_attribute("/", "frame_interval", database.frame_interval);
  file.write_number_attribute("/", "settle", database.settle);
  file.write_number_attribute("/", "body_length", database.body_length);
  file.write_texts("/plan", {database.plan_text});
  file.write_texts("/state_names", database.state_names);
  file.create_group("/fixed");
  for (const auto& [name, value] : database.fixed) file.write_number_attribute("/fixed", name, value);
  file.write_texts("/fixed_names", [&] {
    std::vector<std::string> names;
    for (const auto& one : database.fixed) names.push_back(one.first);
    return names;
  }());
  file.create_group("/events");
  file.write_number_attribute("/events", "mean_square_speed", database.events.mean_square_speed);
  file.write_number_attribute("/events", "prominence", database.events.prominence);
  file.write_number_attribute("/events", "turn", database.events.turn);
  file.write_number_attribute("/events", "shortest", database.events.shortest);
  file.write_number_attribute("/events", "steady", database.events.steady);
  file.write_vector("/metric_weights", database.metric_weights);
}

void write_runs(io::Hdf5Writer& file, const MotionDatabase& database) {
  file.write_texts("/coefficient_names", database.coefficient_names);
  file.write_texts("/coefficient_units", database.coefficient_units);
  file.write_vector("/lower", database.lower);
  file.write_vector("/upper", database.upper);
  Eigen::MatrixXd coefficients(static_cast<Eigen::Index>(database.runs.size()), database.lower.size());
  for (std::size_t n = 0; n < database.runs.size(); ++n)
    coefficients.row(static_cast<Eigen::Index>(n)) = database.runs[n].coefficients;
  file.write_matrix("/runs/coefficients", coefficients);
  file.write_vector("/runs/fall", column_of(database.runs, [](const MotionRun& run) { return run.fall; }));
  file.write_vector("/runs/pattern", column_of(database.runs, [](const MotionRun& run) {
                      return static_cast<int>(run.pattern);
                    }));
  file.write_texts("/pattern_names", pattern_names());
  file.write_vector("/runs/settle",
                    column_of(database.runs, [](const MotionRun& run) { return run.settle; }));
  file.write_vector("/run_first", column_of(database.run_first, [](Eigen::Index n) { return n; }));
  file.write_matrix("/frames", database.frames);
}

/// Of states in rows.
Eigen::MatrixXd reduced_rows(const MotionDatabase& database, const Eigen::MatrixXd& states) {
  const MovingStates moving = database.moving_states();
  Eigen::MatrixXd reduced(states.rows(), moving.reduced_size());
  Eigen::VectorXd state, one(moving.reduced_size());
  for (Eigen::Index n = 0; n < states.rows(); ++n) {
    state = states.row(n);
    moving.reduce({state.data(), static_cast<std::size_t>(state.size())},
                  {one.data(), static_cast<std::size_t>(one.size())});
    reduced.row(n) = one;
  }
  return reduced;
}

void write_segments(io::Hdf5Writer& file, const MotionDatabase& database) {
  const auto& all = database.segments;
  const auto write = [&](const std::string& name, const auto& number) {
    file.write_vector("/segments/" + name, column_of(all, number));
  };
  write("run", [](const MotionSegment& s) { return s.run; });
  write("first", [](const MotionSegment& s) { return s.first; });
  write("last", [](const MotionSegment& s) { return s.last; });
  write("kind", [](const MotionSegment& s) { return static_cast<int>(s.kind); });
  write("pattern", [&](const MotionSegment& s) {
    return static_cast<int>(database.runs[static_cast<std::size_t>(s.run)].pattern);
  });
  write("is_steady", [](const MotionSegment& s) { return s.is_steady ? 1 : 0; });
  write("begin", [](const MotionSegment& s) { return s.begin; });
  write("duration", [](const MotionSegment& s) { return s.duration; });
  Eigen::MatrixXd displacement(database.segment_count(), 3);
  for (Eigen::Index n = 0; n < displacement.rows(); ++n)
    displacement.row(n) = all[static_cast<std::size_t>(n)].displacement;
  file.write_matrix("/segments/displacement", displacement);
  file.write_matrix("/segments/start", database.starts);
  file.write_matrix("/segments/end", database.ends);
  file.write_matrix("/segments/reduced_start", reduced_rows(database, database.starts));
  file.write_matrix("/segments/reduced_end", reduced_rows(database, database.ends));
  file.write_texts("/kind_names", event_kind_names());
}

void write_graph(io::Hdf5Writer& file, const MotionGraph& graph) {
  file.write_vector("/edges/from", column_of(graph.edges, [](const GraphEdge& e) { return e.from; }));
  file.write_vector("/edges/to", column_of(graph.edges, [](const GraphEdge& e) { return e.to; }));
  file.write_vector("/edges/distance", column_of(graph.edges, [](const GraphEdge& e) { return e.distance; }));
  file.write_number_attribute("/edges", "threshold", graph.threshold);
  file.write_vector("/component", column_of(graph.component, [](int c) { return c; }));
  Eigen::MatrixXd curve(static_cast<Eigen::Index>(graph.curve.size()), 3);
  for (std::size_t k = 0; k < graph.curve.size(); ++k)
    curve.row(static_cast<Eigen::Index>(k)) << graph.curve[k].threshold, graph.curve[k].share,
        static_cast<double>(graph.curve[k].edges);
  file.write_matrix("/threshold_curve", curve);
}

void read_head(const io::Hdf5Reader& file, MotionDatabase& database) {
  database.model = file.text_attribute("/", "model");
  const std::string symmetry = file.text_attribute("/", "symmetry");
  const auto known = std::ranges::find(symmetry_names(), symmetry);
  if (known == symmetry_names().end())
    throw file.error("/", fmt::format("the attribute symmetry is \"{}\", which is none", symmetry));
  database.symmetry = static_cast<BodySymmetry>(known - symmetry_names().begin());
  database.step = file.finite_attribute("/", "step");
  database.frame_interval = file.finite_attribute("/", "frame_interval");
  database.settle = file.finite_attribute("/", "settle");
  database.body_length = file.finite_attribute("/", "body_length");
  const std::vector<std::string> plan = file.texts("/plan");
  if (plan.size() != 1) throw file.error("/plan", "is not one text");
  database.plan_text = plan.front();
  database.state_names = file.texts("/state_names");
  for (const std::string& name : file.texts("/fixed_names"))
    database.fixed[name] = file.finite_attribute("/fixed", name);
  database.events.mean_square_speed = file.finite_attribute("/events", "mean_square_speed");
  database.events.prominence = file.finite_attribute("/events", "prominence");
  database.events.turn = file.finite_attribute("/events", "turn");
  database.events.shortest = file.finite_attribute("/events", "shortest");
  database.events.steady = file.finite_attribute("/events", "steady");
}

void read_runs(const io::Hdf5Reader& file, MotionDatabase& database) {
  database.coefficient_names = file.texts("/coefficient_names");
  database.coefficient_units = file.texts("/coefficient_units");
  const auto coefficients = static_cast<Eigen::Index>(database.coefficient_names.size());
  if (database.coefficient_units.size() != database.coefficient_names.size())
    throw file.error("/coefficient_units", "are not as many as /coefficient_names");
  database.lower = file.vector("/lower", {.rows = coefficients});
  database.upper = file.vector("/upper", {.rows = coefficients});
  const Eigen::MatrixXd values = file.matrix("/runs/coefficients", {.columns = coefficients});
  if (file.texts("/pattern_names") != pattern_names())
    throw file.error("/pattern_names", "are not the patterns of this program");
  const auto falls = numbers_below(file, "/runs/fall", values.rows(), kMostFalls);
  const auto patterns =
      numbers_below(file, "/runs/pattern", values.rows(), static_cast<Eigen::Index>(kPatterns));
  Eigen::VectorXd settle = Eigen::VectorXd::Constant(values.rows(), database.settle);
  // Older files have one for all.
  if (file.has("/runs/settle")) settle = file.vector("/runs/settle", {.rows = values.rows()});
  for (Eigen::Index n = 0; n < values.rows(); ++n) {
    const auto k = static_cast<std::size_t>(n);
    database.runs.push_back({falls[k], values.row(n), static_cast<Pattern>(patterns[k]), settle[n]});
  }
  const auto states = static_cast<Eigen::Index>(database.state_names.size());
  database.frames = file.matrix("/frames", {.columns = states});
  database.run_first = numbers_below(file, "/run_first", values.rows(), database.frames.rows() + 1);
}

void read_segments(const io::Hdf5Reader& file, MotionDatabase& database) {
  const auto states = static_cast<Eigen::Index>(database.state_names.size());
  database.starts = file.matrix("/segments/start", {.columns = states});
  const Eigen::Index count = database.starts.rows();
  database.ends = file.matrix("/segments/end", {.rows = count, .columns = states});
  if (count < 2) throw file.error("/segments/start", "has fewer than two segments");
  if (file.texts("/kind_names") != event_kind_names())
    throw file.error("/kind_names", "are not the kinds of this program");
  const auto runs =
      numbers_below(file, "/segments/run", count, static_cast<Eigen::Index>(database.runs.size()));
  constexpr Eigen::Index kMostFrames = Eigen::Index{1} << 50;
  const auto first = numbers_below(file, "/segments/first", count, kMostFrames);
  const auto last = numbers_below(file, "/segments/last", count, kMostFrames);
  const auto kinds = numbers_below(file, "/segments/kind", count, static_cast<Eigen::Index>(kEventKinds));
  const auto steady = numbers_below(file, "/segments/is_steady", count, 2);
  const Eigen::VectorXd begin = file.vector("/segments/begin", {.rows = count});
  const Eigen::VectorXd duration = file.vector("/segments/duration", {.rows = count});
  const Eigen::MatrixXd displacement = file.matrix("/segments/displacement", {.rows = count, .columns = 3});
  for (Eigen::Index n = 0; n < count; ++n) {
    const auto k = static_cast<std::size_t>(n);
    if (n > 0 && runs[k] < runs[k - 1]) throw file.error("/segments/run", "is not in the order of runs");
    database.segments.push_back({runs[k], first[k], last[k], static_cast<EventKind>(kinds[k]), begin[n],
                                 duration[n], displacement.row(n), steady[k] == 1});
  }
}

/// What the model says about the rest.
void check_model(const io::Hdf5Reader& file, const MotionDatabase& database) {
  try {
    const models::ParametricModel model = database.parametric_model();
    const auto& states = model.model().info().states;
    bool same = states.size() == database.state_names.size();
    for (std::size_t k = 0; same && k < states.size(); ++k) same = states[k].name == database.state_names[k];
    if (!same) throw file.error("/state_names", fmt::format("are not the states of {}", database.model));
    if (database.metric_weights.size() != database.moving_states().reduced_size())
      throw file.error("/metric_weights",
                       fmt::format("has {} numbers, expected {}", database.metric_weights.size(),
                                   database.moving_states().reduced_size()));
    const EventFinder finder(database.moving_states(), database.events);
  } catch (const ArgumentError& error) {
    throw file.error("/", error.what());
  }
}

}  // namespace

void save(const MotionDatabase& database, const MotionGraph& graph, const std::filesystem::path& path) {
  io::Hdf5Writer file(path);
  write_head(file, database);
  write_runs(file, database);
  write_segments(file, database);
  write_graph(file, graph);
  const KindChain kinds = kind_chain(database);
  file.write_matrix("/chain/counts", kinds.chain.counts());
  file.write_integer_attribute("/chain", "order", kinds.chain.order());
  file.commit();
}

MotionDatabase load_database(const std::filesystem::path& path) {
  const io::Hdf5Reader file(path);
  if (!file.has_attribute("/", "format") || file.text_attribute("/", "format") != kMotions)
    throw file.error("/", "the attribute format is not \"samara-motions\": this is no database of motions");
  const std::string version = file.text_attribute("/", "format_version");
  if (version.rfind("0.", 0) != 0)
    throw file.error("/", fmt::format("is of format {}, expected 0.x: a newer program wrote it", version));
  MotionDatabase database;
  read_head(file, database);
  database.metric_weights = file.vector("/metric_weights");
  read_runs(file, database);
  read_segments(file, database);
  check_model(file, database);
  return database;
}

}  // namespace samara::motion
