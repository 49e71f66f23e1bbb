#include <algorithm>

#include <fmt/format.h>

#include "commands.h"
#include "output.h"
#include "samara/base/errors.h"
#include "samara/codebooks/store.h"
#include "samara/io/csv.h"
#include "samara/pgd/statistics.h"
#include "terminal.h"

namespace samara::apps {

namespace {

using codebooks::Codebook;

/// Of one output: rows are times, or one where there is none.
struct OutputStatistics {
  std::string name, unit;
  Eigen::VectorXd mean, deviation;
  Eigen::MatrixXd first_order, total;  ///< times x inputs
};

struct BookStatistics {
  std::vector<std::string> inputs;
  Eigen::VectorXd times;  ///< empty where there is none
  std::vector<OutputStatistics> outputs;
};

/// Pieces must be slabs of time, each over the whole box: averages over a part of it are none over all.
void require_whole_pieces(const Codebook& book) {
  const std::size_t first = book.has_time() ? 1 : 0;
  for (const codebooks::Piece& piece : book.pieces()) {
    for (std::size_t k = first; k < book.coordinates().size(); ++k) {
      const codebooks::Coordinate& c = book.coordinates()[k];
      if (piece.lower()[k] == c.lower && piece.upper()[k] == c.upper) continue;
      throw ArgumentError(fmt::format(
          "the codebook's box is split along {}: statistics are of codebooks whose pieces are slabs of time",
          c.name));
    }
  }
  if (book.coordinate_count() == static_cast<int>(first))
    throw ArgumentError("the codebook has no free parameter to take statistics over");
}

pgd::Statistics statistics_of(const codebooks::FieldGroup& group, bool has_time) {
  const pgd::StatisticsOptions options{.free_axis = has_time ? group.axes().front().name() : ""};
  return group.train() != nullptr ? pgd::statistics(group.train()->train(), group.axes(), options)
                                  : pgd::statistics(*group.sum(), options);
}

/// Puts the columns from `from` on behind the rows that are there.
void append(Eigen::VectorXd& rows, const Eigen::RowVectorXd& columns, Eigen::Index from) {
  const Eigen::Index before = rows.size(), more = columns.size() - from;
  rows.conservativeResize(before + more);
  rows.tail(more) = columns.tail(more).transpose();
}

BookStatistics statistics_of(const Codebook& book) {
  require_whole_pieces(book);
  BookStatistics result;
  for (const pgd::OutputLabel& output : book.outputs())
    result.outputs.push_back({output.name, output.unit, {}, {}, {}, {}});
  for (std::size_t p = 0; p < book.pieces().size(); ++p) {
    // The lower piece answers where two of them meet.
    const Eigen::Index from = p > 0 ? 1 : 0;
    std::size_t place = 0;
    for (const codebooks::FieldGroup& group : book.pieces()[p].groups()) {
      const pgd::Statistics s = statistics_of(group, book.has_time());
      result.inputs = s.inputs;
      if (place == 0 && book.has_time()) append(result.times, s.free_nodes.transpose(), from);
      for (Eigen::Index o = 0; o < s.mean.rows(); ++o, ++place) {
        OutputStatistics& output = result.outputs[place];
        append(output.mean, s.mean.row(o), from);
        append(output.deviation, s.variance.row(o).cwiseSqrt(), from);
        const Eigen::Index before = output.first_order.rows(), more = s.mean.cols() - from;
        const auto inputs = static_cast<Eigen::Index>(s.inputs.size());
        output.first_order.conservativeResize(before + more, inputs);
        output.total.conservativeResize(before + more, inputs);
        for (Eigen::Index k = 0; k < inputs; ++k) {
          const auto input = static_cast<std::size_t>(k);
          output.first_order.col(k).tail(more) = s.first_order[input].row(o).tail(more).transpose();
          output.total.col(k).tail(more) = s.total[input].row(o).tail(more).transpose();
        }
      }
    }
  }
  return result;
}

std::string to_csv(const Codebook& book, const BookStatistics& s) {
  std::vector<std::string> header;
  std::vector<Eigen::VectorXd> columns;
  if (book.has_time()) {
    header.push_back(fmt::format("{}[{}]", book.coordinates().front().name, book.coordinates().front().unit));
    columns.push_back(s.times);
  }
  for (const OutputStatistics& output : s.outputs) {
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

Json to_json(const Codebook& book, const BookStatistics& s) {
  const auto list = [](const auto& column) { return std::vector<double>(column.begin(), column.end()); };
  Json object = {{"schema", "samara-stats/1"}, {"inputs", s.inputs}, {"outputs", Json::array()}};
  if (book.has_time()) object["times"] = list(s.times);
  for (const OutputStatistics& output : s.outputs) {
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
  const BookStatistics statistics = statistics_of(book);
  if (arguments.json) {
    print(to_json(book, statistics));
  } else {
    print(to_csv(book, statistics));
  }
  return kDone;
}

}  // namespace samara::apps
