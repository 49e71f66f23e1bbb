#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "inputs/query_points.h"
#include "options/option_parts.h"
#include "pictures/animation.h"
#include "pictures/shown_bodies.h"
#include "samara/base/errors.h"
#include "samara/base/unit_labels.h"
#include "samara/codebooks/book/book_model.h"
#include "samara/codebooks/composition/codebook_trajectories.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/derived_query.h"
#include "samara/codebooks/query/place_query.h"
#include "samara/codebooks/query/query.h"
#include "samara/io/animated_scene.h"
#include "samara/io/csv.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;
using Labels = std::vector<pgd::OutputLabel>;

using Coordinates = std::vector<codebooks::Coordinate>;

/// Of a point in each row: values, then gradients (output by output, coordinate by coordinate).
using Answers = io::NumberTable::Rows;

template <class AnyQuery>
Answers answer(AnyQuery query, Eigen::Index outputs, const QueryPoints& points, bool gradient) {
  const auto coordinates = points.x.cols();
  Answers table(points.x.rows(), outputs + (gradient ? outputs * coordinates : 0));
  Eigen::VectorXd values(outputs);
  Eigen::MatrixXd slopes(outputs, coordinates);
  std::vector<double> x(static_cast<std::size_t>(coordinates));
  for (Eigen::Index i = 0; i < points.x.rows(); ++i) {
    for (Eigen::Index k = 0; k < coordinates; ++k) x[static_cast<std::size_t>(k)] = points.x(i, k);
    try {
      if (gradient) {
        query.values(x, values, slopes);
        table.row(i).tail(outputs * coordinates) = slopes.reshaped<Eigen::RowMajor>().transpose();
      } else {
        query.values(x, values);
      }
    } catch (const OutsideBoxError& error) {  // in no cell of a mesh
      if (!points.table) throw;
      throw OutsideBoxError(points.table->error(i / points.times, error.what()).what());
    }
    table.row(i).head(outputs) = values.transpose();
  }
  return table;
}

/// The same of many points at once.
Answers batch_answer(codebooks::Query query, const QueryPoints& points, bool gradient) {
  const Eigen::Index outputs = query.output_count(), coordinates = points.x.cols(), count = points.x.rows();
  Answers table(count, outputs * (gradient ? 1 + coordinates : 1));
  // What is a row here is a column there, in the same memory.
  const Eigen::Map<const Eigen::MatrixXd> columns(points.x.data(), coordinates, count);
  Eigen::Map<Eigen::MatrixXd> answers(table.data(), table.cols(), count);
  if (!gradient) {
    query.batch(columns, answers, 0);
    return table;
  }
  Eigen::MatrixXd slopes(outputs * coordinates, count);
  query.batch(columns, answers.topRows(outputs), slopes, 0);
  for (Eigen::Index o = 0; o < outputs; ++o) {
    for (Eigen::Index k = 0; k < coordinates; ++k)
      answers.row(outputs + o * coordinates + k) = slopes.row(o + outputs * k);
  }
  return table;
}

/// As CSV, to the file or part by part to stdout.
void write_csv(const std::string& path, const Labels& outputs, const QueryPoints& points,
               const Answers& table, bool gradient) {
  const Coordinates& coordinates = points.coordinates;
  std::vector<std::string> header;
  for (const codebooks::Coordinate& c : coordinates) header.push_back(fmt::format("{}[{}]", c.name, c.unit));
  for (const pgd::OutputLabel& o : outputs) header.push_back(fmt::format("{}[{}]", o.name, o.unit));
  for (const pgd::OutputLabel& o : outputs) {
    for (const codebooks::Coordinate& c : coordinates) {
      if (gradient)
        header.push_back(fmt::format("d{}/d{}[{}]", o.name, c.name, unit_quotient(o.unit, c.unit)));
    }
  }
  const auto append = [&](Eigen::Index begin, Eigen::Index end, std::string& text) {
    std::vector<std::string_view> cells;
    for (Eigen::Index i = begin; i < end; ++i) {
      points.append_cells(i, cells, text);
      for (const double value : table.row(i)) {
        text += ',';
        io::append_number(text, value);
      }
      text += '\n';
    }
  };
  if (path.empty()) return io::stream_csv(header, table.rows(), append, print_part);
  std::string text;
  io::stream_csv(header, table.rows(), append, [&](std::string_view part) { text += part; });
  write_answer(path, text);
}

