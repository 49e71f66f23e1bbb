#include <algorithm>

#include <fmt/format.h>

#include "assignments.h"
#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/codebooks/file/load.h"
#include "samara/codebooks/query/query.h"
#include "samara/io/csv.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

/// Points to ask for, one row each, and what was moved to get them into the box.
struct Points {
  Eigen::MatrixXd x;  ///< times x coordinates
  std::vector<std::string> clamped;
};

std::vector<double> times_of(const Codebook& book, const std::vector<std::string>& at) {
  const codebooks::Coordinate& time = book.time("--at");
  std::vector<double> times;
  for (const std::string& text : at) times.push_back(number_or_quantity("--at", text, time.unit));
  if (times.empty()) {
    const Eigen::VectorXd all = Eigen::VectorXd::LinSpaced(11, time.lower, time.upper);
    times.assign(all.begin(), all.end());
  }
  return times;
}

Points points_of(const Codebook& book, const QueryArguments& arguments) {
  std::map<std::string, std::string> units;
  for (const codebooks::Coordinate& c : book.parameters()) units[c.name] = c.unit;
  const std::map<std::string, double> values = parse_assignments(arguments.set, units);
  Points points;
  points.x.resize(1, book.coordinate_count());
  if (book.has_time() || !arguments.at.empty()) {
    const std::vector<double> times = times_of(book, arguments.at);
    points.x.resize(static_cast<Eigen::Index>(times.size()), book.coordinate_count());
    points.x.col(0) = Eigen::Map<const Eigen::VectorXd>(times.data(), points.x.rows());
  }
  for (int k = book.has_time() ? 1 : 0; k < book.coordinate_count(); ++k) {
    const codebooks::Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
    const auto value = values.find(c.name);
    if (value == values.end()) {
      throw ArgumentError(fmt::format("{} is not set, expected --set \"{}=VALUE\" with a value in [{}, {}]{}",
                                      c.name, c.name, c.lower, c.upper, unit_suffix(c.unit)));
    }
    points.x.col(k).setConstant(value->second);
  }
  if (!arguments.clamp) return points;
  for (int k = 0; k < book.coordinate_count(); ++k) {
    const codebooks::Coordinate& c = book.coordinates()[static_cast<std::size_t>(k)];
    const Eigen::VectorXd inside = points.x.col(k).cwiseMax(c.lower).cwiseMin(c.upper);
    if (inside != points.x.col(k)) points.clamped.push_back(c.name);
    points.x.col(k) = inside;
  }
  return points;
}

/// Values, then gradients (output by output, coordinate by coordinate).
Eigen::MatrixXd answer(const Codebook& book, const Points& points, bool gradient) {
  codebooks::Query query(book);
  const int outputs = book.output_count();
  const int coordinates = book.coordinate_count();
  Eigen::MatrixXd table(points.x.rows(), outputs + (gradient ? outputs * coordinates : 0));
  Eigen::VectorXd values(outputs);
  Eigen::MatrixXd slopes(outputs, coordinates);
  std::vector<double> x(static_cast<std::size_t>(coordinates));
  for (Eigen::Index i = 0; i < points.x.rows(); ++i) {
    for (int k = 0; k < coordinates; ++k) x[static_cast<std::size_t>(k)] = points.x(i, k);
    if (gradient) {
      query.values(x, values, slopes);
      table.row(i).tail(outputs * coordinates) = slopes.reshaped<Eigen::RowMajor>().transpose();
    } else {
      query.values(x, values);
    }
    table.row(i).head(outputs) = values.transpose();
  }
  return table;
}

std::string slope_unit(const std::string& output, const std::string& coordinate) {
  return coordinate == "1" ? output : fmt::format("{}/({})", output, coordinate);
}

std::string to_csv(const Codebook& book, const Points& points, const Eigen::MatrixXd& table, bool gradient) {
  Eigen::MatrixXd all(points.x.rows(), points.x.cols() + table.cols());
  all << points.x, table;
  std::vector<std::string> header;
  for (const codebooks::Coordinate& c : book.coordinates())
    header.push_back(fmt::format("{}[{}]", c.name, c.unit));
  for (const pgd::OutputLabel& o : book.outputs()) header.push_back(fmt::format("{}[{}]", o.name, o.unit));
  for (const pgd::OutputLabel& o : book.outputs()) {
    for (const codebooks::Coordinate& c : book.coordinates()) {
      if (gradient) header.push_back(fmt::format("d{}/d{}[{}]", o.name, c.name, slope_unit(o.unit, c.unit)));
    }
  }
  return io::format_csv(header, all);
}

Json to_json(const Codebook& book, const Points& points, const Eigen::MatrixXd& table, bool gradient) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-query/1"},
                 {"coordinates", Json::object()},
                 {"outputs", Json::array()},
                 {"clamped", points.clamped}};
  if (book.has_time()) object["coordinates"][book.coordinates()[0].name] = list(points.x.col(0));
  for (int k = book.has_time() ? 1 : 0; k < book.coordinate_count(); ++k) {
    object["coordinates"][book.coordinates()[static_cast<std::size_t>(k)].name] = points.x(0, k);
  }
  Eigen::Index column = book.output_count();
  for (int o = 0; o < book.output_count(); ++o) {
    const pgd::OutputLabel& label = book.outputs()[static_cast<std::size_t>(o)];
    Json output = {{"name", label.name}, {"unit", label.unit}, {"values", list(table.col(o))}};
    if (gradient) {
      for (const codebooks::Coordinate& c : book.coordinates())
        output["gradient"][c.name] = list(table.col(column++));
    }
    object["outputs"].push_back(output);
  }
  object["certificate_met"] = book.certificate() && book.certificate()->met;
  return object;
}

}  // namespace

int run(const QueryArguments& arguments) {
  if (!arguments.output.empty()) check_output(arguments.output, {arguments.book});
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  const Points points = points_of(book, arguments);
  for (const std::string& name : points.clamped)
    warn(fmt::format("{} was moved to the border of the box", name));
  const Eigen::MatrixXd table = answer(book, points, arguments.gradient);
  if (arguments.json) {
    write_answer(arguments.output, to_json(book, points, table, arguments.gradient).dump() + "\n");
  } else {
    write_answer(arguments.output, to_csv(book, points, table, arguments.gradient));
  }
  return kDone;
}

}  // namespace samara::apps
