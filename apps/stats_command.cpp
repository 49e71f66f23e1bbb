#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/codebooks/book/book_statistics.h"
#include "samara/codebooks/file/load.h"
#include "samara/io/csv.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

std::string to_csv(const Codebook& book, const codebooks::BookStatistics& s) {
  std::vector<std::string> header;
  std::vector<Eigen::VectorXd> columns;
  if (book.has_time()) {
    header.push_back(fmt::format("{}[{}]", book.coordinates().front().name, book.coordinates().front().unit));
    columns.push_back(s.times);
  }
  for (const codebooks::OutputStatistics& output : s.outputs) {
    header.push_back(fmt::format("mean({})[{}]", output.name, output.unit));
    header.push_back(fmt::format("deviation({})[{}]", output.name, output.unit));
    columns.push_back(output.mean);
    columns.push_back(output.deviation);
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      header.push_back(fmt::format("first({},{})[1]", output.name, s.inputs[k]));
      header.push_back(fmt::format("total({},{})[1]", output.name, s.inputs[k]));
      columns.push_back(output.first_order.col(static_cast<Eigen::Index>(k)));
      columns.push_back(output.total.col(static_cast<Eigen::Index>(k)));
    }
  }
  Eigen::MatrixXd table(columns.front().size(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t c = 0; c < columns.size(); ++c) table.col(static_cast<Eigen::Index>(c)) = columns[c];
  return io::format_csv(header, table);
}

Json to_json(const Codebook& book, const codebooks::BookStatistics& s) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-stats/1"}, {"inputs", s.inputs}, {"outputs", Json::array()}};
  if (book.has_time()) object["times"] = list(s.times);
  for (const codebooks::OutputStatistics& output : s.outputs) {
    Json one = {{"name", output.name},
                {"unit", output.unit},
                {"mean", list(output.mean)},
                {"deviation", list(output.deviation)}};
    for (std::size_t k = 0; k < s.inputs.size(); ++k) {
      one["first_order"][s.inputs[k]] = list(output.first_order.col(static_cast<Eigen::Index>(k)));
      one["total"][s.inputs[k]] = list(output.total.col(static_cast<Eigen::Index>(k)));
    }
    object["outputs"].push_back(one);
  }
  return object;
}

}  // namespace

int run(const StatsArguments& arguments) {
  const Codebook book = codebooks::load(arguments.book);
  warn_of_missed_tolerance(book, arguments.book);
  const codebooks::BookStatistics statistics = codebooks::statistics_of(book);
  for (const std::string& sentence : statistics.warnings) warn(sentence);
  for (const std::string& sentence : statistics.notes) narrate(sentence);
  if (arguments.json) {
    print(to_json(book, statistics));
  } else {
    print(to_csv(book, statistics));
  }
  return kDone;
}

}  // namespace samara::apps