Json values_json(const Codebook& book, const Labels& outputs, const QueryPoints& points, const Answers& table,
                 bool gradient, bool composed) {
  const Coordinates& coordinates = points.coordinates;
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-query/1"},
                 {"coordinates", Json::object()},
                 {"outputs", Json::array()},
                 {"clamped", points.clamped}};
  if (book.has_time()) object["coordinates"][coordinates[0].name] = list(points.x.col(0));
  for (auto k = book.has_time() ? 1 : 0; k < std::ssize(coordinates); ++k) {
    Json& of_coordinate = object["coordinates"][coordinates[static_cast<std::size_t>(k)].name];
    of_coordinate = points.table ? Json(list(points.x.col(k))) : Json(points.x(0, k));
  }
  Eigen::Index column = std::ssize(outputs);
  for (std::size_t o = 0; o < outputs.size(); ++o) {
    const auto values = list(table.col(static_cast<Eigen::Index>(o)));
    Json output = {{"name", outputs[o].name}, {"unit", outputs[o].unit}, {"values", values}};
    if (gradient) {
      for (const codebooks::Coordinate& c : coordinates)
        output["gradient"][c.name] = list(table.col(column++));
    }
    object["outputs"].push_back(output);
  }
  // The certificate is of one window, not of what windows are composed to.
  if (!composed) object["certificate_met"] = book.certificate() && book.certificate()->met;
  return object;
}

/// By whose values there are no derivatives.
std::vector<bool> are_lists(const Codebook& book, const Coordinates& coordinates) {
  const std::vector<pgd::Axis> axes = book.pieces().front().outline().axes;
  std::vector<bool> lists;
  for (const codebooks::Coordinate& c : coordinates) {
    const auto axis = std::ranges::find(axes, c.name, &pgd::Axis::name);
    lists.push_back(axis != axes.end() && axis->is_list());
  }
  return lists;
}

/// Whether all are numbers, but for the derivatives that lists do not have; what is none becomes empty.
bool keep_all_numbers(const Codebook& book, const Labels& outputs, const QueryPoints& points,
                      Eigen::Ref<Answers> table) {
  if (table.allFinite()) return true;
  bool all_numbers = true;
  Eigen::Index column = 0;
  for (const pgd::OutputLabel& o : outputs) all_numbers &= keep_numbers(o.name, table.col(column++));
  const std::vector<bool> lists = are_lists(book, points.coordinates);
  for (std::size_t k = 0; column < table.cols(); ++k, ++column) {
    const std::size_t c = k % lists.size();
    if (lists[c]) continue;
    const std::string& output = outputs[k / lists.size()].name;
    all_numbers &= keep_numbers(fmt::format("the derivative of {} by {}", output, points.coordinates[c].name),
                                table.col(column));
  }
  return all_numbers;
}

/// @param rows which have answers: the first ones
/// @return the exit code
int write(const QueryArguments& arguments, const Codebook& book, const Labels& outputs,
          const QueryPoints& points, Answers table, Eigen::Index rows) {
  const bool all_numbers = keep_all_numbers(book, outputs, points, table.topRows(rows));
  if (arguments.json) {
    const bool composed = !arguments.until.empty();
    write_answer(arguments.output,
                 json_line(values_json(book, outputs, points, table, arguments.gradient, composed)));
  } else {
    write_csv(arguments.output, outputs, points, table, arguments.gradient);
  }
  return all_numbers ? kDone : kToleranceMissed;
}

std::optional<Codebook> second_of(const QueryArguments& arguments) {
  if (arguments.second.empty()) return std::nullopt;
  Codebook second = codebooks::load(arguments.second);
  warn_of_missed_tolerance(second, arguments.second);
  return second;
}

/// The states at times of any length, by the flow map of the codebook.
int run_composed(const QueryArguments& arguments, const Codebook& book) {
  const QueryPoints points = points_of(book, arguments);
  const std::optional<Codebook> second = second_of(arguments);
  const auto family = codebooks::flow_map_trajectories(book, second ? &*second : nullptr);
  const Eigen::VectorXd q = points.x.row(0).tail(points.x.cols() - 1).transpose();
  const Eigen::VectorXd times = points.x.col(0);
  const models::FamilyTrajectory result =
      models::trajectory(*family, {q.data(), static_cast<std::size_t>(q.size())},
                         {times.begin(), times.end()}, models::output_names(family->info()));
  if (!result.outcome && result.outcome.reached < 0.0) throw OutsideBoxError(result.outcome.message);
  Labels outputs;
  for (const models::FamilyOutput& output : family->info().outputs)
    outputs.push_back({output.name, output.unit});
  const Eigen::Index rows =
      models::rows_reached(result.outcome, {times.data(), static_cast<std::size_t>(times.size())});
  const int code = write(arguments, book, outputs, points, result.values, rows);
  if (result.outcome) return code;
  warn(fmt::format("{}; values after t = {:.6g} are empty", result.outcome.message, result.outcome.reached));
  return kOutsideBox;
}

void warn_of_clamped(const QueryPoints& points) {
  for (const std::string& name : points.clamped)
    warn(fmt::format("{} was moved to the border of the box", name));
}

