#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "inputs/assignments.h"
#include "options/option_parts.h"
#include "samara/base/errors.h"
#include "samara/base/names.h"
#include "samara/base/text.h"
#include "samara/base/units.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/statistics/book_statistics.h"
#include "samara/identification/report/read_fit.h"
#include "samara/io/csv.h"
#include "terminal/output.h"
#include "terminal/terminal.h"

namespace samara::apps {

namespace {

using codebooks::BookStatistics;
using codebooks::Codebook;
using codebooks::Distribution;
using codebooks::DistributionKind;
using codebooks::OutputStatistics;

struct StatsArguments {
  std::string book;
  std::vector<std::string> set, groups;
  std::string fit;
  std::vector<double> quantiles;
  int draws = 4096;
  std::uint64_t seed = 1;
  std::string output;
  bool json = false;
};

/// "normal(1.1, 0.05)" in its name and two numbers.
struct Call {
  std::string name, first, second;
};

/// @returns no name where the text has no parentheses
Call call_of(const std::string& what, const std::string& text) {
  const std::size_t open = text.find('(');
  if (open == std::string::npos) return {};
  // A unit may have parentheses, too: "40 W/(m K)".
  const std::string_view name = trimmed(std::string_view(text).substr(0, open));
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  if (name.empty() || !std::ranges::all_of(name, is_letter)) return {};
  const std::size_t comma = text.find(',', open);
  if (text.back() != ')' || comma == std::string::npos || text.find(',', comma + 1) != std::string::npos)
    throw ArgumentError(
        fmt::format("--set {}: \"{}\" cannot be read, expected such as normal(1.1, 0.05)", what, text));
  const auto part = [&](std::size_t from, std::size_t to) {
    return std::string(trimmed(std::string_view(text).substr(from, to - from)));
  };
  return {part(0, open), part(open + 1, comma), part(comma + 1, text.size() - 1)};
}

/// What --set says of one coordinate: a value, a part of its interval, or a distribution.
void add_setting(const Setting& setting, const std::string& unit, codebooks::StatisticsRequest& request) {
  const auto& [name, text] = setting;
  const Call call = call_of(name, text);
  Distribution distribution;
  if (call.name.empty()) {
    const models::Interval interval = interval_of(name, text, unit);
    if (interval.lower == interval.upper) {
      request.fixed[name] = interval.lower;
      return;
    }
    distribution = {DistributionKind::uniform, interval.lower, interval.upper};
  } else {
    distribution.kind = codebooks::distribution_from_string(call.name);
    distribution.first = number_or_quantity(name, call.first, unit);
    distribution.second = number_or_difference(
        name, call.second, distribution.kind == DistributionKind::log_normal ? "1" : unit);
  }
  request.inputs[name] = distribution;
}

/// The coefficients of a fit that are coordinates of the codebook, with their covariance.
codebooks::JointNormal joint_of(const std::string& file, const Codebook& book) {
  const identification::FitResult fit = identification::read_fit(file);
  std::vector<Eigen::Index> places;
  codebooks::JointNormal joint;
  std::vector<double> means;
  for (std::size_t k = 0; k < fit.coefficients.size(); ++k) {
    const identification::Coefficient& c = fit.coefficients[k];
    const auto parameters = book.parameters();
    if (std::ranges::find(parameters, c.name, &codebooks::Coordinate::name) == parameters.end()) continue;
    const auto coordinate = std::ranges::find(parameters, c.name, &codebooks::Coordinate::name);
    if (!same_dimension(coordinate->unit, c.unit))
      throw InputError(file, fmt::format("\"{}\" is in {}, expected {}", c.name, c.unit, coordinate->unit));
    if (!c.standard_error)
      throw InputError(file, fmt::format("the fit gives \"{}\" no standard error, expected one", c.name));
    joint.inputs.push_back(c.name);
    means.push_back(c.value);
    places.push_back(static_cast<Eigen::Index>(k));
  }
  if (joint.inputs.empty())
    throw InputError(file, "no coefficient of the fit is a coordinate of the codebook");
  const auto count = static_cast<Eigen::Index>(fit.coefficients.size());
  if (fit.covariance.rows() != count || fit.covariance.cols() != count ||
      !fit.covariance(places, places).allFinite())
    throw InputError(file, "the fit has no covariance of these coefficients, expected one");
  joint.mean = Eigen::Map<const Eigen::VectorXd>(means.data(), static_cast<Eigen::Index>(means.size()));
  joint.covariance = fit.covariance(places, places);
  return joint;
}

codebooks::StatisticsRequest request_of(const StatsArguments& arguments, const Codebook& book) {
  codebooks::StatisticsRequest request;
  std::vector<std::string> known;
  for (const codebooks::Coordinate& c : book.parameters()) known.push_back(c.name);
  for (const std::string& text : arguments.set) {
    Setting setting = setting_of("--set", text);
    setting.name = full_name(setting.name, known);
    const auto parameters = book.parameters();
    const auto coordinate = std::ranges::find(parameters, setting.name, &codebooks::Coordinate::name);
    if (coordinate == parameters.end())
      throw ArgumentError(
          fmt::format("--set: unknown name \"{}\"{}", setting.name, suggestion(setting.name, known)));
    if (request.inputs.contains(setting.name) || request.fixed.contains(setting.name))
      throw ArgumentError(fmt::format("--set: \"{}\" is set twice", setting.name));
    add_setting(setting, coordinate->unit, request);
  }
  for (const std::string& text : arguments.groups) {
    std::vector<std::string> group;
    std::size_t from = 0;
    while (from <= text.size()) {
      const std::size_t comma = std::min(text.find(',', from), text.size());
      group.emplace_back(trimmed(std::string_view(text).substr(from, comma - from)));
      from = comma + 1;
    }
    if (group.size() < 2)
      throw ArgumentError(
          fmt::format("--group \"{}\": a single input, whose indices are given anyway; two or more, as in "
                      "A,B, were expected",
                      text));
    request.groups.push_back(std::move(group));
  }
  request.quantiles = arguments.quantiles;
  request.draws = arguments.draws;
  request.seed = arguments.seed;
  if (arguments.fit.empty()) return request;
  codebooks::JointNormal joint = joint_of(arguments.fit, book);
  const std::string& only = joint.inputs.front();
  if (joint.inputs.size() > 1) {
    request.joint = std::move(joint);
  } else if (request.inputs.contains(only) || request.fixed.contains(only)) {
    throw ArgumentError(fmt::format("\"{}\" is given by --fit, and by --set", only));
  } else {
    request.inputs[only] = {DistributionKind::normal, joint.mean[0], std::sqrt(joint.covariance(0, 0))};
  }
  return request;
}

std::string sum_of(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, "+"));
}