/// The motion of the body, to a .glb or .usda: over the times that were asked for, or all of them.
int run_animated(const QueryArguments& arguments, const Codebook& book) {
  if (arguments.json || arguments.gradient)
    throw ArgumentError("a .glb or .usda holds a motion: neither --json nor --gradient was expected");
  if (!arguments.points.empty())
    throw ArgumentError("a .glb or .usda holds one motion: no --points was expected");
  const auto model = codebooks::known_model(book.model());
  if (!model) throw ArgumentError(fmt::format("{} is of a program, which moves no body", arguments.book));
  const QueryPoints points = points_of(book, arguments);
  warn_of_clamped(points);
  Animation animation{.states = animated_states(model->info()),
                      .body = {},
                      .model = book.model().name,
                      .parameters = book.model().fixed};
  const Eigen::VectorXd q = points.x.row(0).tail(points.x.cols() - 1).transpose();
  animation.q.assign(q.begin(), q.end());
  animation.body = animated_body(arguments.body, codebooks::model_of(book), animation.q);
  for (std::size_t k = 0; k < animation.q.size(); ++k)
    animation.parameters[book.parameters()[k].name] = animation.q[k];
  animation.notes = {{"codebook", arguments.book}};
  animation.from = points.x.col(0).minCoeff();
  animation.to = points.x.col(0).maxCoeff();
  if (!(animation.from < animation.to))
    throw ArgumentError(
        "--at has one time, but a motion has a begin and an end: two times, or none, were expected");
  const std::optional<Codebook> second = second_of(arguments);
  const auto family = arguments.until.empty()
                          ? codebooks::codebook_trajectories(book)
                          : codebooks::flow_map_trajectories(book, second ? &*second : nullptr);
  animation.family = family.get();
  return write_animation(arguments.output, animation);
}

int run_query(const QueryArguments& arguments) {
  if (!arguments.until.empty() &&
      (!arguments.at.empty() || arguments.gradient || arguments.clamp || !arguments.points.empty())) {
    throw ArgumentError(
        "--until composes windows of the codebook: none of --at, --gradient and --clamp was expected, nor "
        "--points");
  }
  if (arguments.until.empty() && !arguments.second.empty())
    throw ArgumentError("--second is of composed windows: --until was expected beside it");
  if (!arguments.output.empty())
    check_text_or_scene_output(arguments.output, {arguments.book, arguments.points, arguments.second},
                               arguments.json ? ".json" : ".csv");
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  if (io::is_scene_name(arguments.output)) return run_animated(arguments, book);
  refuse_shown(arguments.body);
  if (!arguments.until.empty()) return run_composed(arguments, book);
  const QueryPoints points = points_of(book, arguments);
  warn_of_clamped(points);
  codebooks::DerivedQuery query(book);
  const Labels outputs = query.outputs();
  const Eigen::Index count = std::ssize(outputs);
  const bool at_once = points.table && !points.of_places && count == book.output_count();  // none is derived
  Answers table = at_once            ? batch_answer(codebooks::Query(book), points, arguments.gradient)
                  : points.of_places ? answer(codebooks::PlaceQuery(book), count, points, arguments.gradient)
                                     : answer(std::move(query), count, points, arguments.gradient);
  const Eigen::Index rows = table.rows();
  return write(arguments, book, outputs, points, std::move(table), rows);
}

}  // namespace

void add_query(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<QueryArguments>();
  CLI::App* command =
      app.add_subcommand("query", "values of a codebook, and derivatives by every axis, as CSV or JSON");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command->add_option("--set", values->set, kAssignments)->allow_extra_args(false);
  CLI::Option* at = command->add_option("--at", values->at, kTimes);
  command->add_option("--frames", values->frames, "so many times, equally spaced, in place of 11")
      ->check(whole_number())
      ->check(CLI::Range(2, 10000000))
      ->excludes(at);
  command->add_option(
      "--points", values->points,
      "table of points, CSV with a column for each coordinate (\"C_D,v(0)[cm/s]\"), or - for stdin: a row "
      "each; what no "
      "column names is --set, and without a column of the time each point is asked at all times");
  command->add_option("--until", values->until,
                      "11 times from 0 to this one, s or with a unit, also after the codebook's own: by its "
                      "windows, composed, where the initial state is free");
  command->add_option("--second", values->second,
                      "of --until: codebook of the same model and time for attitudes near upside down");
  command->add_flag("--gradient", values->gradient, "add the derivative of every output by every axis");
  command->add_flag("--clamp", values->clamp,
                    "take the nearest point of the box instead of refusing (exit code 5)");
  command->add_option(
      "-o,--output", values->output,
      "file for the answer, CSV or with --json JSON, or the motion of the body: .glb (glTF) or "
      ".usda; stdout if not given");
  add_shown_words(*command, values->body);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_query);
}

}  // namespace samara::apps