std::string to_csv(const Codebook& book, const BookStatistics& s) {
  std::vector<std::string> header;
  std::vector<Eigen::VectorXd> columns;
  const auto add = [&](const std::string& name, const Eigen::VectorXd& column) {
    header.push_back(name);
    columns.push_back(column);
  };
  if (book.has_time())
    add(fmt::format("{}[{}]", book.coordinates().front().name, book.coordinates().front().unit), s.times);
  for (const OutputStatistics& output : s.outputs) {
    add(fmt::format("mean({})[{}]", output.name, output.unit), output.mean);
    add(fmt::format("deviation({})[{}]", output.name, output.unit), output.deviation);
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      add(fmt::format("first({},{})[1]", output.name, s.inputs[k]), output.first_order.col(column));
      add(fmt::format("total({},{})[1]", output.name, s.inputs[k]), output.total.col(column));
    }
    for (std::size_t k = 0; k < s.groups.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      add(fmt::format("closed({},{})[1]", output.name, sum_of(s.groups[k])), output.group_closed.col(column));
      add(fmt::format("total({},{})[1]", output.name, sum_of(s.groups[k])), output.group_total.col(column));
    }
    for (std::size_t k = 0; k < s.quantiles.size(); ++k)
      add(fmt::format("quantile({},{})[{}]", output.name, s.quantiles[k], output.unit),
          output.quantiles.col(static_cast<Eigen::Index>(k)));
  }
  Eigen::MatrixXd table(columns.front().size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) table.col(static_cast<Eigen::Index>(c)) = columns[c];
  return io::format_csv(header, table);
}

Json statistics_json(const Codebook& book, const BookStatistics& s) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-stats/1"}, {"inputs", s.inputs}, {"outputs", Json::array()}};
  if (book.has_time()) object["times"] = list(s.times);
  if (!s.quantiles.empty()) object["quantiles"] = s.quantiles;
  for (const OutputStatistics& output : s.outputs) {
    Json one = {{"name", output.name},
                {"unit", output.unit},
                {"mean", list(output.mean)},
                {"deviation", list(output.deviation)}};
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      one["first_order"][s.inputs[k]] = list(output.first_order.col(static_cast<Eigen::Index>(k)));
      one["total"][s.inputs[k]] = list(output.total.col(static_cast<Eigen::Index>(k)));
    }
    for (std::size_t k = 0; k < s.groups.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      one["groups"].push_back({{"inputs", s.groups[k]},
                               {"closed", list(output.group_closed.col(column))},
                               {"total", list(output.group_total.col(column))}});
    }
    for (std::size_t k = 0; k < s.quantiles.size(); ++k)
      one["quantiles"].push_back(list(output.quantiles.col(static_cast<Eigen::Index>(k))));
    object["outputs"].push_back(one);
  }
  if (!s.notes.empty()) object["notes"] = s.notes;
  return object;
}

int run_stats(const StatsArguments& arguments) {
  if (!arguments.output.empty())
    check_text_output(arguments.output, {arguments.book, arguments.fit}, arguments.json ? ".json" : ".csv");
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  BookStatistics statistics = take_statistics(book, request_of(arguments, book));
  std::vector<std::string> derived;
  for (const pgd::OutputLabel& output : derived_outputs(book)) derived.push_back(output.name);
  if (!derived.empty())
    statistics.notes.push_back(
        fmt::format("what the model derives is left out, {}: statistics are of what the codebook stores",
                    fmt::join(derived, ", ")));
  for (const std::string& note : statistics.notes) narrate(note);
  write_answer(arguments.output,
               arguments.json ? json_line(statistics_json(book, statistics)) : to_csv(book, statistics));
  return kDone;
}

}  // namespace

void add_stats(CLI::App& app, Arguments& arguments) {
  auto values = std::make_shared<StatsArguments>();
  CLI::App* command = app.add_subcommand("stats",
                                         "mean, deviation, Sobol' indices and quantiles of the outputs, over "
                                         "time, of inputs that are uniform over the "
                                         "box or distributed otherwise, as CSV or JSON");
  command->add_option("BOOK", values->book, "codebook file")->required();
  command
      ->add_option("--set", values->set,
                   "NAME=VALUE holds an input; NAME=FROM..TO, \"NAME=normal(MEAN, DEVIATION)\" and "
                   "\"NAME=lognormal(MEDIAN, DEVIATION OF THE LOGARITHM)\" say how it is distributed")
      ->allow_extra_args(false);
  command->add_option("--fit", values->fit,
                      "fit (samara fit -o FIT.json) whose coefficients are inputs, with its covariance");
  command->add_option("--quantiles", values->quantiles, "shares above 0 and below 1: 0.05 0.5 0.95");
  command->add_option("--group", values->groups, "inputs to give indices of together: C_T,C_R")
      ->allow_extra_args(false);
  command->add_option("--draws", values->draws, "of quantiles, and of correlated inputs")
      ->capture_default_str()
      ->check(whole_number());
  command->add_option("--seed", values->seed, "of the draws, from 0")
      ->capture_default_str()
      ->check(whole_number<std::uint64_t>());
  command->add_option("-o,--output", values->output, kAnswerFile);
  command->add_flag("--json", values->json, kJson);
  on_call(*command, arguments, values, run_stats);
}

}  // namespace samara::apps
